#include "raysweep/formats/volume_import.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"
#include "raysweep/formats/stored_grid.h"
#include "raysweep/formats/volume_files.h"

#include <cmath>
#include <limits>
#include <sstream>

namespace raysweep {
namespace {

std::string textOf(const Vec3& v) {
    std::ostringstream text;
    text << v.x << ", " << v.y << ", " << v.z;
    return text.str();
}
std::string textOf(const Index3& v) {
    return std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z);
}

StoredVolume read(const std::vector<std::string>& files, const ImportOptions& options,
                  const ProgressCallback& progress) {
    if (files.empty()) throw InvalidArgument("there is no file to import");
    const VolumeChoice choice{options.channel, options.volumeIndex};
    if (!options.raw) return readVolumeFiles(files, {options.series, !options.spacing, choice}, progress);
    if (files.size() > 1)
        throw InvalidArgument("raw samples must be in one file, not in " + std::to_string(files.size()) +
                              "; join them first");
    chooseChannel(files.front(), {}, choice);
    chooseVolume(files.front(), {}, choice);
    return readRawVolume(files.front(), *options.raw, progress);
}

void setSpacing(StoredVolume& volume, const std::optional<Vec3>& spacing) {
    for (int axis = 0; axis < 3; ++axis) {
        Vec3& step = volume.steps[std::size_t(axis)];
        if (spacing && step.length() > 0) step *= (*spacing)[axis] / step.length();
    }
    const Vec3 cross = volume.steps[0].cross(volume.steps[1]);
    const double lengths = volume.steps[0].length() * volume.steps[1].length() * volume.steps[2].length();
    if (!(std::abs(cross.dot(volume.steps[2])) > 1e-6 * lengths))  // the axes lie in one plane, or are no numbers
        throw InvalidArgument("the file's axes span no volume: steps (" + textOf(volume.steps[0]) + "), (" +
                                  textOf(volume.steps[1]) + "), (" + textOf(volume.steps[2]) + ")",
                              Remedy::giveSpacing);
    constexpr double kLeast = 1e-14;  // what OpenVDB takes for a transform, and a little more
    if (std::abs(cross.dot(volume.steps[2])) < kLeast)
        throw InvalidArgument("the file's voxels are too small for a grid, steps (" + textOf(volume.steps[0]) + "), (" +
                                  textOf(volume.steps[1]) + "), (" + textOf(volume.steps[2]) + ")",
                              Remedy::giveSpacing);
    if (!std::isfinite(lengths + volume.origin.length()))
        throw InvalidArgument("the file's place, " + textOf(volume.origin) + ", is not finite");
}

IndexBox regionOf(const StoredVolume& volume, const std::optional<IndexBox>& crop) {
    const Index3 last = volume.dims - Index3(1);
    if (!crop) return {Index3(0), last};
    for (int axis = 0; axis < 3; ++axis)
        if (crop->low[axis] > last[axis] || crop->high[axis] > last[axis])
            throw InvalidArgument("crop from (" + textOf(crop->low) + ") to (" + textOf(crop->high) +
                                  ") reaches out of the volume, whose last voxel is (" + textOf(last) + ")");
    return *crop;
}

void requireFinite(const SampleRange& range, bool repair) {
    if (range.notFinite == 0 || repair) return;
    const bool one = range.notFinite == 1;
    throw InvalidArgument(std::to_string(range.notFinite) + " voxel" + (one ? " is" : "s are") +
                              " infinite or not a number" + (one ? ": " : ", the first of them ") + "(" +
                              textOf(range.firstNotFinite) + "); repair the file",
                          Remedy::repairVoxels);
}

/// Sets `scale` and `offset` of the result.
void chooseMapping(const ImportOptions& options, const StoredVolume& volume, ImportedVolume& result) {
    Normalization how = options.normalization;
    if (how == Normalization::automatic) {
        const bool wanted = isUnsigned(result.type) && !volume.calibrated && !options.scale && !options.offset;
        how = wanted ? Normalization::type : Normalization::none;
    }
    if (how == Normalization::type && isFloatingPoint(result.type))
        throw InvalidArgument("the samples are " + nameOf(result.type) +
                              ", a type without a range of its own; normalise by the data's range");
    double low = 0, high = 1;
    if (how == Normalization::type)
        low = lowestOf(result.type), high = volume.highest > 0 ? volume.highest : highestOf(result.type);
    if (how == Normalization::data) low = result.range.min, high = result.range.max;
    if (!(high > low)) high = low + 1;  // all samples are the same: they become 0
    result.scale = options.scale.value_or(1) / (high - low);
    result.offset = options.offset.value_or(0) - low * result.scale;
    constexpr double kLargest = std::numeric_limits<float>::max();
    for (const double sample : {result.range.min, result.range.max})
        if (!(std::abs(sample * result.scale + result.offset) <= kLargest))
            throw InvalidArgument("values up to " + std::to_string(sample * result.scale + result.offset) +
                                  " do not fit 32 bit floats; scale them down");
}

}  // namespace

void ImportOptions::validate() const {
    constexpr double kLargest = std::numeric_limits<float>::max();
    requireField(tolerance >= 0 && std::isfinite(tolerance), "tolerance", tolerance, "finite and not negative");
    requireField(std::abs(background) <= kLargest, "background", background, "finite, and fit a 32 bit float");
    requireField(!channel || *channel >= 0, "channel", channel.value_or(0), "0 or larger");
    requireField(!volumeIndex || *volumeIndex >= 0, "volumeIndex", volumeIndex.value_or(0), "0 or larger");
    requireField(!scale || std::isfinite(*scale), "scale", scale.value_or(0), "finite");
    requireField(!offset || std::isfinite(*offset), "offset", offset.value_or(0), "finite");
    for (int axis = 0; axis < 3; ++axis) {
        if (spacing)
            requireField((*spacing)[axis] > 0 && std::isfinite((*spacing)[axis]), "spacing", (*spacing)[axis],
                         "larger than 0");
        if (!crop) continue;
        requireField(crop->low[axis] >= 0, "crop", crop->low[axis], "0 or larger");
        requireField(crop->high[axis] >= crop->low[axis], "crop", crop->high[axis], "not less than where it begins");
    }
}

ImportedVolume importVolume(const std::vector<std::string>& files, const ImportOptions& options,
                            const ProgressCallback& progress) {
    options.validate();
    StoredVolume volume = read(files, options, progress);
    ImportedVolume result;
    if (!volume.complete) return result;
    setSpacing(volume, options.spacing);
    const IndexBox region = regionOf(volume, options.crop);

    result.format = volume.format;
    result.type = volume.type;
    result.dims = volume.dims;
    result.origin = volume.origin;
    result.unit = volume.unit;
    result.notes = volume.notes;
    for (int axis = 0; axis < 3; ++axis) result.spacing[axis] = volume.steps[std::size_t(axis)].length();
    result.range = sampleRange(volume, region);
    requireFinite(result.range, options.repair);
    chooseMapping(options, volume, result);

    const VoxelMapping mapping{result.scale, result.offset, float(options.background), float(options.tolerance)};
    result.grid = gridOf(volume, region, mapping, progress);
    if (!result.grid) return result;
    result.grid->setName(options.name);
    result.grid->insertMeta("raysweep_import_scale", openvdb::DoubleMetadata(result.scale));
    result.grid->insertMeta("raysweep_import_offset", openvdb::DoubleMetadata(result.offset));
    return result;
}

}  // namespace raysweep
