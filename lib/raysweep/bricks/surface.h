/// Surfaces of solids: which voxels are part of one, and its normal there.
#pragma once

#include "raysweep/bricks/brick_map.h"
#include "raysweep/bricks/bricks.h"

#include <cstdint>
#include <vector>

namespace raysweep {

/// A unit vector in 32 bits: ten for each component, in steps of 1/511, and one that tells it from "no surface", 0.
using PackedNormal = std::uint32_t;
constexpr float kPackedSteps = 511;

PackedNormal packNormal(const Vec3& unit);
/// Unit length but for rounding.
Vec3 unpackNormal(PackedNormal normal);

struct alignas(64) NormalBrick {
    PackedNormal normal[kBrickVoxels] = {0};
};

constexpr std::uint32_t kNoSurface = 0xffffffffu;

/// Normals (outwards, world space) of surface voxels; kept for the bricks that have any.
struct Surfaces {
    std::vector<std::uint32_t> slots;  ///< for each brick its place in `bricks`, or kNoSurface
    std::vector<NormalBrick> bricks;

    bool empty() const { return bricks.empty(); }
    /// The 512 normals of brick `b`, or null if it has no surface voxel.
    const PackedNormal* normals(std::size_t b) const {
        return empty() || slots[b] == kNoSurface ? nullptr : bricks[slots[b]].normal;
    }
};

/// Where opacity, 1 - exp(-tau `perVoxel`), changes by more than `threshold` per voxel there is a surface.
struct SurfaceCriterion {
    double perVoxel, threshold;
};

/// Voxels that are not empty and meet the criterion; the normal points to where opacity falls. Opacity and not
/// extinction, because that is what a partly filled voxel has part of: the logarithm in extinction would let the
/// fullest neighbour alone decide.
Surfaces findSurfaces(const BrickLayout& layout, const BrickMap& map, const BrickField& tau, const Periodic& periodic,
                      const SurfaceCriterion& criterion);

std::size_t countSurfaceVoxels(const Surfaces& surfaces);

/// The normals of brick `b`, to be written; makes room for them.
PackedNormal* addSurfaceBrick(Surfaces& surfaces, std::size_t brickCount, std::size_t b);

}  // namespace raysweep
