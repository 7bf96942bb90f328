#include "raysweep/render/lit_volume.h"

#include "raysweep/core/require.h"
#include "raysweep/scene/lit_file.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/channels.h"
#include "raysweep/volume/classify.h"
#include "raysweep/volume/color_volume.h"
#include "raysweep/volume/cycles_export.h"
#include "raysweep/volume/grid_select.h"

#include <cmath>

namespace raysweep {
namespace {

/// What shines: what light has made, else the volume's own colours.
openvdb::GridBase::ConstPtr requireRadiosity(const VdbFile& file) {
    if (const auto radiosity = litRadiosity(file)) return radiosity;
    if (const auto color = colorGrid(file)) return color;
    InvalidArgument error("'" + file.path + "' has no grid 'radiosity'", Remedy::lightFirst);
    error.subject = file.path;
    throw error;
}

/// The smoke and what is scattered in it.
RenderInput selectInput(const VdbFile& file, const LitVolumeOptions& options) {
    const openvdb::GridBase::ConstPtr radiosity = requireRadiosity(file);
    // A file that was lit with a transfer function holds the extinction itself.
    const openvdb::FloatGrid::Ptr written = litExtinction(file);
    if (written && options.density.empty() && !options.extinction && !options.transfer)
        return {written, 1, radiosity, nullptr};
    const std::string name = options.density.empty() ? litDensity(*radiosity) : options.density;
    const openvdb::FloatGrid::Ptr density = selectDensity(withoutLight(file), name);
    if (options.transfer) return {classify(*density, *options.transfer).extinction, 1, radiosity, nullptr};
    const auto extinction = options.extinction ? options.extinction : litExtinctionScale(*radiosity);
    return {density, extinction.value_or(1), radiosity, nullptr};
}

/// Adds `factor` times the active values of `grid`, or of their means with `grey`, to `sum`.
void addTo(openvdb::Vec3SGrid& sum, const openvdb::GridBase& grid, const openvdb::Vec3f& factor, bool grey) {
    auto to = sum.getAccessor();
    withTypedGrid(grid, [&](const auto& typed) {
        forEachActive(typed, [&](const auto& value, const openvdb::CoordBBox& box) {
            openvdb::Vec3f color(channel(value, 0), channel(value, 1), channel(value, 2));
            if (grey) color = openvdb::Vec3f((color[0] + color[1] + color[2]) / 3);
            for (const openvdb::Coord& at : box) to.setValue(at, to.getValue(at) + color * factor);
        });
    });
}

/// Radiosity with what is still unshot as light of one colour: the power of a voxel over the face of a voxel and a half
/// space.
openvdb::GridBase::ConstPtr withUnshot(const VdbFile& file, const openvdb::GridBase& radiosity, const Color& tint) {
    const auto unshot = selectGrid(file, "unshot");
    if (unshot->transform() != radiosity.transform())
        throw InvalidArgument("'" + file.path + "': unshot power and radiosity are needed on the same voxels",
                              Remedy::keepVoxels);
    const double edge = std::cbrt(radiosity.transform().voxelVolume());
    auto sum = openvdb::Vec3SGrid::create(openvdb::Vec3f(0));
    sum->setTransform(radiosity.transform().copy());
    addTo(*sum, radiosity, openvdb::Vec3f(1), false);
    addTo(*sum, *unshot, openvdb::Vec3f(tint.x, tint.y, tint.z) / float(kPi * edge * edge), true);
    return sum;
}

}  // namespace

void LitVolumeOptions::validate() const {
    if (extinction)
        requireField(*extinction >= 0 && std::isfinite(*extinction), "extinction", *extinction,
                     "finite and not negative");
    if (transfer) transfer->validate();
    for (int c = 0; unshot && c < 3; ++c)
        requireField((*unshot)[c] >= 0 && std::isfinite((*unshot)[c]), "unshot", (*unshot)[c],
                     "finite and not negative");
}

RenderInput litVolume(const VdbFile& file, const LitVolumeOptions& options) {
    options.validate();
    requireOriginal(file);
    RenderInput input = selectInput(file, options);
    input.emission = litEmission(file);
    if (options.unshot) input.radiosity = withUnshot(file, *input.radiosity, *options.unshot);
    return input;
}

}  // namespace raysweep
