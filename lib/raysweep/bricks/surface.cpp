#include "raysweep/bricks/surface.h"

#include <cmath>

namespace raysweep {
namespace {

constexpr int kBits = 10;
constexpr PackedNormal kComponent = (1u << kBits) - 1;
static_assert(kSurfaceBit == 1u << (3 * kBits), "above the components");

}  // namespace

PackedNormal packNormal(const Vec3& unit) {
    PackedNormal packed = kSurfaceBit;
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

std::size_t countSurfaceVoxels(const Surfaces& surfaces) {
    std::size_t count = 0;
    for (const NormalBrick& brick : surfaces.bricks)
        for (const PackedNormal normal : brick.normal) count += isSurface(normal);
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
