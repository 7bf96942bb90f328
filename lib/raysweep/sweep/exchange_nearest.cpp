// `nearest`: a voxel meets one ray of each beam. Dachille, Mueller and Kaufman 2000, Algorithm 1, with the corrections
// of docs/illumination.md. Compiled once per instruction set; the best one that the machine has is chosen at run time.
#include "raysweep/sweep/exchange.h"

#include <hwy/cache_control.h>

#include <algorithm>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/sweep/exchange_nearest.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/sweep/visited_brick-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

using Mask = hn::Mask<Lanes>;

/// Local furnace of rays side by side, from `firstRay` on. @return what the voxels take
HWY_INLINE Vec exchangeFurnace(const BeamSlice& beam, std::ptrdiff_t firstRay, Vec opacity, const VoxelSolids& solids,
                               int slice) {
    float *const f = beam.furnace + firstRay, *const lastSlice = beam.lastSlice + firstRay;
    const Vec last = hn::LoadU(kLanes, lastSlice), now = hn::Set(kLanes, float(slice));
    const Mask close = hn::Ge(last, hn::Set(kLanes, float(slice - kSurfaceGap)));
    const Vec ray = hn::IfThenElse(close, hn::LoadU(kLanes, f), hn::Set(kLanes, beam.beam->furnaceRay));
    const Vec in = hn::IfThenElseZero(solids.inside, hn::Mul(ray, opacity));
    const Vec lastNow = hn::IfThenElse(solids.leaving, hn::Set(kLanes, kLongAgo), last);
    hn::StoreU(hn::Sub(ray, in), kLanes, f);
    hn::StoreU(hn::IfThenElse(solids.inside, now, lastNow), kLanes, lastSlice);
    return in;
}

/// Voxels side by side, as many as a vector has lanes, and what they exchange with all beams.
template <int kChannels>
struct Voxels {
    Vec tau, shotPart;
    Vec unshot[kChannels];
    // Of the first voxel:
    int row, lane;  ///< in the slice
    int slice;      ///< number, in the order of travel
    int at;         ///< offset in a SliceView

    Vec in[kChannels], out[kChannels], furnace;
};

/// The rays of all beams at one slice of a brick, and what rules them.
struct BeamSlices {
    ExchangeRule rule;
    float mostScale;  ///< largest step scale of the beams
    int count;
    BeamSlice beams[kMostBeams];
};

/// The rays of all beams meet the voxels. `kSurfaces`: some of these have a surface or are the inside of a solid.
template <int kChannels, bool kThinOnly, bool kSurfaces>
HWY_INLINE void meetBeams(const BeamSlices& slices, const VoxelSurfaces& surfaces, Voxels<kChannels>& voxels) {
    const ExchangeRule& rule = slices.rule;
    const bool hasNormals = kSurfaces && !hn::AllFalse(kLanes, surfaces.surface);
    VoxelSolids solids;
    if (kSurfaces) solids = {surfaces.solid, surfaces.surface};  // nothing leaves where there is no surface
    for (int k = 0; k < slices.count; ++k) {
        const BeamSlice& beam = slices.beams[k];
        VoxelTerms terms = voxelTerms<kThinOnly>(rule, beam.beam->stepScale, voxels.tau, voxels.shotPart);
        if (hasNormals) solids = applySurfaces(rule, beam.beam->front.direction, surfaces, terms);
        const std::ptrdiff_t ray = beam.rowStart[voxels.row] + voxels.lane;
        // Elsewhere rays are as long outside as they were; nothing of the furnace would change.
        if (kSurfaces && beam.furnace)
            voxels.furnace = hn::Add(voxels.furnace, exchangeFurnace(beam, ray, terms.opacity, solids, voxels.slice));
        for (int c = 0; c < kChannels; ++c) {
            float* const power = beam.power + c * beam.planeStride + ray;
            const Vec e = hn::LoadU(kLanes, power);
            const Vec taken = hn::Mul(e, terms.opacity), given = hn::Mul(voxels.unshot[c], terms.shot);
            const Vec after = hn::Add(hn::Sub(e, taken), given);
            requireNonNegative(after);
            hn::StoreU(after, kLanes, power);
            voxels.in[c] = hn::Add(voxels.in[c], taken);
            voxels.out[c] = hn::Add(voxels.out[c], given);
        }
    }
}

/// Reads voxels, exchanges, and notes what was exchanged. In a brick that has surfaces most voxels have none, and are
/// treated as those of other bricks.
/// `kFirst`: no beams have passed the voxels before.
template <int kChannels, bool kThinOnly, bool kSurfaces, bool kFirst>
HWY_INLINE void exchangeVoxels(const BeamSlices& slices, const SliceView<kChannels>& view, Voxels<kChannels>& voxels,
                               Exchanged<kChannels>& exchanged) {
    const int at = voxels.at;
    voxels.tau = hn::Load(kLanes, view.tau + at);
    Vec any = voxels.tau;
    for (int c = 0; c < kChannels; ++c) {
        voxels.unshot[c] = hn::Load(kLanes, view.unshot[c] + at);
        any = hn::Or(any, voxels.unshot[c]);
        voxels.in[c] = kFirst ? hn::Zero(kLanes) : hn::Load(kLanes, exchanged.in[c] + at);
        voxels.out[c] = kFirst ? hn::Zero(kLanes) : hn::Load(kLanes, exchanged.out[c] + at);
    }
    voxels.furnace = !kSurfaces || kFirst ? hn::Zero(kLanes) : hn::Load(kLanes, exchanged.furnace + at);
    // In sparse volumes many voxels are empty: nothing there that could change a ray or be changed by one.
    if (!hn::AllTrue(kLanes, hn::Eq(any, hn::Zero(kLanes)))) {
        voxels.shotPart = hn::Mul(hn::Load(kLanes, exchanged.inverseEscape + at), hn::Set(kLanes, slices.rule.part));
        VoxelSurfaces surfaces;
        if (kSurfaces) surfaces = voxelSurfaces(view.normals + at, voxels.tau);
        if (kSurfaces && !hn::AllFalse(kLanes, hn::Or(surfaces.surface, surfaces.solid)))
            meetBeams<kChannels, false, true>(slices, surfaces, voxels);
        else if (kThinOnly ||
                 (kSurfaces && hn::AllTrue(kLanes, hn::Le(voxels.tau, hn::Set(kLanes, kThin / slices.mostScale)))))
            meetBeams<kChannels, true, false>(slices, surfaces, voxels);
        else
            meetBeams<kChannels, false, false>(slices, surfaces, voxels);
    }
    for (int c = 0; c < kChannels; ++c) {
        hn::Store(voxels.in[c], kLanes, exchanged.in[c] + at);
        hn::Store(voxels.out[c], kLanes, exchanged.out[c] + at);
    }
    if (kSurfaces) hn::Store(voxels.furnace, kLanes, exchanged.furnace + at);
}

/// What a core is asked for while it is busy with a brick: it will be here when its turn comes.
class Prefetched {
  public:
    /// 512 values.
    void add(const void* values) { all_[count_++] = static_cast<const char*>(values); }
    /// Asks for an eighth of them.
    HWY_INLINE void ask(int eighth) const {
        constexpr int kEighth = kBrickVoxels * int(sizeof(float)) / kBrickEdge, kLine = 64;
        for (int i = eighth * kEighth; i < (eighth + 1) * kEighth; i += kLine)
            for (int n = 0; n < count_; ++n) hwy::Prefetch(all_[n] + i);
    }

  private:
    const char* all_[2 + 4 * kMaxChannels];
    int count_ = 0;
};

/// Of a brick that beams come to.
template <int kChannels>
Prefetched fieldsOf(const Brick<kChannels>& brick, bool hasSource) {
    Prefetched fields;
    fields.add(brick.tau);
    for (int c = 0; c < kChannels; ++c) {
        fields.add(brick.unshot[c]);
        fields.add(brick.deposit[c]);
        if (hasSource) fields.add(brick.source[c]);
    }
    return fields;
}

/// Of a brick that some have passed.
template <int kChannels>
Prefetched exchangeOf(const VisitedBrick<kChannels>& visited) {
    Prefetched fields;
    fields.add(visited.view.tau);
    fields.add(visited.exchanged.inverseEscape);
    for (int c = 0; c < kChannels; ++c) {
        fields.add(visited.view.unshot[c]);
        fields.add(visited.exchanged.in[c]);
        fields.add(visited.exchanged.out[c]);
        fields.add(visited.brick.deposit[c]);
    }
    return fields;
}

/// The rays of beams go through the eight slices of a brick.
template <int kChannels, bool kThinOnly, bool kSurfaces, bool kFirst>
void exchangeSlices(const Swept& swept, const std::vector<SweptBeam>& beams, const Prefetched& next,
                    VisitedBrick<kChannels>& visited) {
    const RayFront& front = swept.beams.front();
    BeamSlices slices{ExchangeRule(swept.constants), swept.mostScale, int(beams.size()), {}};
    for (int j = 0; j < kBrickEdge; ++j) {
        next.ask(j);
        const int k = visited.visit.slice + j;
        for (int b = 0; b < slices.count; ++b)
            slices.beams[b] = beamSlice(beams[std::size_t(b)], visited.visit, k, visited.brick.furnace);
        const int slice = front.ascending ? j : kBrickEdge - 1 - j;
        int at = slice * front.axis.sliceStride;
        for (int row = 0; row < kBrickEdge; ++row, at += front.axis.rowStride)
            for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
                Voxels<kChannels> voxels;
                voxels.row = row;
                voxels.lane = lane;
                voxels.slice = k;
                voxels.at = at + lane;
                exchangeVoxels<kChannels, kThinOnly, kSurfaces, kFirst>(slices, visited.view, voxels,
                                                                        visited.exchanged);
            }
    }
}

/// Beams pass a brick, the first ones or those that follow. @param next what the brick after this one needs
template <int kChannels, bool kFirst>
HWY_INLINE void pass(const Swept& swept, const std::vector<SweptBeam>& beams, const Prefetched& next,
                     VisitedBrick<kChannels>& visited) {
    if (visited.brick.normals)
        exchangeSlices<kChannels, false, true, kFirst>(swept, beams, next, visited);
    else if (visited.thickest * swept.mostScale <= kThin)
        exchangeSlices<kChannels, true, false, kFirst>(swept, beams, next, visited);
    else
        exchangeSlices<kChannels, false, false, kFirst>(swept, beams, next, visited);
}

template <int kChannels>
void exchangeVisits(const Swept& swept, const std::vector<BrickVisit>& visits, const ExchangeFields& fields) {
    const std::vector<SweptBeam>&along = swept.beams.along, &against = swept.beams.against;
    const bool hasSource = fields.source[0].stride > 0;
    std::vector<VisitedBrick<kChannels>> row(1);
    for (std::size_t first = 0, last = 0; first < visits.size(); first = last) {
        last = against.empty() ? first + 1 : endOfRow(visits, first);
        if (row.size() < last - first) row.resize(last - first);
        for (std::size_t i = first; i < last; ++i) {
            const Brick<kChannels> next(fields, visits[std::min(i + 1, visits.size() - 1)].brick);
            begin(swept, fields, visits[i], row[i - first]);
            pass<kChannels, true>(swept, along, fieldsOf(next, hasSource), row[i - first]);
        }
        for (std::size_t i = last - first; i-- > 0;) {
            if (!against.empty()) pass<kChannels, false>(swept, against, exchangeOf(row[i > 0 ? i - 1 : 0]), row[i]);
            end(swept, row[i]);
        }
    }
}

}  // namespace

void nearestDispatched(const SweptBeams& beams, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                       const ExchangeConstants& constants) {
    const Swept swept{beams, constants, beams.mostStepScale()};
    fields.channels == 1 ? exchangeVisits<1>(swept, visits, fields) : exchangeVisits<3>(swept, visits, fields);
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(nearestDispatched);

void exchangeNearest(const SweptBeams& beams, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                     const ExchangeConstants& constants) {
    HWY_DYNAMIC_DISPATCH(nearestDispatched)(beams, visits, fields, constants);
}

}  // namespace raysweep
#endif  // HWY_ONCE
