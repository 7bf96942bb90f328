/// Volumes to light in tests, and the ways between grids, dense arrays and the Monte Carlo reference.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raysweep/illuminate/illuminate.h"
#include "support/monte_carlo.h"

namespace raysweep::test {

/// Voxels [0, size) of constant density.
openvdb::FloatGrid::Ptr boxVolume(const Index3& size, float density = 1);

/// 4^3 voxels of `value`, as a grid of that name.
openvdb::FloatGrid::Ptr namedBox(const std::string& name, float value);

/// A ball of density 1 that touches the faces of the voxels [0, edge)^3; a voxel is full if its centre is inside.
openvdb::FloatGrid::Ptr ballVolume(int edge);

/// The library's cloud, densities in [0,1], moved to the corner of [0, edge)^3, which it fits into.
openvdb::FloatGrid::Ptr cloudVolume(int edge);

/// A ball of voxels of random density, spread evenly over the decades from `low` to `high`.
openvdb::FloatGrid::Ptr noiseBall(int radius, double low, double high);

/// A file of the shared test data, or nothing if it is not on this machine: looked for in the folder that the
/// environment variable RAYSWEEP_DATA names, or, if it is not set or empty, in `shared/data` beside the source tree.
std::string findData(const std::string& name);

/// The volume turned by a quarter about `axis`: voxel v of the result is voxel quarterTurnBack(v) of `grid`.
openvdb::FloatGrid::Ptr quarterTurned(const openvdb::FloatGrid& grid, int axis);
/// Turns a vector by a quarter, from the axis after `axis` towards the one after that.
Vec3 quarterTurn(const Vec3& v, int axis);
openvdb::Coord quarterTurn(const openvdb::Coord& v, int axis);

/// A box of voxels as an array; voxel low + (i,j,k) has index (i * size.y + j) * size.z + k.
struct DenseVolume {
    Index3 low{0}, size{0};
    std::vector<double> values;
};

/// The active voxels' bounding box of `shape`, filled with the active values of `grid`, 0 elsewhere.
DenseVolume dense(const openvdb::FloatGrid& grid, const openvdb::FloatGrid& shape);
/// The same for one component of a FloatGrid or Vec3SGrid.
DenseVolume dense(const openvdb::GridBase& grid, const openvdb::FloatGrid& shape, int channel);

/// `scene` for the Monte Carlo solver. Its voxels must be cubes along the axes, its light grey, and it may have one
/// sun.
McScene monteCarloScene(const Scene& scene);

/// How far `radiosity` is from 1 in the active voxels of `density`.
struct Departure {
    double mean = 0, rms = 0;
};
Departure fromOne(const openvdb::GridBase& radiosity, const openvdb::FloatGrid& density, int channel = 0);

/// RMS of a - b over the active voxels of `shape`, relative to the RMS of b.
double relativeDifference(const openvdb::GridBase& a, const openvdb::GridBase& b, const openvdb::FloatGrid& shape);

/// Integral over the volume: world units cubed times a value's unit.
double massOf(const openvdb::FloatGrid& grid);

/// True if both have the same active voxels with the same bits.
bool sameBits(const openvdb::GridBase& a, const openvdb::GridBase& b);

}  // namespace raysweep::test
