#include "raysweep/bricks/surface.h"

#include "raysweep/bricks/gradient.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

constexpr int kBits = 10;
constexpr PackedNormal kComponent = (1u << kBits) - 1, kPresent = 1u << (3 * kBits);

/// @param opacity changed from tau to opacity  @return true if the brick has a surface voxel
bool findInBrick(const BrickLayout& layout, PaddedBrick<float> opacity, const SurfaceCriterion& criterion,
                 NormalBrick& normals) {
    const Matrix3 indexFromWorld = layout.worldFromIndex.inverse();
    const double edge = std::cbrt(layout.voxelVolume);
    float* const values = &opacity.value[0][0][0];
    std::transform(values, values + sizeof opacity.value / sizeof *values, values,
                   [&](float t) { return float(-std::expm1(-double(t) * criterion.perVoxel)); });
    bool any = false;
    for (int i = 0; i < kBrickVoxels; ++i) {
        const Index3 v = voxelInBrick(i);
        if (opacity.at(v.x, v.y, v.z) == 0) continue;
        const Vec3 gradient = worldGradient(gradientAt(opacity, v.x, v.y, v.z), indexFromWorld);
        const double length = gradient.length();
        if (!(length * edge > criterion.threshold)) continue;
        normals.normal[i] = packNormal(gradient / -length);
        any = true;
    }
    return any;
}

}  // namespace

PackedNormal packNormal(const Vec3& unit) {
    PackedNormal packed = kPresent;
    for (int axis = 0; axis < 3; ++axis)
        packed |= (PackedNormal(std::lround(unit[axis] * double(kPackedSteps))) & kComponent) << (kBits * axis);
    return packed;
}

Vec3 unpackNormal(PackedNormal normal) {
    Vec3 unit;
    for (int axis = 0; axis < 3; ++axis) {
        const auto component = std::int32_t(normal >> (kBits * axis) & kComponent);
        unit[axis] =
            double(component >= 1 << (kBits - 1) ? component - (1 << kBits) : component) / double(kPackedSteps);
    }
    return unit;
}

Surfaces findSurfaces(const BrickLayout& layout, const BrickMap& map, const BrickField& tau, const Periodic& periodic,
                      const SurfaceCriterion& criterion) {
    const std::size_t bricks = layout.brickCount();
    Surfaces surfaces;
    surfaces.slots.assign(bricks, kNoSurface);
    // In pieces, so that bricks without surface never hold memory all at once.
    constexpr std::size_t kPiece = 1024;
    std::vector<NormalBrick> found(std::min(bricks, kPiece));
    std::vector<char> any(found.size());
    for (std::size_t begin = 0; begin < bricks; begin += kPiece) {
        const std::size_t count = std::min(kPiece, bricks - begin);
        parallelFor(count, [&](std::size_t i) {
            found[i] = {};
            const auto tauOf = [&](std::size_t n) { return tau.brick(n); };
            any[i] = findInBrick(layout, {layout, map, periodic, begin + i, tauOf}, criterion, found[i]);
        });
        for (std::size_t i = 0; i < count; ++i) {
            if (!any[i]) continue;
            surfaces.slots[begin + i] = std::uint32_t(surfaces.bricks.size());
            surfaces.bricks.push_back(found[i]);
        }
    }
    return surfaces;
}

std::size_t countSurfaceVoxels(const Surfaces& surfaces) {
    std::size_t count = 0;
    for (const NormalBrick& brick : surfaces.bricks)
        for (const PackedNormal normal : brick.normal) count += normal != 0;
    return count;
}

PackedNormal* addSurfaceBrick(Surfaces& surfaces, std::size_t brickCount, std::size_t b) {
    surfaces.slots.resize(brickCount, kNoSurface);
    if (surfaces.slots[b] == kNoSurface) {
        surfaces.slots[b] = std::uint32_t(surfaces.bricks.size());
        surfaces.bricks.emplace_back();
    }
    return surfaces.bricks[surfaces.slots[b]].normal;
}

}  // namespace raysweep
