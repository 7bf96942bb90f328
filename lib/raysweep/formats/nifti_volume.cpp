#include "raysweep/formats/nifti_volume.h"

#include "raysweep/core/error.h"
#include "raysweep/formats/declared_samples.h"
#include "raysweep/formats/nifti_header.h"
#include "raysweep/formats/read_failure.h"
#include "raysweep/formats/rescale.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

namespace raysweep {
namespace {

/// What a datatype says: numbers of one type, several side by side for colour and complex numbers.
struct VoxelKind {
    SampleType type = SampleType::uint8;
    std::vector<std::string> channels;  ///< names; empty: one number
};

VoxelKind kindOf(const NiftiHeader& header, const std::string& path) {
    VoxelKind kind;
    switch (header.datatype) {
        case 2:
            kind = {SampleType::uint8, {}};
            break;
        case 4:
            kind = {SampleType::int16, {}};
            break;
        case 8:
            kind = {SampleType::int32, {}};
            break;
        case 16:
            kind = {SampleType::float32, {}};
            break;
        case 32:
            kind = {SampleType::float32, {"real", "imaginary"}};
            break;
        case 64:
            kind = {SampleType::float64, {}};
            break;
        case 128:
            kind = {SampleType::uint8, {"red", "green", "blue"}};
            break;
        case 256:
            kind = {SampleType::int8, {}};
            break;
        case 512:
            kind = {SampleType::uint16, {}};
            break;
        case 768:
            kind = {SampleType::uint32, {}};
            break;
        case 1024:
            kind = {SampleType::int64, {}};
            break;
        case 1280:
            kind = {SampleType::uint64, {}};
            break;
        case 1792:
            kind = {SampleType::float64, {"real", "imaginary"}};
            break;
        case 2304:
            kind = {SampleType::uint8, {"red", "green", "blue", "alpha"}};
            break;
        default:
            failRead(path, "in its header: datatype " + std::to_string(header.datatype) +
                               " (bits or floats of 16 bytes, or none at all) cannot be read; convert it to float");
    }
    const std::size_t bits = 8 * sizeOf(kind.type) * std::max<std::size_t>(1, kind.channels.size());
    if (std::size_t(header.bitpix) != bits)
        failRead(path, "in its header: bitpix is " + std::to_string(header.bitpix) + ", but voxels of datatype " +
                           std::to_string(header.datatype) + " have " + std::to_string(bits));
    return kind;
}

std::int64_t sizeAlong(const NiftiHeader& header, std::size_t axis) {
    return std::int64_t(axis) <= header.dim[0] ? header.dim[axis] : 1;
}

/// Colour or complex numbers side by side, then dim[1] to dim[7]. The fifth is of vectors and matrices.
void declareAxes(const NiftiHeader& header, const std::string& path, const VoxelKind& kind, const VolumeChoice& choice,
                 DeclaredSamples& samples) {
    const auto side = std::int64_t(std::max<std::size_t>(1, kind.channels.size()));
    samples.axes.push_back({side, false});
    std::string shape;
    for (std::size_t n = 1; n <= 7; ++n) {
        samples.axes.push_back({sizeAlong(header, n), n <= 3});
        if (n <= 3) shape += (n > 1 ? "x" : "") + std::to_string(sizeAlong(header, n));
    }
    bytesOf(samples, path);
    const double channels = double(side) * double(sizeAlong(header, 5));
    const double volumes = double(sizeAlong(header, 4)) * double(sizeAlong(header, 6)) * double(sizeAlong(header, 7));
    if (channels > std::numeric_limits<std::int32_t>::max() || volumes > std::numeric_limits<std::int32_t>::max())
        failRead(path, "in its header: it promises more volumes than there can be");
    Several several{std::uint64_t(channels), "channels", {}};
    if (side > 1 && side == std::int64_t(channels)) several.name = [&](int n) { return kind.channels[std::size_t(n)]; };
    const std::int64_t channel = chooseChannel(path, several, choice);
    std::int64_t volume = chooseVolume(path, {std::uint64_t(volumes), "volumes of " + shape, {}}, choice);
    samples.axes[0].chosen = channel % side;
    samples.axes[5].chosen = channel / side;
    for (const std::size_t n : {4u, 6u, 7u}) {
        samples.axes[n].chosen = volume % samples.axes[n].size;
        volume /= samples.axes[n].size;
    }
}

/// Columns: directions of i, j, k and the origin, RAS, units of the file.
using Place = std::array<Vec3, 4>;

Place placeOfSform(const NiftiHeader& header) {
    Place place;
    for (std::size_t column = 0; column < 4; ++column)
        place[column] = Vec3(header.srow[0][column], header.srow[1][column], header.srow[2][column]);
    return place;
}

/// Method 2 of nifti1.h.
Place placeOfQform(const NiftiHeader& header, const Vec3& spacing) {
    double b = header.quaternion[0], c = header.quaternion[1], d = header.quaternion[2];
    double a = 1 - (b * b + c * c + d * d);
    if (a < 1e-7) {  // half a turn, and what rounding makes of it
        a = 1 / std::sqrt(b * b + c * c + d * d);
        b *= a, c *= a, d *= a;
        a = 0;
    } else {
        a = std::sqrt(a);
    }
    const double handed = header.pixdim[0] < 0 ? -1 : 1;
    return {Vec3(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)) * spacing.x,
            Vec3(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)) * spacing.y,
            Vec3(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b) * (spacing.z * handed),
            Vec3(header.qoffset[0], header.qoffset[1], header.qoffset[2])};
}

/// True if the corners of the volume are within a hundredth of a voxel of each other in both.
bool sameplace(const Place& one, const Place& other, const Index3& dims) {
    double voxel = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) voxel = std::min(voxel, one[std::size_t(axis)].length());
    for (int corner = 0; corner < 8; ++corner) {
        Vec3 apart = one[3] - other[3];
        for (int axis = 0; axis < 3; ++axis)
            if (corner >> axis & 1)
                apart += (one[std::size_t(axis)] - other[std::size_t(axis)]) * double(dims[axis] - 1);
        if (!(apart.length() < 0.01 * voxel)) return false;
    }
    return true;
}

void placeVolume(const NiftiHeader& header, StoredVolume& volume) {
    Vec3 spacing(1);
    for (int axis = 0; axis < 3; ++axis) {
        const double said = std::abs(header.pixdim[std::size_t(axis) + 1]);
        if (said > 0 && said < 1e12 && axis < int(header.dim[0])) spacing[axis] = said;
        const bool needed = header.sformCode <= 0 && axis < int(header.dim[0]);
        if (needed && spacing[axis] != said)
            volume.notes.push_back(std::string("it does not say how far voxels are apart along ") + "ijk"[axis] +
                                   "; 1 was taken");
    }
    Place place{Vec3(spacing.x, 0, 0), Vec3(0, spacing.y, 0), Vec3(0, 0, spacing.z), Vec3(0)};
    if (header.qformCode > 0) place = placeOfQform(header, spacing);
    if (header.sformCode > 0) {
        const Place other = place;
        place = placeOfSform(header);
        if (header.qformCode > 0 && !sameplace(place, other, volume.dims))
            volume.notes.push_back("its sform and its qform are different places; that of the sform was taken");
    }
    const bool oriented = header.sformCode > 0 || header.qformCode > 0;
    if (!oriented) volume.notes.push_back("it has neither sform nor qform: it does not say which way it lies");
    const int unit = header.units & 7;
    const double millimetres = unit == 1 ? 1000 : unit == 3 ? 1e-3 : 1;
    const double turn = oriented ? -1 : 1;  // from RAS to LPS
    const Vec3 lps = Vec3(turn, turn, 1) * millimetres;
    for (std::size_t axis = 0; axis < 3; ++axis) volume.steps[axis] = place[axis] * lps;
    volume.origin = place[3] * lps;
    volume.unit = "mm";
}

Rescaling rescalingOf(const NiftiHeader& header, const VoxelKind& kind, const std::string& path) {
    Rescaling rescaling;
    if (kind.type == SampleType::uint8 && !kind.channels.empty()) return rescaling;  // not for colours
    if (header.slope == 0 || std::isnan(header.slope)) return rescaling;             // some programs write NaN for none
    if (!std::isfinite(header.slope) || !std::isfinite(header.intercept))
        failRead(path, "in its header: scl_slope or scl_inter is not finite");
    rescaling.slope = header.slope;
    rescaling.intercept = header.intercept;
    return rescaling;
}

}  // namespace

StoredVolume readNifti(const std::string& path, const VolumeChoice& choice, const ProgressCallback& progress) {
    const NiftiHeader header = readNiftiHeader(path);
    const VoxelKind kind = kindOf(header, path);
    const Rescaling rescaling = rescalingOf(header, kind, path);
    DeclaredSamples samples;
    samples.type = kind.type;
    samples.bigEndian = header.bigEndian;
    samples.coding = header.compressed ? SampleCoding::deflate : SampleCoding::raw;
    samples.exact = header.detached;
    declareAxes(header, path, kind, choice, samples);
    samples.pieces.push_back({header.dataFile});
    (header.compressed ? samples.pieces[0].skipUnpacked : samples.pieces[0].skip) = header.offset;
    splitEvenly(samples, path);

    StoredVolume volume = readDeclared(path, samples, progress);
    volume.format = "NIfTI";
    placeVolume(header, volume);
    if (volume.complete) rescale(volume, rescaling);
    return volume;
}

}  // namespace raysweep
