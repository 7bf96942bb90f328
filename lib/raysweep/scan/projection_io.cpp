#include "raysweep/scan/projection_io.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/parallel.h"
#include "raysweep/formats/itk_volume.h"
#include "raysweep/formats/volume_files.h"
#include "raysweep/image/image_io.h"
#include "raysweep/scan/count_type.h"
#include "raysweep/scan/data_exchange.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

const char* const kReadable =
    "MetaImage (.mha, .mhd), NRRD (.nrrd, .nhdr), or pictures (TIFF, EXR, PNG), one for each view";

/// Kinds of files that are at home in a CT scan, or in this program, but hold no projections that this reader knows.
void requireProjections(const std::string& path) {
    const std::string extension = lowerExtension(path);
    const char* what = isHdf5(path)                                  ? "HDF5: counts, not line integrals"
                       : extension == ".xml" || extension == ".json" ? "a geometry"
                       : extension == ".vdb"                         ? "a sparse volume"
                                                                     : nullptr;
    if (what)
        throw InvalidArgument("cannot read projections from '" + path + "': it is " + what + "; give " + kReadable);
    static const std::set<std::string> kKnown = {".mha", ".mhd", ".nrrd", ".nhdr", ".tif", ".tiff",
                                                 ".exr", ".png", ".jpg",  ".jpeg", ".bmp", ".pgm",
                                                 ".nii", ".gz",  ".hdr",  ".img",  ".dcm"};
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored) && !kKnown.count(extension))
        throw IoError("cannot read '" + path + "': it is of no kind that is known; give " + kReadable);
}

Projections converted(const StoredVolume& stored) {
    Projections projections(stored.dims.x, stored.dims.y, stored.dims.z);
    withSampleType(stored.type, [&](auto zero) {
        const auto* from = reinterpret_cast<const decltype(zero)*>(stored.samples.get());
        const std::size_t pixels = projections.pixelsPerView();
        parallelFor(std::size_t(projections.views), [&](std::size_t n) {
            for (std::size_t p = n * pixels; p < (n + 1) * pixels; ++p) projections.values[p] = float(from[p]);
        });
    });
    return projections;
}

double leastOf(const Projections& projections) {
    double least = 0;
    for (const float value : projections.values) least = std::min(least, double(value));
    return least;
}

/// Spacing and origin along the detector's axes, where these are the world's x and y.
void keepPlace(const StoredVolume& stored, ProjectionFile& file) {
    const Vec3 &column = stored.steps[0], &row = stored.steps[1];
    const auto isZero = [](double value, double step) { return std::abs(value) <= 1e-6 * std::abs(step); };
    if (!isZero(column.y, column.x) || !isZero(column.z, column.x) || !isZero(row.x, row.y) || !isZero(row.z, row.y))
        return;
    file.spacing = DetectorPair{column.x, row.y};
    file.origin = DetectorPair{stored.origin.x, stored.origin.y};
}

void requireComplete(const Projections& projections) {
    const auto count = [&] { return projections.pixelsPerView() * std::size_t(projections.views); };
    if (projections.width > 0 && projections.height > 0 && projections.views > 0 &&
        projections.values.size() == count())
        return;
    throw InvalidArgument("projections of " + std::to_string(projections.width) + "x" +
                          std::to_string(projections.height) + " pixels and " + std::to_string(projections.views) +
                          " views with " + std::to_string(projections.values.size()) +
                          " values: all must be positive, and there must be one value for each pixel and view");
}

}  // namespace

void requireMeasured(Projections& projections, const std::string& path, bool repair) {
    const auto isBad = [](float value) { return !std::isfinite(value); };
    if (repair) {
        std::replace_if(projections.values.begin(), projections.values.end(), isBad,
                        std::numeric_limits<float>::quiet_NaN());
        return;
    }
    const ValuesFound bad = findValues(projections, isBad);
    if (bad.count == 0) return;
    throw InvalidArgument("'" + path + "' has " + std::to_string(bad.count) + (bad.count > 1 ? " values" : " value") +
                              " that " + (bad.count > 1 ? "are" : "is") + " NaN or infinite, the first in " +
                              placeOf(projections, bad.first) + " (all counted from 0)",
                          Remedy::leaveOutRays);
}

ProjectionFile readProjections(const std::vector<std::string>& files, const ProjectionReadOptions& options,
                               const ProgressCallback& progress) {
    if (files.empty()) throw InvalidArgument(std::string("no files to read projections from; give ") + kReadable);
    for (const std::string& path : files) requireProjections(path);
    const StoredVolume stored = readVolumeFiles(files, {"", false, {}}, progress);
    if (stored.format == "DICOM" || stored.format == "NIfTI")
        throw InvalidArgument("cannot read projections from '" + files.front() + "': it is " + stored.format +
                              ", which holds volumes; give " + kReadable);
    ProjectionFile file;
    file.format = stored.format;
    file.complete = stored.complete;
    if (!file.complete) return file;
    file.type = stored.type;
    file.projections = converted(stored);
    if (options.unsignedCounts)
        addWrapped(file.projections.values.data(), file.projections.values.size(), file.type);
    else
        requireCounts(leastOf(file.projections), file.type, "'" + files.front() + "'");
    requireMeasured(file.projections, files.front(), options.repair);
    if (stored.format != "pictures") keepPlace(stored, file);
    return file;
}

ProjectionFile fromSinograms(const ProjectionFile& sinograms) {
    const Projections& from = sinograms.projections;
    ProjectionFile file;
    file.format = sinograms.format;
    file.type = sinograms.type;
    file.complete = sinograms.complete;
    file.projections = Projections(from.width, from.views, from.height);
    const auto width = std::size_t(from.width);
    for (int view = 0; view < from.height; ++view)
        for (int row = 0; row < from.views; ++row)
            std::copy_n(from.view(row) + std::size_t(view) * width, width,
                        file.projections.view(view) + std::size_t(row) * width);
    if (sinograms.spacing) {
        const double pitch = (*sinograms.spacing)[0];
        file.spacing = DetectorPair{pitch, std::abs(pitch)};
        file.origin = DetectorPair{(*sinograms.origin)[0], -0.5 * std::abs(pitch) * (from.views - 1)};
    }
    return file;
}

std::vector<std::string> projectionFiles(const std::string& path, int views) {
    if (imageFormat(path) != ImageFormat::Exr) return {path};
    const std::size_t digits = std::max<std::size_t>(4, std::to_string(views).size());
    const fs::path whole(path);
    std::vector<std::string> files;
    for (int n = 1; n <= views; ++n) {
        std::string number = std::to_string(n);
        number.insert(0, digits - number.size(), '0');
        files.push_back(
            (whole.parent_path() / (whole.stem().string() + "_" + number + whole.extension().string())).string());
    }
    return files;
}

void writeProjections(const std::string& path, const Projections& projections,
                      const std::optional<DetectorPair>& spacing, const std::optional<DetectorPair>& origin) {
    requireComplete(projections);
    const int width = projections.width, height = projections.height;
    if (lowerExtension(path) == ".mha") {
        const DetectorPair step = spacing.value_or(DetectorPair{1, 1});
        const DetectorPair start =
            origin.value_or(DetectorPair{-0.5 * (width - 1) * step[0], -0.5 * (height - 1) * step[1]});
        writeMetaImage(path, Index3(width, height, projections.views), projections.values.data(),
                       Vec3(start[0], start[1], 0), Vec3(step[0], step[1], 1));
        return;
    }
    if (imageFormat(path) != ImageFormat::Exr)
        throw IoError("cannot write '" + path + "': the extension '" + lowerExtension(path) +
                      "' is not known for projections; use .mha, or .exr for numbered pictures");
    const std::vector<std::string> files = projectionFiles(path, projections.views);
    for (int n = 0; n < projections.views; ++n) {
        Image image(width, height, 1);
        std::copy_n(projections.view(n), image.pixels.size(), image.pixels.begin());
        writeImage(files[std::size_t(n)], image);
    }
}

}  // namespace raysweep
