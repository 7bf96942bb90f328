// Shares are gathered layer by layer of bricks across the rays' major axis: a task owns one, and adds what all rays
// have there in the order of the rays, so that no two threads write to a voxel, and sums have one order. Samples
// between two layers belong to the lower one and reach into the next: so every other layer is done first.
#include "raysweep/projector/composite_spread.h"

#include "raysweep/core/parallel.h"

#include <hwy/cache_control.h>

#include <algorithm>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/projector/composite_spread.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/composite_sampler-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// Samples of one ray whose places are known.
struct Located {
    Places places;
    const SampleShare* shares;
    const RayColor* color;
    int count;
};

template <int kAxis>
HWY_INLINE void spreadAll(const Located& samples, CompositeVoxel* HWY_RESTRICT gradient) {
    const Four color = load(*samples.color);
    for (int i = 0; i < samples.count; ++i) {
        const Four given = firstOf(setFour(samples.shares[i].extinction), color * setFour(samples.shares[i].color));
        spreadFrom<kAxis>(given, gradient, samples.places, i);
    }
}

/// A piece has little in each layer, so that every piece's would be waited for.
HWY_INLINE void fetch(const CompositeTape::Piece& piece, const CompositeTape::Part& part) {
    constexpr std::size_t kLine = 64, kShares = kLine / sizeof(SampleShare), kRuns = kLine / sizeof(CompositeTape::Run);
    constexpr std::size_t kMostShares = 8 * kRaysTogether;  // of most layers all; a hint may point anywhere
    for (std::size_t run = part.run; run < part.end; run += kRuns) hwy::Prefetch(piece.runs.data() + run);
    for (std::size_t n = 0; n < kMostShares; n += kShares) hwy::Prefetch(piece.shares.data() + part.share + n);
}

/// The samples of a layer, ray after ray in their order. Places of some are found before others are added to: their
/// voxels are asked for in between.
template <int kAxis>
void spreadLayerAlong(const CompositeLayout& layout, const CompositeRay* rays, std::size_t first, std::size_t last,
                      std::size_t layer, const CompositeTape& tape, CompositeVoxel* gradient) {
    constexpr std::size_t kWaiting = 4, kAhead = 2;
    const Sampler<kAxis> sampler(layout);
    Located waiting[kWaiting];
    std::size_t asked = 0;
    for (std::size_t p = first / kRaysTogether; p * kRaysTogether < last; ++p) {
        if ((p + kAhead) * kRaysTogether < last)
            fetch(tape.pieces[p + kAhead], tape.parts[layer * tape.pieces.size() + p + kAhead]);
        const CompositeTape::Piece& piece = tape.pieces[p];
        const CompositeTape::Part part = tape.parts[layer * tape.pieces.size() + p];
        const SampleShare* shares = piece.shares.data() + part.share;
        for (std::uint32_t n = part.run; n < part.end; ++n) {
            const CompositeTape::Run run = piece.runs[n];
            const std::size_t r = p * kRaysTogether + run.ray;
            const int count = run.count;
            const SampleShare* next = shares;
            shares += count;
            if (r < first || r >= last) continue;
            for (int from = 0; from < count; from += kChunk) {
                Located& to = waiting[asked % kWaiting];
                if (asked >= kWaiting) spreadAll<kAxis>(to, gradient);
                ++asked;
                to.shares = next + from;
                to.color = &tape.shared[r];
                to.count = std::min(kChunk, count - from);
                sampler.locate(rays[r], run.first + from, run.first + count - 1, to.places);
                sampler.prefetch(gradient, to.places, to.count);
            }
        }
    }
    for (std::size_t n = asked - std::min(asked, kWaiting); n < asked; ++n)
        spreadAll<kAxis>(waiting[n % kWaiting], gradient);
}

}  // namespace

void spreadLayerDispatched(const CompositeLayout& layout, const CompositeRay* rays, std::size_t first, std::size_t last,
                           std::size_t layer, const CompositeTape& tape, CompositeVoxel* gradient) {
    const int axis = rays[first].axis;
    const auto spread = axis == 0 ? spreadLayerAlong<0> : (axis == 1 ? spreadLayerAlong<1> : spreadLayerAlong<2>);
    spread(layout, rays, first, last, layer, tape, gradient);
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(spreadLayerDispatched);

namespace {

/// The rays of one major axis: their layers, every other first.
void spread(const CompositeLayout& layout, const std::vector<CompositeRay>& rays, std::size_t first, std::size_t last,
            const CompositeTape& tape, CompositeVoxel* gradient) {
    const int layers = layout.tableDims[rays[first].axis];
    for (int parity = 0; parity < 2; ++parity)
        parallelFor(std::size_t((layers - parity + 1) / 2), [&](std::size_t n) {
            const std::size_t layer = 2 * n + std::size_t(parity);
            HWY_DYNAMIC_DISPATCH(spreadLayerDispatched)
            (layout, rays.data(), first, last, layer, tape, gradient);
        });
}

}  // namespace

void spreadShares(const CompositeLayout& layout, const std::vector<CompositeRay>& rays, const CompositeTape& tape,
                  CompositeVoxel* sums) {
    for (std::size_t first = 0; first < rays.size();) {
        std::size_t last = first;
        while (last < rays.size() && rays[last].axis == rays[first].axis) ++last;
        spread(layout, rays, first, last, tape, sums);
        first = last;
    }
}

}  // namespace raysweep
#endif  // HWY_ONCE
