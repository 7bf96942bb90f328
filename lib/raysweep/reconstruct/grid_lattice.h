/// The voxels of a reconstruction as columns, and how other volumes lie on them.
#pragma once

#include "raysweep/projector/column_volume.h"
#include "raysweep/projector/joseph.h"
#include "raysweep/reconstruct/reconstruction_grid.h"

#include <optional>

namespace raysweep {

/// The voxels of `grid` in the columns that projecting along `geometry` asks for.
ColumnLattice latticeOf(const ReconstructionGrid& grid, const ProjectionGeometry& geometry);

/// The index of the voxel of `volume` that is where voxel (0,0,0) of `grid` is; none unless the voxels of both coincide
/// everywhere in `grid`.
std::optional<openvdb::Coord> shiftTo(const openvdb::FloatGrid& volume, const ReconstructionGrid& grid);

/// The same. @throw InvalidArgument if there is none. @param what the volume is, "initial" for instance
openvdb::Coord requireShift(const openvdb::FloatGrid& volume, const ReconstructionGrid& grid, const char* what);

/// RMS difference over all voxels of the lattice, which both have; those that are not kept are 0.
double rmsDifference(const ColumnVolume& volume, const ColumnVolume& reference);

/// The same of a volume on voxels (0,0,0) to `dims`, which are voxels `shift` on of the reference; inactive ones are 0.
double rmsDifference(const openvdb::FloatGrid& volume, const openvdb::FloatGrid& reference, const Index3& dims,
                     const openvdb::Coord& shift);

}  // namespace raysweep
