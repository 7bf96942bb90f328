// Rays go through the volume in parallel, each leaving the derivatives of its samples. These are then gathered slice by
// slice: a task owns a layer of bricks across the rays' major axis, and adds what all rays have there in the order of
// the rays, so that no two threads write to a voxel, and sums have one order. Samples between two layers belong to the
// lower one and reach into the next: so every other layer is done first.
#include "raysweep/projector/composite.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/projector/composite.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/four_floats-inl.h"

#include <hwy/contrib/math/math-inl.h>

#ifndef RAYSWEEP_COMPOSITE_ONCE
#define RAYSWEEP_COMPOSITE_ONCE
namespace raysweep {

constexpr std::size_t kRaysTogether =
    16;  ///< go through the volume as one piece: their samples stay in the first cache

/// What a thread keeps of the samples of its rays between compositing and derivative.
struct SampleRoom {
    std::vector<CompositeVoxel> samples;
    std::vector<float> transmittances;  ///< before each sample, and behind the last: one more for each ray
    std::vector<std::uint16_t> numbers;
    std::vector<std::uint32_t> firsts;  ///< sample of each ray, and the end

    void reserve(const CompositeRay* rays, std::size_t count) {
        std::size_t most = 0;
        for (std::size_t r = 0; r < count; ++r) most += std::size_t(rays[r].count) + 8;
        if (samples.size() >= most && firsts.size() > count) return;
        samples.resize(most);
        transmittances.resize(most + count);
        numbers.resize(most);
        firsts.resize(count + 1);
    }
};

/// Where the spans of a piece's rays go: that of ray r in a layer at `spans[layer * rays + r]`.
struct SpanTable {
    CompositeTape::Span* spans = nullptr;
    std::size_t rays = 0;
};

/// A ray on its way through the cells of a layout.
class CellWalk {
  public:
    CellWalk(const CompositeLayout& layout, const CompositeRay& ray) : cells_(layout.cells.data()), ray_(ray) {
        const Index3 dims = layout.cellDims;
        const int along[3] = {dims.y * dims.z, dims.z, 1};
        stride_[0] = along[ray.axis];
        stride_[1] = along[ray.axis == 0 ? 1 : 0];
        stride_[2] = along[ray.axis == 2 ? 1 : 2];
        const float rate[3] = {ray.step, ray.rate[0], ray.rate[1]};
        for (int axis = 0; axis < 3; ++axis) inverse_[axis] = std::abs(rate[axis]) < 1e-9f ? 1e9f : 1 / rate[axis];
    }

    /// A sample behind `k`, before which nothing is seen; `k` itself if that may see something.
    int next(int k) const {
        const float place[3] = {ray_.start + float(k) * ray_.step, ray_.place[0] + float(k) * ray_.rate[0],
                                ray_.place[1] + float(k) * ray_.rate[1]};
        int whole[3];
        std::ptrdiff_t cell = 0;
        for (int axis = 0; axis < 3; ++axis) {
            whole[axis] = (int(place[axis] + 8.0f) - 8) >> 2;
            cell += (whole[axis] + 2) * std::ptrdiff_t(stride_[axis]);
        }
        const int distance = cells_[cell];
        if (distance == 0) return k;
        float least = 1e9f;
        for (int axis = 0; axis < 3; ++axis) {
            const float end = 4.0f * float(inverse_[axis] > 0 ? whole[axis] + distance : whole[axis] - distance + 1);
            least = std::min(least, (end - place[axis]) * inverse_[axis]);
        }
        return k + std::max(1, int(std::ceil(least)));
    }

  private:
    const std::uint8_t* cells_;
    const CompositeRay& ray_;
    int stride_[3];
    float inverse_[3];
};

/// Layer of bricks that holds a slice, counted from the one around the volume.
inline int layerOf(int slice) {
    return (slice >> 3) + 1;
}

}  // namespace raysweep
#endif

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

    /// The same in a table with z contiguous: slice, first, second.
    static void of(const Index3& dims, int (&to)[3]) {
        const int along[3] = {dims.y * dims.z, dims.z, 1};
        to[0] = along[kAxis];
        to[1] = along[kAxis == 0 ? 1 : 0];
        to[2] = along[kAxis == 2 ? 1 : 2];
    }
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
        Step::of(layout.tableDims, brickStride_);
        Step::of(layout.cellDims, cellStride_);
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

/// What follows from the samples of one ray, front to back.
class FrontToBack {
  public:
    FrontToBack() : color_(setFour(0)) {}

    /// Takes `count` <= kChunk samples into account. @return how many, fewer if too little comes through
    HWY_INLINE int add(const CompositeVoxel* HWY_RESTRICT samples, float* HWY_RESTRICT transmittances, int count,
                       float length) {
        HWY_ALIGN float depth[kChunk] = {};
        for (int i = 0; i < count; ++i) depth[i] = -length * samples[i].extinction;
        for (std::size_t i = 0; i < kChunk; i += hn::Lanes(kLanes))
            hn::Store(hn::Exp(kLanes, hn::Load(kLanes, depth + i)), kLanes, depth + i);
        for (int i = 0; i < count; ++i) {
            const float behind = transmittance_ * depth[i];
            transmittances[i] = transmittance_;
            color_ = mulAdd(setFour(transmittance_ - behind), load(samples + i), color_);
            transmittance_ = behind;
            if (behind < kLeastTransmittance) {
                count = i + 1;
                ended_ = true;
            }
        }
        transmittances[count] = transmittance_;
        return count;
    }

    bool ended() const { return ended_; }

    HWY_INLINE void store(RayColor& to) const {
        storeFour(color_, &to.transmittance);
        to.transmittance = transmittance_;
    }

  private:
    Four color_;
    float transmittance_ = 1;
    bool ended_ = false;
};

/// Notes which samples of a ray are in which layer.
class SpanWriter {
  public:
    SpanWriter(const SpanTable& table, std::size_t ray) : table_(table), ray_(ray) {}

    HWY_INLINE void add(int slice, std::uint16_t sample) {
        const int layer = layerOf(slice);
        if (layer == layer_) return;
        end(sample);
        layer_ = layer;
        first_ = sample;
    }

    HWY_INLINE void end(std::size_t sample) {
        if (table_.spans && layer_ >= 0)
            table_.spans[std::size_t(layer_) * table_.rays + ray_] = {first_, std::uint16_t(sample)};
    }

  private:
    SpanTable table_;
    std::size_t ray_;
    int layer_ = -1;
    std::uint16_t first_ = 0;
};

/// One ray; its samples go to `room` from `first` on. @return where they end
template <int kAxis>
std::size_t compositeOne(const CompositeLayout& layout, const CompositeVoxel* HWY_RESTRICT voxels,
                         const CompositeRay& ray, SampleRoom& room, std::size_t first, float* transmittances,
                         SpanWriter spans, RayColor& color) {
    const Sampler<kAxis> sampler(layout);
    const std::int32_t* table = layout.table.data();
    const CellWalk walk(layout, ray);
    FrontToBack light;
    Places places;
    HWY_ALIGN float numbers[kChunk];
    std::size_t n = first;
    transmittances[0] = 1;
    for (int k = 0; k < ray.count && !light.ended();) {
        const int next = walk.next(k);
        if (next != k) {
            k = next;
            continue;
        }
        for (int i = 0; i < kChunk; ++i) numbers[i] = float(k + i);
        sampler.locate(ray, numbers, places);
        const int most = std::min(kChunk, ray.count - k);
        sampler.prefetch(voxels, places, most);
        int count = 0;
        do {
            storeFour(sampleAt<kAxis>(sampler, table, voxels, places, count),
                      &room.samples[n + std::size_t(count)].extinction);
            ++count;
        } while (count < most && !sampler.isEmpty(places.cell[count]));
        const int used = light.add(&room.samples[n], transmittances + (n - first), count, ray.length);
        for (int i = 0; i < used; ++i) {
            room.numbers[n + std::size_t(i)] = std::uint16_t(k + i);
            spans.add(places.slice[i], std::uint16_t(n + std::size_t(i) - first));
        }
        n += std::size_t(used);
        k += count;
    }
    spans.end(n - first);
    light.store(color);
    return n;
}

/// Eq. 2 for one ray of `count` samples, back to front.
void differentiateOne(const CompositeVoxel* HWY_RESTRICT samples, const float* HWY_RESTRICT transmittances,
                      std::size_t count, float length, const RayColor& derivative, CompositeVoxel* HWY_RESTRICT to) {
    const Four zero = setFour(0), all = load(derivative);
    const Four colors = firstOf(zero, all);        // dL/dC
    const Four summed = firstOf(setFour(1), all);  // 1, dL/dC
    // Σ_j>i T_j (1 − exp(−τ_j)) c_j, and in the first lane T dL/dT.
    Four behind = firstOf(all * setFour(transmittances[count]), zero);
    for (std::size_t i = count; i-- > 0;) {
        const Four color = firstOf(zero, load(samples + i));
        const Four weight = setFour(transmittances[i] - transmittances[i + 1]);
        const Four change = mulSub(setFour(transmittances[i + 1]), color, behind);
        const float depth = sumOf(summed * change);
        storeFour(firstOf(setFour(depth * length), weight * colors), &to[i].extinction);
        behind = mulAdd(weight, color, behind);
    }
}

constexpr std::size_t kAhead = 6;  ///< rays

/// A layer has few samples of each ray, so that every ray's would be waited for.
HWY_INLINE void fetchAhead(const CompositeTape& tape, std::size_t ray, CompositeTape::Span span) {
    if (span.first == span.last) return;
    const CompositeTape::Piece& piece = tape.pieces[ray / kRaysTogether];
    const std::size_t begin = piece.firsts[ray % kRaysTogether] + span.first;
    hwy::Prefetch(&piece.numbers[begin]);
    hwy::Prefetch(&piece.derivatives[begin]);
    hwy::Prefetch(&piece.derivatives[begin] + 4);
}

/// The samples of a layer, ray after ray in their order.
template <int kAxis>
void spreadLayerAlong(const CompositeLayout& layout, const CompositeRay* rays, std::size_t first, std::size_t last,
                      const CompositeTape::Span* spans, const CompositeTape& tape, CompositeVoxel* gradient) {
    const Sampler<kAxis> sampler(layout);
    const std::int32_t* table = layout.table.data();
    Places places;
    HWY_ALIGN float numbers[kChunk] = {};
    for (std::size_t r = first; r < last; ++r) {
        if (r + kAhead < last) fetchAhead(tape, r + kAhead, spans[r + kAhead]);
        const CompositeTape::Span span = spans[r];
        if (span.first == span.last) continue;
        const CompositeTape::Piece& piece = tape.pieces[r / kRaysTogether];
        const std::size_t begin = piece.firsts[r % kRaysTogether];
        for (std::size_t n = begin + span.first; n < begin + span.last; n += kChunk) {
            const int count = int(std::min<std::size_t>(kChunk, begin + span.last - n));
            for (int i = 0; i < count; ++i) numbers[i] = float(piece.numbers[n + std::size_t(i)]);
            sampler.locate(rays[r], numbers, places);
            for (int i = 0; i < count; ++i)
                spreadFrom<kAxis>(sampler, table, load(&piece.derivatives[n + std::size_t(i)]), gradient, places, i);
        }
    }
}

}  // namespace

void compositeDispatched(const CompositeLayout& layout, const CompositeVoxel* voxels, const CompositeRay* rays,
                         std::size_t count, SampleRoom& room, const SpanTable& spans, RayColor* colors) {
    room.reserve(rays, count);
    const auto one = [](int axis) {
        return axis == 0 ? compositeOne<0> : (axis == 1 ? compositeOne<1> : compositeOne<2>);
    };
    std::size_t n = 0;
    for (std::size_t r = 0; r < count; ++r) {
        room.firsts[r] = std::uint32_t(n);
        n = one(rays[r].axis)(layout, voxels, rays[r], room, n, room.transmittances.data() + n + r,
                              SpanWriter(spans, r), colors[r]);
    }
    room.firsts[count] = std::uint32_t(n);
}

void differentiateDispatched(const CompositeRay* rays, std::size_t count, const SampleRoom& room,
                             const RayColor* derivatives, CompositeTape::Piece& to) {
    for (std::size_t r = 0; r < count; ++r) {
        const std::size_t first = room.firsts[r];
        differentiateOne(room.samples.data() + first, room.transmittances.data() + first + r,
                         room.firsts[r + 1] - first, rays[r].length, derivatives[r], to.derivatives.data() + first);
    }
}

void spreadLayerDispatched(const CompositeLayout& layout, const CompositeRay* rays, std::size_t first, std::size_t last,
                           const CompositeTape::Span* spans, const CompositeTape& tape, CompositeVoxel* gradient) {
    const int axis = rays[first].axis;
    const auto spread = axis == 0 ? spreadLayerAlong<0> : (axis == 1 ? spreadLayerAlong<1> : spreadLayerAlong<2>);
    spread(layout, rays, first, last, spans, tape, gradient);
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(compositeDispatched);
HWY_EXPORT(differentiateDispatched);
HWY_EXPORT(spreadLayerDispatched);

namespace {

/// Makes room for what a piece's rays have met.
void fit(CompositeTape::Piece& piece, const SampleRoom& room, std::size_t rays) {
    piece.used = room.firsts[rays];
    if (piece.derivatives.size() < piece.used) {
        piece.derivatives.resize(piece.used);
        piece.numbers.resize(piece.used);
    }
    std::copy_n(room.numbers.begin(), piece.used, piece.numbers.begin());
    piece.firsts.assign(room.firsts.begin(), room.firsts.begin() + std::ptrdiff_t(rays));
}

/// The rays of one major axis: their layers, every other first.
void spread(const CompositeLayout& layout, const std::vector<CompositeRay>& rays, std::size_t first, std::size_t last,
            const CompositeTape& tape, CompositeVoxel* gradient) {
    const int layers = layout.tableDims[rays[first].axis];
    for (int parity = 0; parity < 2; ++parity)
        parallelFor(std::size_t((layers - parity + 1) / 2), [&](std::size_t n) {
            const std::size_t layer = 2 * n + std::size_t(parity);
            HWY_DYNAMIC_DISPATCH(spreadLayerDispatched)
            (layout, rays.data(), first, last, tape.spans.data() + layer * rays.size(), tape, gradient);
        });
}

/// Sets the derivatives of the samples of a piece's rays.
using PieceRule =
    std::function<void(std::size_t first, std::size_t count, const SampleRoom& room, CompositeTape::Piece& to)>;

/// All rays forth, and what `rule` makes of their samples back.
void traceAndSpread(const CompositeLayout& layout, const CompositeVoxel* voxels, const std::vector<CompositeRay>& rays,
                    const PieceRule& rule, CompositeTape& tape, CompositeVoxel* sums) {
    for (std::size_t r = 1; r < rays.size(); ++r)
        if (rays[r].axis < rays[r - 1].axis)
            throw InvalidArgument("rays must be in the order of their major axes; sort them");
    const std::size_t pieces = (rays.size() + kRaysTogether - 1) / kRaysTogether;
    const int layers = std::max({layout.tableDims.x, layout.tableDims.y, layout.tableDims.z});
    tape.pieces.resize(pieces);
    tape.spans.assign(std::size_t(layers) * rays.size(), {});
    tape.colors.resize(rays.size());
    parallelFor(pieces, [&](std::size_t piece) {
        thread_local SampleRoom room;
        const std::size_t first = piece * kRaysTogether, count = std::min(kRaysTogether, rays.size() - first);
        const SpanTable spans{tape.spans.data() + first, rays.size()};
        HWY_DYNAMIC_DISPATCH(compositeDispatched)
        (layout, voxels, rays.data() + first, count, room, spans, tape.colors.data() + first);
        fit(tape.pieces[piece], room, count);
        rule(first, count, room, tape.pieces[piece]);
    });
    tape.samples = 0;
    for (const CompositeTape::Piece& piece : tape.pieces) tape.samples += piece.used;
    for (std::size_t first = 0; first < rays.size();) {
        std::size_t last = first;
        while (last < rays.size() && rays[last].axis == rays[first].axis) ++last;
        spread(layout, rays, first, last, tape, sums);
        first = last;
    }
}

}  // namespace

CompositeRay compositeRay(const CompositeLayout& layout, const Ray& ray, int perSlice) {
    CompositeRay line;
    const int axis = majorAxis(ray.direction);
    const int others[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    const double major = ray.direction[axis];
    // In slices; samples lie between -1 and dims, both excluded, on all axes.
    double low = -1, high = layout.dims[axis];
    major > 0 ? low = std::max(low, ray.origin[axis]) : high = std::min(high, ray.origin[axis]);
    double place[2], rate[2];
    for (int i = 0; i < 2; ++i) {
        rate[i] = ray.direction[others[i]] / major;
        place[i] = ray.origin[others[i]] - rate[i] * ray.origin[axis];
        const double least = -1, most = layout.dims[others[i]];
        if (std::abs(rate[i]) < 1e-12) {
            if (place[i] <= least || place[i] >= most) high = low;
            continue;
        }
        const double a = (least - place[i]) / rate[i], b = (most - place[i]) / rate[i];
        low = std::max(low, std::min(a, b));
        high = std::min(high, std::max(a, b));
    }
    // A little inside: what is at the very edge sees nothing, and rounding must not bring it out.
    constexpr double kInside = 1e-4;
    const double first = std::floor((low + kInside) * perSlice) + 1, last = std::ceil((high - kInside) * perSlice) - 1;
    line.axis = axis;
    line.count = last >= first ? int(last - first) + 1 : 0;
    const double start = (major > 0 ? first : last) / perSlice, step = (major > 0 ? 1.0 : -1.0) / perSlice;
    line.start = float(start);
    line.step = float(step);
    for (int i = 0; i < 2; ++i) {
        line.place[i] = float(place[i] + rate[i] * start);
        line.rate[i] = float(rate[i] * step);
    }
    line.length = float(ray.direction.length() / std::abs(major) / perSlice);
    return line;
}

bool meetsBricks(const CompositeLayout& layout, const CompositeRay& ray) {
    const CellWalk walk(layout, ray);
    for (int k = 0; k < ray.count;) {
        const int next = walk.next(k);
        if (next == k) return true;
        k = next;
    }
    return false;
}

void composite(const CompositeLayout& layout, const CompositeVoxel* voxels, const CompositeRay* rays, std::size_t count,
               RayColor* colors) {
    parallelFor((count + kRaysTogether - 1) / kRaysTogether, [&](std::size_t piece) {
        thread_local SampleRoom room;
        const std::size_t first = piece * kRaysTogether;
        HWY_DYNAMIC_DISPATCH(compositeDispatched)
        (layout, voxels, rays + first, std::min(kRaysTogether, count - first), room, {}, colors + first);
    });
}

void compositeGradient(const CompositeLayout& layout, const CompositeVoxel* voxels,
                       const std::vector<CompositeRay>& rays, const RayLoss& loss, CompositeTape& tape,
                       CompositeVoxel* gradient) {
    const auto rule = [&](std::size_t first, std::size_t count, const SampleRoom& room, CompositeTape::Piece& to) {
        RayColor derivatives[kRaysTogether];
        loss(first, count, tape.colors.data() + first, derivatives);
        HWY_DYNAMIC_DISPATCH(differentiateDispatched)(rays.data() + first, count, room, derivatives, to);
    };
    traceAndSpread(layout, voxels, rays, rule, tape, gradient);
}

void compositeSpread(const CompositeLayout& layout, const CompositeVoxel* voxels, const std::vector<CompositeRay>& rays,
                     const SampleRule& rule, CompositeTape& tape, CompositeVoxel* sums) {
    const auto each = [&](std::size_t first, std::size_t count, const SampleRoom& room, CompositeTape::Piece& to) {
        for (std::size_t r = 0; r < count; ++r) {
            const std::size_t begin = room.firsts[r];
            rule(first + r,
                 {rays[first + r], tape.colors[first + r], room.samples.data() + begin,
                  room.transmittances.data() + begin + r, room.numbers.data() + begin, room.firsts[r + 1] - begin},
                 to.derivatives.data() + begin);
        }
    };
    traceAndSpread(layout, voxels, rays, each, tape, sums);
}

}  // namespace raysweep
#endif  // HWY_ONCE
