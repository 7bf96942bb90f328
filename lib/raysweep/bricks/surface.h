/// Surfaces of solids: which voxels are part of one, and its normal there.
#pragma once

#include "raysweep/bricks/brick_map.h"
#include "raysweep/bricks/bricks.h"

#include <bitset>
#include <cstdint>
#include <vector>

namespace raysweep {

/// What a voxel is as regards solids, in 32 bits. Of a surface: its normal, a unit vector, ten bits for each component
/// in steps of 1/511, and kSurfaceBit; otherwise kInsideSolid, or 0 for a medium.
using PackedNormal = std::uint32_t;
constexpr float kPackedSteps = 511;
constexpr PackedNormal kSurfaceBit = 1u << 30, kInsideSolid = 1u << 31;

inline bool isSurface(PackedNormal normal) {
    return (normal & kSurfaceBit) != 0;
}

PackedNormal packNormal(const Vec3& unit);
/// Unit length but for rounding.
Vec3 unpackNormal(PackedNormal normal);

struct alignas(64) NormalBrick {
    PackedNormal normal[kBrickVoxels] = {0};
};

using VoxelMarks = std::bitset<kBrickVoxels>;

constexpr std::uint32_t kNoSurface = 0xffffffffu;

/// Normals (outwards, world space) of surface voxels; kept for the bricks that have any.
struct Surfaces {
    std::vector<std::uint32_t> slots;  ///< for each brick its place in `bricks`, or kNoSurface
    std::vector<NormalBrick> bricks;
    std::vector<VoxelMarks> inside;  ///< of every brick the voxels inside of solids; empty: there are none

    /// Many voxels look like a surface and are none, or face another one closely: the local furnace cannot be trusted.
    bool mixed = false;

    bool empty() const { return bricks.empty(); }
    /// The 512 normals of brick `b`, or null if it has no surface voxel.
    const PackedNormal* normals(std::size_t b) const {
        return empty() || slots[b] == kNoSurface ? nullptr : bricks[slots[b]].normal;
    }
    bool isInside(std::size_t b, int i) const { return !inside.empty() && inside[b][std::size_t(i)]; }
};

/// Where opacity, 1 - exp(-tau `perVoxel`), averaged over neighbours, changes by more than `threshold` per voxel there
/// may be a surface.
struct SurfaceCriterion {
    double perVoxel, threshold;
};

/// Voxels that are not empty, meet the criterion with what is opaque behind them, and those inside. The normal points
/// to where opacity falls. Opacity and not extinction, because that is what a partly filled voxel has part of: the
/// logarithm in extinction would let the fullest neighbour alone decide. Soft and noisy solids have few surfaces or
/// none (docs/illumination.md).
Surfaces findSurfaces(const BrickLayout& layout, const BrickMap& map, const BrickField& tau, const Periodic& periodic,
                      const SurfaceCriterion& criterion);

std::size_t countSurfaceVoxels(const Surfaces& surfaces);

/// The normals of brick `b`, to be written; makes room for them.
PackedNormal* addSurfaceBrick(Surfaces& surfaces, std::size_t brickCount, std::size_t b);

}  // namespace raysweep
