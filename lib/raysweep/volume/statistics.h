/// What a grid's values range over, and how much two grids differ.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

#include <cstdint>
#include <vector>

namespace raysweep {

/// Range of the active values, per channel; NaN and infinities are counted, not ranged.
struct ValueRange {
    std::vector<float> min, max;  ///< one entry per channel; empty if there is no finite active value
    std::uint64_t notFinite = 0;  ///< active voxels with a NaN or infinity in any channel
};

/// True for the types that valueRange and compareGrids know: FloatGrid and Vec3SGrid.
bool hasKnownValues(const openvdb::GridBase& grid);

/// @throw InvalidArgument if the grid is neither a FloatGrid nor a Vec3SGrid.
ValueRange valueRange(const openvdb::GridBase& grid);

/// World position of the middle of the box around the active voxels, of which there must be some.
Vec3 middleOf(const openvdb::FloatGrid& grid);

/// Differences of two grids over the union of their active voxels; where only one is active the other counts with
/// the value it has there. Channels are averaged. If their voxels do not coincide, the one with the larger voxels is
/// interpolated linearly, in world space, at the active voxels of the other, and these are compared.
struct GridDifference {
    enum class Resampled { none, grid, reference };
    Resampled resampled = Resampled::none;  ///< which of the two was interpolated
    std::uint64_t voxels = 0;               ///< that were compared
    double rmse = 0;                        ///< root of the mean squared difference; NaN if any value is not finite
    double relativeRmse = 0;  ///< rmse over the root mean square of the second grid; infinite if that is 0
    double psnr = 0;          ///< 20 log10(largest |value| of the second grid / rmse), dB; infinite when equal
    double max = 0;           ///< largest absolute difference
    openvdb::Coord maxAt;     ///< voxel where it is, the first in the tree's order; of the grid that was not resampled
};

/// @param reference what relativeRmse and psnr refer to. Of voxels equally large, those of the reference count.
/// @throw InvalidArgument if types differ or are neither FloatGrid nor Vec3SGrid, if the transforms differ and one is
/// not linear, or if there is no active voxel to compare at.
GridDifference compareGrids(const openvdb::GridBase& grid, const openvdb::GridBase& reference);

}  // namespace raysweep
