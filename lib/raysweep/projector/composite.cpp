// Rays go through the volume in parallel, each leaving the derivatives of its samples. These are then gathered slice by
// slice: a task owns a layer of bricks across the rays' major axis, and adds what all rays have there in the order of
// the rays, so that no two threads write to a voxel, and sums have one order. Samples between two layers belong to the
// lower one and reach into the next: so every other layer is done first.
#include "raysweep/projector/composite.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/projector/composite_ray.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/projector/composite.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/composite_sampler-inl.h"

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

/// Those of ray `r` of a piece.
RaySamples samplesOf(const SampleRoom& room, std::size_t r, const CompositeRay& ray, const RayColor& color) {
    const std::size_t begin = room.firsts[r];
    return {ray,
            color,
            room.samples.data() + begin,
            room.transmittances.data() + begin + r,
            room.numbers.data() + begin,
            room.firsts[r + 1] - begin};
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

void compositeSamples(const CompositeLayout& layout, const CompositeVoxel* voxels,
                      const std::vector<CompositeRay>& rays, const SampleVisitor& visit) {
    parallelFor((rays.size() + kRaysTogether - 1) / kRaysTogether, [&](std::size_t piece) {
        thread_local SampleRoom room;
        const std::size_t first = piece * kRaysTogether, count = std::min(kRaysTogether, rays.size() - first);
        RayColor colors[kRaysTogether];
        HWY_DYNAMIC_DISPATCH(compositeDispatched)
        (layout, voxels, rays.data() + first, count, room, {}, colors);
        for (std::size_t r = 0; r < count; ++r) visit(first + r, samplesOf(room, r, rays[first + r], colors[r]));
    });
}

void compositeSpread(const CompositeLayout& layout, const CompositeVoxel* voxels, const std::vector<CompositeRay>& rays,
                     const SampleRule& rule, CompositeTape& tape, CompositeVoxel* sums) {
    const auto each = [&](std::size_t first, std::size_t count, const SampleRoom& room, CompositeTape::Piece& to) {
        for (std::size_t r = 0; r < count; ++r)
            rule(first + r, samplesOf(room, r, rays[first + r], tape.colors[first + r]),
                 to.derivatives.data() + room.firsts[r]);
    };
    traceAndSpread(layout, voxels, rays, each, tape, sums);
}

}  // namespace raysweep
#endif  // HWY_ONCE
