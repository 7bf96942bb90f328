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

/// Voxels next to each other along z lie side by side, and are read in pairs: rows. Along the other axes the eight
/// voxels around a sample are in four rows: in the lower slice two, and in the upper, where a ray's major axis is x or
/// y; else, where both slices are in each row, the four at the corners of a square.
template <int kAxis>
struct Rows {
    static constexpr bool haveSlices = kAxis == 2;  ///< both in each row
    /// Places among slice, first and second other axis; upper rows are those of `far`, odd ones those of `near`.
    static constexpr int far = haveSlices ? 1 : 0, near = haveSlices ? 2 : 1, along = haveSlices ? 0 : 2;
    /// In a brick, voxels from one to the next.
    static constexpr int inBrick[3] = {kAxis == 0 ? 64 : (kAxis == 1 ? 8 : 1), kAxis == 0 ? 8 : 64, kAxis == 2 ? 8 : 1};
};
template <int kAxis>
constexpr int Rows<kAxis>::inBrick[3];

/// Where some samples of a ray are.
struct Places {
    HWY_ALIGN float fraction[3][kChunk];      ///< slice, first, second: from the voxel below to the next
    HWY_ALIGN std::int32_t slice[kChunk];     ///< below
    HWY_ALIGN std::int32_t cell[kChunk];      ///< of the voxel below, in its table
    HWY_ALIGN std::int32_t row[4][kChunk];    ///< index of its first voxel
    HWY_ALIGN std::int32_t other[4][kChunk];  ///< index of its second one, if any is not the next to the first
    HWY_ALIGN std::int32_t apart[kChunk];     ///< not 0: the second is in another brick
};

/// A volume as rays of one major axis see it.
template <int kAxis>
class Sampler {
  public:
    using Row = Rows<kAxis>;

    explicit Sampler(const CompositeLayout& layout) : table_(layout.table.data()), cells_(layout.cells.data()) {
        stridesAlong(kAxis, layout.tableDims, brickStride_);
        stridesAlong(kAxis, layout.cellDims, cellStride_);
        brickOrigin_ = brickStride_[0] + brickStride_[1] + brickStride_[2];
        cellOrigin_ = 2 * (cellStride_[0] + cellStride_[1] + cellStride_[2]);
    }

    /// The places of samples from `first` on; instead of those behind `last` that again.
    HWY_INLINE void locate(const CompositeRay& ray, int first, int last, Places& to) const {
        const auto seven = hn::Set(kWhole, 7), zero = hn::Zero(kWhole);
        const float start[3] = {ray.start, ray.place[0], ray.place[1]};
        const float rate[3] = {ray.step, ray.rate[0], ray.rate[1]};
        for (std::size_t i = 0; i < kChunk; i += hn::Lanes(kLanes)) {
            const auto k = hn::Min(hn::Iota(kLanes, float(first + int(i))), hn::Set(kLanes, float(last)));
            auto cell = hn::Set(kWhole, cellOrigin_), brick = hn::Set(kWhole, brickOrigin_), within = zero;
            hn::Vec<decltype(kWhole)> low[3];
            bool between = Row::haveSlices;
            for (int axis = 0; axis < 3; ++axis) {
                const auto place = hn::MulAdd(k, hn::Set(kLanes, rate[axis]), hn::Set(kLanes, start[axis]));
                const auto below = hn::Floor(place);
                const auto whole = hn::ConvertTo(kWhole, below);
                const auto fraction = hn::Sub(place, below);
                hn::Store(fraction, kLanes, to.fraction[axis] + i);
                if (axis == 0) {
                    hn::Store(whole, kWhole, to.slice + i);
                    between |= !hn::AllTrue(kLanes, hn::Eq(fraction, hn::Zero(kLanes)));
                }
                cell = hn::Add(cell, hn::Mul(hn::ShiftRight<2>(whole), hn::Set(kWhole, cellStride_[axis])));
                brick = hn::Add(brick, hn::Mul(hn::ShiftRight<3>(whole), hn::Set(kWhole, brickStride_[axis])));
                low[axis] = hn::And(whole, seven);
                within = hn::Add(within, hn::Mul(low[axis], hn::Set(kWhole, Row::inBrick[axis])));
            }
            hn::Store(cell, kWhole, to.cell + i);
            // To the next voxel along an axis: in the table, and in the brick.
            const auto table = [&](int axis) HWY_ATTR {
                return hn::IfThenElseZero(hn::Eq(low[axis], seven), hn::Set(kWhole, brickStride_[axis]));
            };
            const auto inside = [&](int axis) HWY_ATTR {
                const int step = Row::inBrick[axis];
                return hn::IfThenElse(hn::Eq(low[axis], seven), hn::Set(kWhole, -7 * step), hn::Set(kWhole, step));
            };
            const auto index = [&](auto at, auto voxel) HWY_ATTR {
                return hn::Add(hn::ShiftLeft<9>(hn::GatherIndex(kWhole, table_, at)), voxel);
            };
            const auto nearTable = hn::Add(brick, table(Row::near)), nearInside = hn::Add(within, inside(Row::near));
            const auto farTable = table(Row::far), farInside = inside(Row::far);
            const auto isLast = hn::Eq(low[Row::along], seven);
            const bool apart = !hn::AllFalse(kWhole, isLast);
            hn::Store(hn::VecFromMask(kWhole, isLast), kWhole, to.apart + i);
            const auto next = table(Row::along), onward = inside(Row::along);
            const auto store = [&](int row, auto at, auto voxel) HWY_ATTR {
                hn::Store(index(at, voxel), kWhole, to.row[row] + i);
                if (apart) hn::Store(index(hn::Add(at, next), hn::Add(voxel, onward)), kWhole, to.other[row] + i);
            };
            store(0, brick, within);
            store(1, nearTable, nearInside);
            if (!between) continue;
            store(2, hn::Add(brick, farTable), hn::Add(within, farInside));
            store(3, hn::Add(nearTable, farTable), hn::Add(nearInside, farInside));
        }
    }

    /// Asks for the voxels of places to come.
    HWY_INLINE void prefetch(const CompositeVoxel* voxels, const Places& at, int count) const {
        for (int i = 0; i < count; ++i)
            for (int row = 0; row < (Row::haveSlices ? 4 : 2); ++row) hwy::Prefetch(voxels + at.row[row][i]);
    }

    HWY_INLINE bool isEmpty(std::int32_t cell) const { return cells_[cell] != 0; }

  private:
    const std::int32_t* table_;
    const std::uint8_t* cells_;
    int brickStride_[3], cellStride_[3];
    int brickOrigin_, cellOrigin_;
};

HWY_INLINE Four mix(Four a, Four b, Four part) {
    return mulAdd(part, b - a, a);
}
HWY_INLINE Eight mix(Eight a, Eight b, Eight part) {
    return mulAdd(part, b - a, a);
}

/// The sample of a volume at place i.
template <int kAxis>
HWY_INLINE Four sampleAt(const CompositeVoxel* HWY_RESTRICT voxels, const Places& at, int i) {
    using Row = Rows<kAxis>;
    const float between = at.fraction[0][i];
    const bool apart = at.apart[i] != 0;
    const auto row = [&](int n) HWY_ATTR {
        const CompositeVoxel* p = voxels + at.row[n][i];
        if (HWY_UNLIKELY(apart)) return together(load(p), load(voxels + at.other[n][i]));
        return loadEight(&p->extinction);
    };
    if (Row::haveSlices) {
        const float first = at.fraction[1][i], second = at.fraction[2][i];
        if (!(between > 0)) {
            const auto voxel = [&](int n) HWY_ATTR { return load(voxels + at.row[n][i]); };
            return mix(mix(voxel(0), voxel(1), setFour(second)), mix(voxel(2), voxel(3), setFour(second)),
                       setFour(first));
        }
        const Eight pair =
            mix(mix(row(0), row(1), setEight(second)), mix(row(2), row(3), setEight(second)), setEight(first));
        return mix(lowOf(pair), highOf(pair), setFour(between));
    }
    const Eight first = setEight(at.fraction[1][i]);
    Eight pair = mix(row(0), row(1), first);
    if (between > 0) pair = mix(pair, mix(row(2), row(3), first), setEight(between));
    return mix(lowOf(pair), highOf(pair), setFour(at.fraction[2][i]));
}

HWY_INLINE void addTo(CompositeVoxel* HWY_RESTRICT to, Four value) {
    storeFour(load(to) + value, &to->extinction);
}

/// Adds a sample's derivative to the voxels around place i: sampleAt the other way round.
template <int kAxis>
HWY_INLINE void spreadFrom(Four derivative, CompositeVoxel* HWY_RESTRICT gradient, const Places& at, int i) {
    using Row = Rows<kAxis>;
    constexpr std::int32_t kFull = 512;  // several threads would write to the empty brick
    const float between = at.fraction[0][i];
    const bool apart = at.apart[i] != 0;
    const auto add = [&](int n, Eight value) HWY_ATTR {
        const std::int32_t voxel = at.row[n][i];
        if (HWY_UNLIKELY(apart)) {
            const std::int32_t other = at.other[n][i];
            if (voxel >= kFull) addTo(gradient + voxel, lowOf(value));
            if (other >= kFull) addTo(gradient + other, highOf(value));
            return;
        }
        if (HWY_UNLIKELY(voxel < kFull)) return;
        float* to = &gradient[voxel].extinction;
        storeEight(loadEight(to) + value, to);
    };
    const auto addPair = [&](int n, Eight value, Eight part) HWY_ATTR {
        const Eight odd = value * part;
        add(n, value - odd);
        add(n + 1, odd);
    };
    const auto pairOf = [&](float part) HWY_ATTR {
        const Four high = derivative * setFour(part);
        return together(derivative - high, high);
    };
    if (Row::haveSlices) {
        const float first = at.fraction[1][i], second = at.fraction[2][i];
        if (!(between > 0)) {
            const auto addTwo = [&](int n, Four value) HWY_ATTR {
                const Four odd = value * setFour(second);
                if (at.row[n][i] >= kFull) addTo(gradient + at.row[n][i], value - odd);
                if (at.row[n + 1][i] >= kFull) addTo(gradient + at.row[n + 1][i], odd);
            };
            const Four upper = derivative * setFour(first);
            addTwo(0, derivative - upper);
            addTwo(2, upper);
            return;
        }
        const Eight pair = pairOf(between), upper = pair * setEight(first);
        addPair(0, pair - upper, setEight(second));
        addPair(2, upper, setEight(second));
        return;
    }
    const Eight pair = pairOf(at.fraction[2][i]), first = setEight(at.fraction[1][i]);
    if (!(between > 0)) return addPair(0, pair, first);
    const Eight upper = pair * setEight(between);
    addPair(0, pair - upper, first);
    addPair(2, upper, first);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif
