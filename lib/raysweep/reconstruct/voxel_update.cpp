#include "raysweep/reconstruct/voxel_update.h"

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/reconstruct/voxel_update.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void updateVoxelsDispatched(float* HWY_RESTRICT voxels, const float* HWY_RESTRICT values,
                            const float* HWY_RESTRICT weights, std::size_t count, const VoxelUpdate& update) {
    constexpr hn::CappedTag<float, 16> lanes;
    using Vec = hn::Vec<decltype(lanes)>;
    const Vec relaxation = hn::Set(lanes, update.relaxation);
    const Vec lower = hn::Set(lanes, update.lower), upper = hn::Set(lanes, update.upper);
    const Vec zero = hn::Zero(lanes), one = hn::Set(lanes, 1.0f);
    for (std::size_t i = 0; i < count; i += hn::Lanes(lanes)) {
        const Vec weight = hn::LoadU(lanes, weights + i), before = hn::Load(lanes, voxels + i);
        const auto seen = hn::Gt(weight, zero);
        const Vec mean = hn::Div(hn::LoadU(lanes, values + i), hn::IfThenElse(seen, weight, one));
        const Vec after = hn::Min(hn::Max(hn::MulAdd(relaxation, mean, before), lower), upper);
        hn::Store(hn::IfThenElse(seen, after, before), lanes, voxels + i);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(updateVoxelsDispatched);

void updateVoxels(float* voxels, const float* values, const float* weights, std::size_t count,
                  const VoxelUpdate& update) {
    HWY_DYNAMIC_DISPATCH(updateVoxelsDispatched)(voxels, values, weights, count, update);
}

}  // namespace raysweep
#endif  // HWY_ONCE
