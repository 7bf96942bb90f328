/// Which grid of a file is meant. A name may carry an index, "density[1]": the second of the grids of that name.
#pragma once

#include "raysweep/volume/vdb_io.h"

#include <string>

namespace raysweep {

/// The density to work with: the grid called `name`; with an empty name the one called "density", else the only
/// scalar grid. Floats saved as half are floats; a grid of doubles is converted to float.
/// @throw InvalidArgument listing the candidates if there is none or more than one, or if the grid is a level set,
/// holds points, or is of another type.
openvdb::FloatGrid::Ptr selectDensity(const VdbFile& file, const std::string& name = "");

/// As selectDensity, but takes level sets, too, as they are.
openvdb::FloatGrid::Ptr selectScalar(const VdbFile& file, const std::string& name = "");

/// A scalar or colour grid (FloatGrid or Vec3SGrid), for albedo or emission, by name as in selectDensity; with an
/// empty name the one called "density", else the only one. @throw InvalidArgument as selectDensity does.
openvdb::GridBase::ConstPtr selectGrid(const VdbFile& file, const std::string& name);

/// As selectGrid, but takes doubles, too, as floats.
openvdb::GridBase::ConstPtr selectValues(const VdbFile& file, const std::string& name = "");

/// As selectDensity, but expects a level set, and returns its inside as a solid (levelSetToSolid).
/// @throw InvalidArgument as selectDensity does, if the grid is not a level set, and if it has no inside.
openvdb::FloatGrid::Ptr selectLevelSet(const VdbFile& file, const std::string& name = "");

/// As selectDensity, but takes level sets, too, as solids.
openvdb::FloatGrid::Ptr selectSolid(const VdbFile& file, const std::string& name = "");

/// One line per grid, for messages: name (with [n] where it occurs more than once), type, class, active voxels.
std::string listGrids(const VdbFile& file);

}  // namespace raysweep
