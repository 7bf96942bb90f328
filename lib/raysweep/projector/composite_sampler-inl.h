// Samples between voxels, and what is spread from there over them. Included once for each
// instruction set.
#if defined(RAYSWEEP_COMPOSITE_SAMPLER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_COMPOSITE_SAMPLER_INL_H
#undef RAYSWEEP_COMPOSITE_SAMPLER_INL_H
#else
#define RAYSWEEP_COMPOSITE_SAMPLER_INL_H
#endif

#include "raysweep/projector/composite_ray.h"

#include <hwy/cache_control.h>

#include "raysweep/projector/four_floats-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

constexpr int kChunk = 8;  ///< samples whose places are found together
constexpr hn::CappedTag<float, kChunk> kLanes;
constexpr hn::Rebind<std::int32_t, decltype(kLanes)> kWhole;

HWY_INLINE Four load(const CompositeVoxel* voxel) {
    return loadFour(&voxel->extinction);
}
HWY_INLINE Four load(const RayColor& color) {
    return loadFour(&color.transmittance);
}

/// Distances in memory from a voxel to the next: along the major axis, the first and the second other axis.
template <int kAxis>
struct Strides {
    static constexpr int slice = kAxis == 0 ? 64 : (kAxis == 1 ? 8 : 1);
    static constexpr int first = kAxis == 0 ? 8 : 64;
    static constexpr int second = kAxis == 2 ? 8 : 1;
};

/// Where some samples of a ray are.
struct Places {
    HWY_ALIGN float fraction[3][kChunk];                 ///< slice, first, second: from the voxel below to the next
    HWY_ALIGN std::int32_t slice[kChunk];                ///< below
    HWY_ALIGN std::int32_t cell[kChunk], brick[kChunk];  ///< of the voxel below, in their tables
    HWY_ALIGN std::int32_t within[kChunk];               ///< of the voxel below, in its brick
    HWY_ALIGN std::int32_t within0[3][kChunk];           ///< along each axis, 0 to 7
};

/// A volume as rays of one major axis see it.
template <int kAxis>
class Sampler {
  public:
    using Step = Strides<kAxis>;

    explicit Sampler(const CompositeLayout& layout) : table_(layout.table.data()), cells_(layout.cells.data()) {
        stridesAlong(kAxis, layout.tableDims, brickStride_);
        stridesAlong(kAxis, layout.cellDims, cellStride_);
        brickOrigin_ = brickStride_[0] + brickStride_[1] + brickStride_[2];
        cellOrigin_ = 2 * (cellStride_[0] + cellStride_[1] + cellStride_[2]);
    }

    /// The places of samples whose numbers are given as floats.
    HWY_INLINE void locate(const CompositeRay& ray, const float* HWY_RESTRICT numbers, Places& to) const {
        const auto seven = hn::Set(kWhole, 7);
        for (std::size_t i = 0; i < kChunk; i += hn::Lanes(kLanes)) {
            const auto k = hn::LoadU(kLanes, numbers + i);
            const float start[3] = {ray.start, ray.place[0], ray.place[1]};
            const float rate[3] = {ray.step, ray.rate[0], ray.rate[1]};
            const int inBrick[3] = {Step::slice, Step::first, Step::second};
            auto cell = hn::Set(kWhole, cellOrigin_), brick = hn::Set(kWhole, brickOrigin_);
            auto within = hn::Zero(kWhole);
            for (int axis = 0; axis < 3; ++axis) {
                const auto place = hn::MulAdd(k, hn::Set(kLanes, rate[axis]), hn::Set(kLanes, start[axis]));
                const auto below = hn::Floor(place);
                const auto whole = hn::ConvertTo(kWhole, below);
                hn::Store(hn::Sub(place, below), kLanes, to.fraction[axis] + i);
                if (axis == 0) hn::Store(whole, kWhole, to.slice + i);
                cell = hn::Add(cell, hn::Mul(hn::ShiftRight<2>(whole), hn::Set(kWhole, cellStride_[axis])));
                brick = hn::Add(brick, hn::Mul(hn::ShiftRight<3>(whole), hn::Set(kWhole, brickStride_[axis])));
                const auto low = hn::And(whole, seven);
                hn::Store(low, kWhole, to.within0[axis] + i);
                within = hn::Add(within, hn::Mul(low, hn::Set(kWhole, inBrick[axis])));
            }
            hn::Store(cell, kWhole, to.cell + i);
            hn::Store(brick, kWhole, to.brick + i);
            hn::Store(within, kWhole, to.within + i);
        }
    }

    /// Asks for the voxels of places to come.
    HWY_INLINE void prefetch(const CompositeVoxel* voxels, const Places& at, int count) const {
        for (int i = 0; i < count; ++i) {
            const CompositeVoxel* p = voxels + ((std::size_t(table_[at.brick[i]]) << 9) + std::size_t(at.within[i]));
            hwy::Prefetch(p);
            hwy::Prefetch(p + Step::first);
            if (kAxis == 2) {
                hwy::Prefetch(p + Step::second);
                hwy::Prefetch(p + Step::first + Step::second);
            }
        }
    }

    HWY_INLINE bool isEmpty(std::int32_t cell) const { return cells_[cell] != 0; }

    const int* brickStride() const { return brickStride_; }

  private:
    const std::int32_t* table_;
    const std::uint8_t* cells_;
    int brickStride_[3], cellStride_[3];
    int brickOrigin_, cellOrigin_;
};

/// Indices of the first `count` of the eight voxels around a sample, wherever their bricks are.
template <int kAxis>
HWY_INLINE void indicesAround(const std::int32_t* brick, const int* brickStride, const Places& at, int i, int count,
                              std::size_t (&to)[8]) {
    using Step = Strides<kAxis>;
    int table[3][2], within[3][2];
    const int inBrick[3] = {Step::slice, Step::first, Step::second};
    for (int axis = 0; axis < 3; ++axis) {
        const int low = at.within0[axis][i];
        table[axis][0] = 0;
        table[axis][1] = low == 7 ? brickStride[axis] : 0;
        within[axis][0] = low * inBrick[axis];
        within[axis][1] = low == 7 ? 0 : (low + 1) * inBrick[axis];
    }
    for (int which = 0; which < count; ++which) {
        const int s = which >> 2, u = which >> 1 & 1, v = which & 1;
        to[which] = (std::size_t(brick[table[0][s] + table[1][u] + table[2][v]]) << 9) +
                    std::size_t(within[0][s] + within[1][u] + within[2][v]);
    }
}

HWY_INLINE Four mix(Four a, Four b, Four part) {
    return mulAdd(part, b - a, a);
}

/// The sample of a volume at place i.
template <int kAxis>
HWY_INLINE Four sampleAt(const Sampler<kAxis>& sampler, const std::int32_t* table,
                         const CompositeVoxel* HWY_RESTRICT voxels, const Places& at, int i) {
    using Step = Strides<kAxis>;
    const float between = at.fraction[0][i];
    const Four first = setFour(at.fraction[1][i]), second = setFour(at.fraction[2][i]);
    const std::int32_t* brick = table + at.brick[i];
    const bool edge = at.within0[1][i] == 7 || at.within0[2][i] == 7 || (at.within0[0][i] == 7 && between > 0);
    if (HWY_LIKELY(!edge)) {
        const CompositeVoxel* p = voxels + ((std::size_t(*brick) << 9) + std::size_t(at.within[i]));
        const auto inSlice = [&](const CompositeVoxel* q) HWY_ATTR {
            const Four low = mix(load(q), load(q + Step::second), second);
            const Four high = mix(load(q + Step::first), load(q + Step::first + Step::second), second);
            return mix(low, high, first);
        };
        const Four below = inSlice(p);
        return between > 0 ? mix(below, inSlice(p + Step::slice), setFour(between)) : below;
    }
    std::size_t index[8];
    indicesAround<kAxis>(brick, sampler.brickStride(), at, i, between > 0 ? 8 : 4, index);
    const auto inSlice = [&](const std::size_t* q) HWY_ATTR {
        const Four low = mix(load(voxels + q[0]), load(voxels + q[1]), second);
        const Four high = mix(load(voxels + q[2]), load(voxels + q[3]), second);
        return mix(low, high, first);
    };
    const Four below = inSlice(index);
    return between > 0 ? mix(below, inSlice(index + 4), setFour(between)) : below;
}

HWY_INLINE void addTo(CompositeVoxel* HWY_RESTRICT to, Four value) {
    storeFour(load(to) + value, &to->extinction);
}

/// Adds a sample's derivative to the voxels around place i: sampleAt the other way round.
template <int kAxis>
HWY_INLINE void spreadFrom(const Sampler<kAxis>& sampler, const std::int32_t* table, Four derivative,
                           CompositeVoxel* HWY_RESTRICT gradient, const Places& at, int i) {
    using Step = Strides<kAxis>;
    const float between = at.fraction[0][i];
    const Four first = setFour(at.fraction[1][i]), second = setFour(at.fraction[2][i]);
    const std::int32_t* brick = table + at.brick[i];
    const bool edge = at.within0[1][i] == 7 || at.within0[2][i] == 7 || (at.within0[0][i] == 7 && between > 0);
    const Four upper = derivative * setFour(between), lower = derivative - upper;
    const auto split = [&](Four all, Four(&to)[4]) HWY_ATTR {
        const Four high = all * first, low = all - high;
        to[1] = low * second;
        to[0] = low - to[1];
        to[3] = high * second;
        to[2] = high - to[3];
    };
    Four parts[4];
    split(lower, parts);
    if (HWY_LIKELY(!edge)) {
        if (*brick == 0) return;  // several threads would write to the empty brick
        CompositeVoxel* p = gradient + ((std::size_t(*brick) << 9) + std::size_t(at.within[i]));
        const auto inSlice = [&](CompositeVoxel* q) HWY_ATTR {
            addTo(q, parts[0]);
            addTo(q + Step::second, parts[1]);
            addTo(q + Step::first, parts[2]);
            addTo(q + Step::first + Step::second, parts[3]);
        };
        inSlice(p);
        if (!(between > 0)) return;
        split(upper, parts);
        inSlice(p + Step::slice);
        return;
    }
    std::size_t index[8];
    indicesAround<kAxis>(brick, sampler.brickStride(), at, i, between > 0 ? 8 : 4, index);
    const auto inSlice = [&](const std::size_t* q) HWY_ATTR {
        for (int n = 0; n < 4; ++n)
            if (q[n] >= 512) addTo(gradient + q[n], parts[n]);
    };
    inSlice(index);
    if (!(between > 0)) return;
    split(upper, parts);
    inSlice(index + 4);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif
