/// The scene of the paper's figures 2, 3, 6 and 7 (Dachille, Mueller, Kaufman 2000): an engine in a box with
/// translucent walls, half of whose ceiling is an area light.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

#include <optional>
#include <utility>

namespace raysweep {

struct EngineRoomOptions {
    openvdb::FloatGrid::ConstPtr engine;        ///< what stands in the room, density >= 0; null: makeEngineBlock
    std::optional<std::pair<int, int>> slices;  ///< of the engine, k from first to last, that are taken
    int size = 0;            ///< longest edge of the room, voxels; 0: engine's own voxels, or 276 without an engine
    int wall = 4;            ///< thickness of the walls, voxels, in [2,64]
    bool openFront = false;  ///< without the wall at y's lower end
    bool coloured = false;   ///< makes `albedo`
    double voxelSize = 0;    ///< without an engine: edge of a voxel, world units; 0: the longest edge is 2 units
    double radiance = 1;     ///< of the light, W/m^2/sr

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// The room is 2 wall + 12 voxels longer than the engine's box along each axis: 6 voxels of air on each of the four
/// sides, 12 above; the engine stands on the floor. Voxel (0,0,0) is the room's first. For the scan of 256x256x110
/// voxels that the paper used that makes its 276x276x130, and for 128x128x55 its 148x148x75.
///
/// The engine's box: along i and j that of its active voxels; along k from the first to the last slice in which any
/// value reaches a tenth of the largest, and two slices of air (the scan has 108 slices with something in them; the
/// paper's 110 had two empty ones). With `slices` just those. The engine keeps its place in the world, and its voxels.
struct EngineRoom {
    openvdb::FloatGrid::Ptr density;   ///< "density": the engine's values; walls kWallDensity
    openvdb::FloatGrid::Ptr emission;  ///< "emission", W/unit^3, in the lit voxels of the ceiling's lowest layer only
    openvdb::Vec3SGrid::Ptr albedo;    ///< "albedo" of all active voxels; null unless `coloured`
    openvdb::Coord dims;               ///< of the room, voxels
    openvdb::Coord engineDims;         ///< of the engine's box
    double lightArea = 0;              ///< world units^2
    double lightPower = 0;             ///< pi radiance lightArea, W: what a Lambertian emitter sends to one side
};

/// Density of walls: with a transfer function that rises to opaque from 0.2 to 1 they let through little.
constexpr float kWallDensity = 0.9f;

/// The light covers the left half (low i) of the ceiling, but for a round hole in its middle whose diameter is half of
/// the light's shorter edge. A voxel is lit or not, by its centre.
/// @throw InvalidArgument for options out of bounds, an engine without positive values, with negative or infinite ones,
/// larger than 4096 voxels, or coarser than `size` asks.
EngineRoom makeEngineRoom(const EngineRoomOptions& options);

}  // namespace raysweep
