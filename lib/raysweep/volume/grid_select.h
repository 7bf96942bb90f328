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

/// A scalar or colour grid (FloatGrid or Vec3SGrid), for albedo or emission, by name as in selectDensity; with an
/// empty name the one called "density", else the only one. @throw InvalidArgument as selectDensity does.
openvdb::GridBase::ConstPtr selectGrid(const VdbFile& file, const std::string& name);

/// A fog volume for the inside of a level set: 1 inside, a linear ramp to 0 over its narrow band, nothing outside.
/// The argument is left as it is.
openvdb::FloatGrid::Ptr levelSetToFog(const openvdb::FloatGrid& levelSet);

/// As selectDensity, but expects a level set and returns it as fog.
/// @throw InvalidArgument as selectDensity does, and if the grid is not a level set.
openvdb::FloatGrid::Ptr selectLevelSetAsFog(const VdbFile& file, const std::string& name = "");

/// One line per grid, for messages: name (with [n] where it occurs more than once), type, class, active voxels.
std::string listGrids(const VdbFile& file);

}  // namespace raysweep
