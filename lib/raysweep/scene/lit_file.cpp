#include "raysweep/scene/lit_file.h"

#include "raysweep/core/error.h"
#include "raysweep/scene/extremes.h"
#include "raysweep/volume/voxel_check.h"

namespace raysweep {
namespace {

constexpr const char* kVersionKey = "raysweep_version";
constexpr const char* kOptionsKey = "raysweep_options";
constexpr const char* kDensityKey = "raysweep_density";
constexpr const char* kRampKey = "raysweep_ramp";
constexpr const char* kTransferKey = "raysweep_transfer";
constexpr const char* kExchangeKey = "raysweep_exchange";
constexpr const char* kResolutionKey = "raysweep_resolution";
constexpr const char* kExtinctionKey = "raysweep_extinction";

void setMetadata(openvdb::GridBase& grid, const SceneFromFile& made, const LitRecord& record) {
    const auto text = [&](const char* key, const std::string& value) {
        grid.insertMeta(key, openvdb::StringMetadata(value));
    };
    const SceneOrigin& origin = made.origin;
    text(kVersionKey, RAYSWEEP_VERSION);
    text(kOptionsKey, record.options);
    text(kDensityKey, origin.density);
    if (origin.classification) {
        const bool ramp = !origin.classification->ramp.empty();
        text(ramp ? kRampKey : kTransferKey,
             ramp ? origin.classification->ramp : toJson(origin.classification->function));
    }
    text(kExchangeKey, record.exchange);
    grid.insertMeta(kResolutionKey, openvdb::DoubleMetadata(record.resolution));
    // The grid `extinction` that goes with it is the whole of it.
    const double extinction = origin.ownExtinction ? 1 : made.scene.medium.extinctionScale;
    grid.insertMeta(kExtinctionKey, openvdb::DoubleMetadata(extinction));
}

/// Half floats end at 65504. @return number of voxels clamped
std::size_t clampGrid(openvdb::GridBase& grid) {
    if (grid.isType<openvdb::FloatGrid>()) return clampForHalf(static_cast<openvdb::FloatGrid&>(grid));
    return clampForHalf(static_cast<openvdb::Vec3SGrid&>(grid));
}

bool isEmission(const openvdb::GridBase& grid) {
    return grid.getName() == "emission";
}

/// Other subcommands leave their version, too; which density was lit only lighting says.
bool isOfLighting(const openvdb::GridBase& grid) {
    return grid[kVersionKey] && grid[kDensityKey];
}

double numberFrom(const openvdb::Metadata& metadata) {
    if (const auto* number = dynamic_cast<const openvdb::DoubleMetadata*>(&metadata)) return number->value();
    if (const auto* number = dynamic_cast<const openvdb::FloatMetadata*>(&metadata)) return number->value();
    throw InvalidArgument("metadata '" + std::string(kExtinctionKey) + "' of grid 'radiosity' is of type " +
                              metadata.typeName() + ", not a number",
                          Remedy::giveExtinction);
}

}  // namespace

std::vector<Clamped> writeLit(const std::string& path, const VdbFile& input, const SceneFromFile& made,
                              const LitRecord& record, const openvdb::GridPtrVec& results) {
    openvdb::GridCPtrVec grids;
    for (const auto& grid : results)
        if (isEmission(*grid)) grids.push_back(grid);
    grids.insert(grids.end(), input.grids.begin(), input.grids.end());
    if (made.origin.ownExtinction) {
        const auto extinction = extinctionGrid(made.scene.medium);
        requireFiniteResult(*extinction, describeExtremes(made.scene));
        setMetadata(*extinction, made, record);
        grids.push_back(extinction);
    }
    std::vector<Clamped> clamped;
    for (const auto& grid : results) {
        setMetadata(*grid, made, record);
        if (isEmission(*grid)) continue;
        grid->setSaveFloatAsHalf(record.half);
        if (const std::size_t voxels = clampGrid(*grid)) clamped.push_back({grid->getName(), voxels});
        grids.push_back(grid);
    }
    writeVdb(path, grids, input.metadata);
    return clamped;
}

openvdb::GridBase::Ptr litRadiosity(const VdbFile& file) {
    openvdb::GridBase::Ptr radiosity;
    for (const auto& grid : file.grids)
        if (grid->getName() == "radiosity") radiosity = grid;
    return radiosity;
}

openvdb::FloatGrid::Ptr litExtinction(const VdbFile& file) {
    for (const auto& grid : file.grids)
        if (grid->getName() == "extinction" && grid->isType<openvdb::FloatGrid>() && isOfLighting(*grid))
            return openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
    return nullptr;
}

openvdb::GridBase::Ptr litEmission(const VdbFile& file) {
    for (const auto& grid : file.grids)
        if (isEmission(*grid) && isOfLighting(*grid)) return grid;
    return nullptr;
}

std::string litDensity(const openvdb::GridBase& radiosity) {
    const auto density = radiosity[kDensityKey];
    return density ? density->str() : "";
}

std::optional<double> litExtinctionScale(const openvdb::GridBase& radiosity) {
    const auto extinction = radiosity[kExtinctionKey];
    return extinction ? std::optional<double>(numberFrom(*extinction)) : std::nullopt;
}

VdbFile withoutLight(const VdbFile& file) {
    VdbFile rest{file.path, {}, file.metadata};
    const openvdb::GridBase::Ptr extinction = litExtinction(file), emission = litEmission(file);
    for (const auto& grid : file.grids)
        if (grid->getName() != "radiosity" && grid->getName() != "unshot" && grid != extinction && grid != emission)
            rest.grids.push_back(grid);
    return rest;
}

}  // namespace raysweep
