#include "raysweep/reconstruct/photo_step.h"

#include <algorithm>
#include <cmath>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/reconstruct/photo_step.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/four_floats-inl.h"

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

constexpr int kSlab = 64;  ///< voxels of one x
constexpr hn::CappedTag<float, 8> kLanes;

/// 1 - exp(-extinction) of `kSlab` voxels, in place.
HWY_INLINE void opacities(float* HWY_RESTRICT values, int count) {
    for (int i = 0; i < count; i += int(hn::Lanes(kLanes))) {
        const auto depth = hn::Neg(hn::Load(kLanes, values + i));
        hn::Store(hn::Sub(hn::Set(kLanes, 1.0f), hn::Exp(kLanes, depth)), kLanes, values + i);
    }
}

HWY_INLINE bool allZero(const CompositeVoxel* sums) {
    Four all = setFour(0);
    const Four zero = setFour(0);
    for (int i = 0; i < kSlab; ++i) {
        const Four one = loadFour(&sums[i].extinction);
        all = all + mostOf(one, zero - one);
    }
    return isZero(all);
}

constexpr int kEdge = 10;                       ///< a brick and its neighbours' voxels
constexpr int kAround = kEdge * kEdge * kEdge;  ///< 1000, a multiple of 8
constexpr float kFlat = 1e-6f;                  ///< slopes below this part of opacity are rounding

}  // namespace

void multiplyBrickDispatched(CompositeVoxel* HWY_RESTRICT voxels, CompositeVoxel* HWY_RESTRICT sums,
                             const VoxelMask& mask, const PackedNormal* normals, const ViewLight& light,
                             const PhotoStep& step) {
    HWY_ALIGN float opacity[kSlab];
    const Four zero = setFour(0), most = firstOf(setFour(step.mostExtinction), setFour(1));
    for (int x = 0; x < 8; ++x, voxels += kSlab, sums += kSlab) {
        if (allZero(sums)) continue;
        for (int i = 0; i < kSlab; ++i) opacity[i] = voxels[i].extinction;
        opacities(opacity, kSlab);
        for (int i = 0; i < kSlab; ++i) {
            const Four sum = loadFour(&sums[i].extinction);
            storeFour(zero, &sums[i].extinction);
            if (!(mask[std::size_t(x)] >> i & 1)) continue;
            const float seen = normals ? brightness(light, normals[x * kSlab + i]) : light.ambient;
            const Four factor =
                firstOf(setFour(step.relaxation * (opacity[i] + step.least)), setFour(step.relaxation * seen));
            const Four after = mulAdd(sum, factor, loadFour(&voxels[i].extinction));
            storeFour(leastOf(mostOf(after, zero), most), &voxels[i].extinction);
        }
    }
}

void addToBrickDispatched(CompositeVoxel* HWY_RESTRICT matter, CompositeVoxel* HWY_RESTRICT sums, const VoxelMask& mask,
                          const PhotoStep& step) {
    const Four zero = setFour(0), one = setFour(1), relaxation = setFour(step.relaxation);
    for (int i = 0; i < 512; ++i) {
        const Four sum = loadFour(&sums[i].extinction);
        if (isZero(sum)) continue;
        storeFour(zero, &sums[i].extinction);
        if (!(mask[std::size_t(i >> 6)] >> (i & 63) & 1)) continue;
        const Four after = mulAdd(sum, relaxation, loadFour(&matter[i].extinction));
        storeFour(leastOf(mostOf(after, zero), one), &matter[i].extinction);
    }
}

void straightenBrickDispatched(const CompositeVoxel* HWY_RESTRICT matter, CompositeVoxel* HWY_RESTRICT voxels,
                               const PhotoStep& step) {
    HWY_ALIGN float depth[kSlab];
    const Four one = setFour(1), tiny = setFour(1e-6f);
    const auto least = hn::Set(kLanes, std::exp(-step.mostExtinction));
    for (int x = 0; x < 8; ++x, matter += kSlab, voxels += kSlab) {
        for (int i = 0; i < kSlab; ++i) depth[i] = matter[i].extinction;
        for (int i = 0; i < kSlab; i += int(hn::Lanes(kLanes))) {
            const auto through = hn::Max(hn::Sub(hn::Set(kLanes, 1.0f), hn::Load(kLanes, depth + i)), least);
            hn::Store(hn::Neg(hn::Log(kLanes, through)), kLanes, depth + i);
        }
        for (int i = 0; i < kSlab; ++i) {
            const Four color = loadFour(&matter[i].extinction) / mostOf(setFour(matter[i].extinction), tiny);
            storeFour(firstOf(setFour(depth[i]), leastOf(color, one)), &voxels[i].extinction);
        }
    }
}

void brickNormalsDispatched(const CompositeLayout& layout, const CompositeVoxel* HWY_RESTRICT voxels, std::size_t brick,
                            PackedNormal* HWY_RESTRICT normals) {
    HWY_ALIGN float around[kAround];
    const Index3 origin = layout.origins[brick];
    float* to = around;
    for (int x = -1; x < 9; ++x)
        for (int y = -1; y < 9; ++y) {
            const bool inside = x >= 0 && x < 8 && y >= 0 && y < 8;
            const CompositeVoxel* row = inside ? voxels + brick * 512 + std::size_t(x << 6 | y << 3) : nullptr;
            for (int z = -1; z < 9; ++z)
                *to++ = row && z >= 0 && z < 8 ? row[z].extinction
                                               : voxels[layout.voxel(origin + Index3(x, y, z))].extinction;
        }
    opacities(around, kAround);
    for (int i = 0; i < 512; ++i) {
        const float* at = around + (((i >> 6) + 1) * kEdge + (i >> 3 & 7) + 1) * kEdge + (i & 7) + 1;
        const float x = 0.5f * (at[-kEdge * kEdge] - at[kEdge * kEdge]), y = 0.5f * (at[-kEdge] - at[kEdge]);
        const float z = 0.5f * (at[-1] - at[1]);
        const float length = std::sqrt(x * x + y * y + z * z);
        const float unit = length > kFlat * *at && length > 0 ? 32767 / length : 0;
        normals[i] = {std::int16_t(x * unit), std::int16_t(y * unit), std::int16_t(z * unit), 0};
    }
}

void lightBrickDispatched(const CompositeVoxel* voxels, const PackedNormal* HWY_RESTRICT normals,
                          const ViewLight& light, CompositeVoxel* shown) {
    for (int i = 0; i < 512; ++i) {
        const Four voxel = loadFour(&voxels[i].extinction);
        storeFour(firstOf(voxel, voxel * setFour(normals ? brightness(light, normals[i]) : light.ambient)),
                  &shown[i].extinction);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(multiplyBrickDispatched);
HWY_EXPORT(addToBrickDispatched);
HWY_EXPORT(straightenBrickDispatched);
HWY_EXPORT(brickNormalsDispatched);
HWY_EXPORT(lightBrickDispatched);

void multiplyBrick(CompositeVoxel* voxels, CompositeVoxel* sums, const VoxelMask& mask, const PackedNormal* normals,
                   const ViewLight& light, const PhotoStep& step) {
    HWY_DYNAMIC_DISPATCH(multiplyBrickDispatched)(voxels, sums, mask, normals, light, step);
}

void addToBrick(CompositeVoxel* matter, CompositeVoxel* sums, const VoxelMask& mask, const PhotoStep& step) {
    HWY_DYNAMIC_DISPATCH(addToBrickDispatched)(matter, sums, mask, step);
}

void straightenBrick(const CompositeVoxel* matter, CompositeVoxel* voxels, const PhotoStep& step) {
    HWY_DYNAMIC_DISPATCH(straightenBrickDispatched)(matter, voxels, step);
}

void brickNormals(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t brick,
                  PackedNormal* normals) {
    HWY_DYNAMIC_DISPATCH(brickNormalsDispatched)(layout, voxels, brick, normals);
}

void lightBrick(const CompositeVoxel* voxels, const PackedNormal* normals, const ViewLight& light,
                CompositeVoxel* shown) {
    HWY_DYNAMIC_DISPATCH(lightBrickDispatched)(voxels, normals, light, shown);
}

}  // namespace raysweep
#endif  // HWY_ONCE
