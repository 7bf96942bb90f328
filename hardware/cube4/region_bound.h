// Bound of two regions: rays are split or merged.
//
// Holds      the beam buffer of rays: of each pipeline the last row's.
// Per cycle  split: a partial beam of p rays is written, for which p/2 are read; merge: p are read, and p/2 written for
//            every other row. The ray (i,j) of a plane is in pipeline (i + j) mod p; what has to move by several
//            pipelines takes as many cycles as the busiest of the ring's 2p links, if they are used evenly.
// Latency    a row. Neighbours: a ray from the pipeline beside, along u and then along v.
//
//     split, along u and then along v    f(2i) = c(i),    f(2i+1) = (c(i) + c(i+1)) / 2
//     merge                              c(i) = (f(2i-1) + 2 f(2i) + f(2i+1)) / 4: half the adjoint of the split
//
// Merging halves, so that words do not grow: over both axes it is the adjoint by four. It is used for corrections,
// value and weight alike, of which only the ratio counts.
#pragma once

#include "cube4/perspective.h"

#include <cstdlib>

namespace raysweep::cube4 {

template <class Arithmetic>
class RegionBound {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    /// @param empty what a ray carries that met nothing
    RegionBound(const Arithmetic& arithmetic, int pipelines, Counters& counters, const Ray<Word>& empty = {})
        : arithmetic_(arithmetic), pipelines_(pipelines), counters_(counters), empty_(empty) {
        half_.high = arithmetic.weight(0.5);
        half_.low = arithmetic.weight(1) - half_.high;
    }

    const Arithmetic& arithmetic() const { return arithmetic_; }

    RayPlane<Word> split(const RayPlane<Word>& coarse, const LatticeRange& fine) {
        RayPlane<Word> out = planeOf<Word>(fine);
        const auto at = [&](int u, int v) { return rayAt(coarse, u, v); };
        const auto alongU = [&](int u, int v) {
            return u & 1 ? mean(at(u >> 1, v), at((u >> 1) + 1, v)) : at(u >> 1, v);
        };
        for (int v = fine.lowV; v <= fine.highV; ++v)
            for (int u = fine.lowU; u <= fine.highU; ++u)
                out.at(u, v) = v & 1 ? mean(alongU(u, v >> 1), alongU(u, (v >> 1) + 1)) : alongU(u, v >> 1);
        clock(out);
        counters_.rayReads += coarse.rays.size();
        counters_.rayWrites += out.rays.size();
        return out;
    }

    RayPlane<Word> merge(const RayPlane<Word>& fine, const LatticeRange& coarse) {
        RayPlane<Word> out = planeOf<Word>(coarse);
        const auto at = [&](int u, int v) { return rayAt(fine, u, v); };
        const auto alongU = [&](int u, int v) { return mean(mean(at(2 * u - 1, v), at(2 * u + 1, v)), at(2 * u, v)); };
        for (int v = coarse.lowV; v <= coarse.highV; ++v)
            for (int u = coarse.lowU; u <= coarse.highU; ++u)
                out.at(u, v) = mean(mean(alongU(u, 2 * v - 1), alongU(u, 2 * v + 1)), alongU(u, 2 * v));
        clock(fine);
        counters_.rayReads += fine.rays.size();
        counters_.rayWrites += out.rays.size();
        return out;
    }

  private:
    static constexpr int kRayWords = 2;

    Ray<Word> rayAt(const RayPlane<Word>& plane, int u, int v) const {
        const bool inside =
            u >= plane.lowU && u < plane.lowU + plane.width && v >= plane.lowV && v < plane.lowV + plane.height;
        return inside ? plane.at(u, v) : empty_;
    }

    Ray<Word> mean(const Ray<Word>& a, const Ray<Word>& b) const {
        return {arithmetic_.mix(half_, a.value, b.value), arithmetic_.mix(half_, a.weight, b.weight)};
    }

    /// The cycles of a plane of fine rays, a partial beam after the other, and the words that go along the ring.
    void clock(const RayPlane<Word>& fine) {
        counters_.boundRays = std::max(counters_.boundRays, std::uint64_t(fine.rays.size()));
        for (int v = fine.lowV; v < fine.lowV + fine.height; ++v)
            for (int first = fine.lowU; first < fine.lowU + fine.width; first += pipelines_) {
                const int end = std::min(first + pipelines_, fine.lowU + fine.width);
                int hops = 0;
                for (int u = first; u < end; ++u)
                    if (!(u & 1)) hops += distance(u + v - ((u >> 1) + (v >> 1)));
                const std::uint64_t cycles = std::uint64_t(std::max(1, (hops + 2 * pipelines_ - 1) / (2 * pipelines_)));
                counters_.cycles += cycles;
                counters_.boundCycles += cycles;
                // The long way, then a neighbour's along the beam and one from beam to beam.
                if (pipelines_ > 1)
                    counters_.wordsOn += std::uint64_t(kRayWords) * std::uint64_t(hops + 2 * (end - first));
            }
    }

    /// Pipelines between two that are `by` apart, the shorter way round.
    int distance(int by) const {
        const int rest = std::abs(by) % pipelines_;
        return std::min(rest, pipelines_ - rest);
    }

    const Arithmetic& arithmetic_;
    int pipelines_;
    Counters& counters_;
    Ray<Word> empty_;
    Between<Weight> half_;
};

/// Takes a front's rays through all of its regions. Away from the point they are split at bounds, towards it merged.
/// @param rays at the level of the first region that is passed
/// @param run does a pass: (RegionPass, entering rays) -> leaving rays
template <class Arithmetic, class Run>
RayPlane<typename Arithmetic::Word> passRegions(RegionBound<Arithmetic> bound, const Journey& journey,
                                                RayPlane<typename Arithmetic::Word> rays, const Run& run) {
    const PerspectiveFront& front = journey.front;
    std::vector<Region> regions = front.regions;
    if (journey.order == RayOrder::converging) std::reverse(regions.begin(), regions.end());
    int level = regions.front().level;
    for (const Region& region : regions) {
        for (; level > region.level; --level) rays = bound.split(rays, front.rangeAt(level - 1));
        for (; level < region.level; ++level) rays = bound.merge(rays, front.rangeAt(level + 1));
        for (int v = 0; v < region.sublattices; ++v)
            for (int u = 0; u < region.sublattices; ++u)
                rays = run(regionPass(bound.arithmetic(), journey, region, {u, v}), rays);
    }
    return rays;
}

}  // namespace raysweep::cube4
