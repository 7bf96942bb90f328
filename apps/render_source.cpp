#include "render_source.h"

#include "cli.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/classify.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/vdb_io.h"

#include <cmath>

namespace raysweep::apps {
namespace {

double numberFrom(const openvdb::Metadata& metadata) {
    if (const auto* number = dynamic_cast<const openvdb::DoubleMetadata*>(&metadata)) return number->value();
    if (const auto* number = dynamic_cast<const openvdb::FloatMetadata*>(&metadata)) return number->value();
    throw InvalidArgument("metadata 'raysweep_extinction' of grid 'radiosity' is of type " + metadata.typeName() +
                          ", not a number; give --extinction");
}

RenderInput selectInput(const RenderSource& a, const VdbFile& file) {
    requireOriginal(file);
    openvdb::GridBase::ConstPtr radiosity;
    for (const auto& grid : file.grids)
        if (grid->getName() == "radiosity") radiosity = grid;
    if (!radiosity)
        throw InvalidArgument("'" + file.path + "' has no grid 'radiosity': run 'raysweep light " + file.path +
                              " -o LIT.vdb' first and render LIT.vdb");
    // A file that was lit with a transfer function holds the extinction itself.
    const openvdb::FloatGrid::Ptr written = writtenExtinction(file);
    if (written && a.density.empty() && !a.extinction && !a.transfer.given()) return {written, 1, radiosity};
    std::string name = a.density;
    const auto litDensity = (*radiosity)["raysweep_density"], litExtinction = (*radiosity)["raysweep_extinction"];
    if (name.empty() && litDensity) name = litDensity->str();
    RenderInput input;
    input.density = selectDensity(withoutLight(file), name);
    input.radiosity = radiosity;
    input.extinctionScale = a.extinction ? *a.extinction : litExtinction ? numberFrom(*litExtinction) : 1.0;
    if (const auto function = transferFunction(a.transfer))
        input = {classify(*input.density, *function).extinction, 1, radiosity};
    return input;
}

openvdb::Vec3f colourOf(float value) {
    return openvdb::Vec3f(value);
}
openvdb::Vec3f colourOf(const openvdb::Vec3f& value) {
    return value;
}

/// Adds `factor` times the active values of `grid`, or of their means with `grey`, to `sum`.
void addTo(openvdb::Vec3SGrid& sum, const openvdb::GridBase& grid, const openvdb::Vec3f& factor, bool grey) {
    auto to = sum.getAccessor();
    withTypedGrid(grid, [&](const auto& typed) {
        for (auto on = typed.cbeginValueOn(); on; ++on) {
            openvdb::Vec3f value = colourOf(*on);
            if (grey) value = openvdb::Vec3f((value[0] + value[1] + value[2]) / 3);
            to.setValue(on.getCoord(), to.getValue(on.getCoord()) + value * factor);
        }
    });
}

/// Radiosity with what is still unshot as light of one colour: the power of a voxel over the face of a voxel and a half
/// space.
openvdb::GridBase::ConstPtr withUnshot(const VdbFile& file, const openvdb::GridBase& radiosity, const Color& tint) {
    const auto unshot = selectGrid(file, "unshot");
    if (unshot->transform() != radiosity.transform())
        throw InvalidArgument("'" + file.path +
                              "': --unshot needs unshot power and radiosity on the same voxels; light "
                              "it without --upsample");
    const double edge = std::cbrt(radiosity.transform().voxelVolume());
    auto sum = openvdb::Vec3SGrid::create(openvdb::Vec3f(0));
    sum->setTransform(radiosity.transform().copy());
    addTo(*sum, radiosity, openvdb::Vec3f(1), false);
    addTo(*sum, *unshot, openvdb::Vec3f(tint.x, tint.y, tint.z) / float(kPi * edge * edge), true);
    return sum;
}

}  // namespace

void addRenderSource(CLI::App& app, RenderSource& a) {
    app.option_defaults()->group("Volume");
    app.add_option("--density", a.density, "Density grid (default: the one that was lit)")->type_name("NAME");
    auto* const extinction = app.add_option(
        "--extinction", a.extinction, "Extinction per unit density, 1/world unit (default: as it was lit, else 1)");
    addTransferOptions(app, a.transfer, extinction);
    app.add_option("--unshot", a.unshot, "Show power that is still unshot, too, as light of this colour")
        ->type_name("R,G,B");
}

void requireRenderSource(const RenderSource& a) {
    if (a.extinction) requireFactor(*a.extinction, "--extinction");
    if (!a.unshot.empty()) parseColor(a.unshot, "--unshot");
    parseRamp(a.transfer);
}

RenderInput renderInput(const RenderSource& a) {
    const VdbFile file = readVdb(a.input);
    RenderInput input = selectInput(a, file);
    if (!a.unshot.empty()) input.radiosity = withUnshot(file, *input.radiosity, parseColor(a.unshot, "--unshot"));
    return input;
}

}  // namespace raysweep::apps
