/// Where rays go that have met the voxels of a slice.
#pragma once

#include "cube4/ray_buffer.h"

#include <cstdint>

namespace raysweep::cube4 {

/// A ray on its way back to the compositing buffer.
template <class Word>
struct FinishedRay {
    Ray<Word> ray;
    std::int32_t slot = -1;  ///< address in the buffer; -1: none, it has left
    std::int32_t hops = 0;   ///< pipelines that it has to move on, where rays diverge
    RayTag tag{};            ///< of it in the next slice
};

/// finishRays for rays that come from a point: each goes its own way.
template <class Word, class Weight, class RayAt>
void finishDiverging(const Beam<Weight>& beam, const Traversal& traversal, const RayBuffer<Word>& buffer,
                     Lanes<FinishedRay<Word>>& rays, RayPlane<Word>& leaving, const RayAt& rayAt) {
    const SliceSetup<Weight>& slice = *beam.slice;
    const int row = beam.row - traversal.reach;
    if (row < 0 || !slice.placesV[std::size_t(row)].hasRay) return;
    const Place<Weight>& v = slice.placesV[std::size_t(row)];
    forEachLane(beam, int(rays.size()), traversal.size.x, [&](std::size_t lane, int at) {
        const int column = at - traversal.reach;
        if (column < 0 || !slice.placesU[std::size_t(column)].hasRay) return;
        const Place<Weight>& u = slice.placesU[std::size_t(column)];
        if (slice.last || u.to < 0 || v.to < 0)
            leaving.at(u.ray, v.ray) = rayAt(lane);
        else
            rays[lane] = {rayAt(lane),
                          buffer.slotOf(u.to, v.to, slice.number + 1),
                          slice.hops + u.to - column + v.to - row,
                          {{u.ray, v.ray, slice.number + 1}}};
    });
}

/// Gives the rays that end in a partial beam, `reach` voxels back along u and v, their places: in the buffer if they
/// are still inside in the next slice, else among those that leave. @param rayAt the finished ray of a pipeline
template <class Word, class Weight, class RayAt>
void finishRays(const Beam<Weight>& beam, const Traversal& traversal, const RayBuffer<Word>& buffer,
                Lanes<FinishedRay<Word>>& rays, RayPlane<Word>& leaving, const RayAt& rayAt) {
    const SliceSetup<Weight>& slice = *beam.slice;
    const int reach = traversal.reach, v = beam.row - reach;
    const int lastU = traversal.size.x - 1 - reach, lastV = traversal.size.y - 1 - reach;
    for (FinishedRay<Word>& ray : rays) ray.slot = -1;
    if (slice.diverges()) {
        finishDiverging(beam, traversal, buffer, rays, leaving, rayAt);
        return;
    }
    if (v < 0) return;
    const bool leavesRow = slice.last || v + slice.toV < 0 || v + slice.toV > lastV;
    const auto address = buffer.addressOf(v, slice.shiftU, slice.shiftV);
    forEachLane(beam, int(rays.size()), traversal.size.x, [&](std::size_t lane, int at) {
        const int u = at - reach;
        if (u < 0) return;
        const Ray<Word> ray = rayAt(lane);
        if (leavesRow || u + slice.toU < 0 || u + slice.toU > lastU)
            leaving.at(u - slice.shiftU, v - slice.shiftV) = ray;
        else
            rays[lane] = {ray, address.slotOf(u), 0, {{u - slice.shiftU, v - slice.shiftV, slice.number + 1}}};
    });
}

}  // namespace raysweep::cube4
