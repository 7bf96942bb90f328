/// Files of lit volumes: all grids of the input, and besides them `radiosity`, `unshot` where there is unshot power,
/// `emission` where something shines by itself, and `extinction` where it is no multiple of a grid of the input.
/// Metadata of these say how they came about. All that is known of such files is known here.
#pragma once

#include "raysweep/scene/scene_io.h"
#include "raysweep/volume/vdb_io.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// How a volume was lit, besides what its scene came from.
struct LitRecord {
    std::string options;    ///< all of the program's options, so that the same can be made again
    std::string exchange;   ///< what voxels and rays exchanged
    double resolution = 1;  ///< at which it was solved
    bool half = false;      ///< results are saved as half floats
};

/// Voxels of a result that were set to the largest half float.
struct Clamped {
    std::string grid;
    std::size_t voxels = 0;
};

/// Writes the grids of `input`, what was lit where `made.origin` says that the file must hold it, and `results`
/// (radiosity, unshot, emission), which get metadata. All but emission, whose values have no scale of their own, are
/// clamped if they are to be saved as half floats. Emission stands before a grid of that name of the input: other
/// programs take the first.
/// @return the results in which voxels were clamped
/// @throw IoError as writeVdb does
std::vector<Clamped> writeLit(const std::string& path, const VdbFile& input, const SceneFromFile& made,
                              const LitRecord& record, const openvdb::GridPtrVec& results);

/// The grid `radiosity` of a lit file; null if there is none.
openvdb::GridBase::Ptr litRadiosity(const VdbFile& file);

/// The extinction that was written along, where it is no multiple of the density; null if there is none. A grid of that
/// name that was the user's own is not meant.
openvdb::FloatGrid::Ptr litExtinction(const VdbFile& file);

/// The grid `emission` of a lit file, what shines by itself, W/world unit^3; null if there is none. A grid of that name
/// that was the user's own is not meant.
openvdb::GridBase::Ptr litEmission(const VdbFile& file);

/// By which name the grid that was lit is chosen, as metadata of `radiosity` say; empty if they do not.
std::string litDensity(const openvdb::GridBase& radiosity);

/// Extinction per unit density, 1/world unit, as metadata of `radiosity` say; none if they do not.
/// @throw InvalidArgument if it is no number
std::optional<double> litExtinctionScale(const openvdb::GridBase& radiosity);

/// The grids of `file` without those that lighting adds.
VdbFile withoutLight(const VdbFile& file);

}  // namespace raysweep
