// Compiled once per instruction set; the best one that the machine has is chosen at run time.
#include "raysweep/render/block_steps.h"

#include "raysweep/render/cell_blocks.h"

#include <cstdint>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/render/block_steps.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

const hn::CappedTag<float, kMostSteps> kFloats;
const hn::CappedTag<std::int32_t, kMostSteps> kIntegers;

/// The cells that steps lie in, as offsets of their low corners, and where in them.
struct StepCells {
    alignas(64) float within[3][kMostSteps];
    alignas(64) std::int32_t corner[kMostSteps];
};

/// Rounding may put a step slightly outside the block, where the cell at its border goes on.
HWY_INLINE void findCells(const BlockSteps& steps, int channels, StepCells& cells) {
    const auto lastCell = hn::Set(kFloats, float(kBlockCells - 1)), corners = hn::Set(kFloats, float(kBlockCorners));
    for (int i = 0; i < steps.count; i += int(hn::Lanes(kFloats))) {
        const auto step = hn::ConvertTo(kFloats, hn::Iota(kIntegers, i));
        auto corner = hn::Zero(kFloats);
        for (int axis = 0; axis < 3; ++axis) {
            const auto p = hn::MulAdd(step, hn::Set(kFloats, steps.perStep[axis]), hn::Set(kFloats, steps.first[axis]));
            const auto inside = hn::Min(hn::Max(p, hn::Zero(kFloats)), lastCell);
            const auto low = hn::ConvertTo(kFloats, hn::ConvertTo(kIntegers, inside));
            hn::Store(hn::Sub(p, low), kFloats, cells.within[axis] + i);
            corner = hn::MulAdd(corner, corners, low);
        }
        corner = hn::Mul(corner, hn::Set(kFloats, float(channels)));
        hn::Store(hn::ConvertTo(kIntegers, corner), kIntegers, cells.corner + i);
    }
}

template <int kChannels>
HWY_INLINE void interpolate(const float* corner, float x, float y, float z, float (&value)[kChannels]) {
    constexpr int kNextY = kBlockCorners * kChannels, kNextX = kBlockCorners * kNextY;
    float edge[2 * kChannels];  // all values at two corners that follow each other along z
    for (int c = 0; c < 2 * kChannels; ++c) {
        const float y0 = corner[c] + (corner[kNextY + c] - corner[c]) * y;
        const float y1 = corner[kNextX + c] + (corner[kNextX + kNextY + c] - corner[kNextX + c]) * y;
        edge[c] = y0 + (y1 - y0) * x;
    }
    for (int c = 0; c < kChannels; ++c) value[c] = edge[c] + (edge[kChannels + c] - edge[c]) * z;
}

template <int kChannels>
HWY_INLINE void sample(const float* block, const BlockSteps& steps, StepValue<kChannels>* values) {
    StepCells cells;
    findCells(steps, kChannels, cells);
    for (int i = 0; i < steps.count; ++i)
        interpolate(block + cells.corner[i], cells.within[0][i], cells.within[1][i], cells.within[2][i], values[i]);
}

}  // namespace

void sampleSteps1(const float* block, const BlockSteps& steps, StepValue<1>* values) {
    sample<1>(block, steps, values);
}
void sampleSteps2(const float* block, const BlockSteps& steps, StepValue<2>* values) {
    sample<2>(block, steps, values);
}
void sampleSteps3(const float* block, const BlockSteps& steps, StepValue<3>* values) {
    sample<3>(block, steps, values);
}
void sampleSteps4(const float* block, const BlockSteps& steps, StepValue<4>* values) {
    sample<4>(block, steps, values);
}

/// Without cancellation: a step through thin smoke has an optical depth far below a float's epsilon.
void opacitiesOf(const float* densities, int count, float depth, float* opacities) {
    for (int i = 0; i < count; i += int(hn::Lanes(kFloats))) {
        const auto density = hn::Max(hn::Load(kFloats, densities + i), hn::Zero(kFloats));
        const auto minusTau = hn::Mul(density, hn::Set(kFloats, -depth));
        hn::StoreU(hn::Neg(hn::Expm1(kFloats, minusTau)), kFloats, opacities + i);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(sampleSteps1);
HWY_EXPORT(sampleSteps2);
HWY_EXPORT(sampleSteps3);
HWY_EXPORT(sampleSteps4);
HWY_EXPORT(opacitiesOf);

template <>
void sampleSteps<1>(const float* block, const BlockSteps& steps, StepValue<1>* values) {
    HWY_DYNAMIC_DISPATCH(sampleSteps1)(block, steps, values);
}
template <>
void sampleSteps<2>(const float* block, const BlockSteps& steps, StepValue<2>* values) {
    HWY_DYNAMIC_DISPATCH(sampleSteps2)(block, steps, values);
}
template <>
void sampleSteps<3>(const float* block, const BlockSteps& steps, StepValue<3>* values) {
    HWY_DYNAMIC_DISPATCH(sampleSteps3)(block, steps, values);
}
template <>
void sampleSteps<4>(const float* block, const BlockSteps& steps, StepValue<4>* values) {
    HWY_DYNAMIC_DISPATCH(sampleSteps4)(block, steps, values);
}

template <int kChannels>
void findOpacities(const StepValue<kChannels>* values, int count, float depth, float (&opacities)[kMostSteps]) {
    alignas(64) float densities[kMostSteps] = {};
    for (int i = 0; i < count; ++i) densities[i] = values[i][0];
    HWY_DYNAMIC_DISPATCH(opacitiesOf)(densities, count, depth, opacities);
}
template void findOpacities<1>(const StepValue<1>*, int, float, float (&)[kMostSteps]);
template void findOpacities<2>(const StepValue<2>*, int, float, float (&)[kMostSteps]);
template void findOpacities<4>(const StepValue<4>*, int, float, float (&)[kMostSteps]);

}  // namespace raysweep
#endif  // HWY_ONCE
