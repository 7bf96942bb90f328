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

#include "raysweep/sweep/beam_slice-inl.h"
#include "raysweep/sweep/exchange_terms-inl.h"
#include "raysweep/sweep/transpose-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

using Mask = hn::Mask<Lanes>;

HWY_INLINE void requireNonNegative(Vec value) {
    (void)value;
    HWY_DASSERT(hn::AllTrue(kLanes, hn::Ge(value, hn::Zero(kLanes))));
}

/// The 512 values of one brick in each field.
template <int kChannels>
struct Brick {
    const float* tau;
    const float* albedo[kChannels];
    const float* source[kChannels];
    float* unshot[kChannels];
    float* deposit[kChannels];
    const PackedNormal* normals;  ///< null: no surfaces
    float* furnace;               ///< null: not measured

    Brick() = default;
    Brick(const ExchangeFields& fields, std::size_t b) : tau(fields.tau.brick(b)) {
        for (int c = 0; c < kChannels; ++c) {
            albedo[c] = fields.albedo[c].brick(b);
            source[c] = fields.source[c].brick(b);
            unshot[c] = fields.unshot[c].brick(b);
            deposit[c] = fields.deposit[c].brick(b);
        }
        normals = fields.surfaces ? fields.surfaces->normals(b) : nullptr;
        furnace = normals && fields.furnace.data ? fields.furnace.brick(fields.surfaces->slots[b]) : nullptr;
    }
};

/// What a brick exchanges with all beams. The first half is read in the order of slices, and so is the second written.
template <int kChannels>
struct Exchanged {
    HWY_ALIGN float inverseEscape[kBrickVoxels];
    HWY_ALIGN float tau[kBrickVoxels];  ///< this and the next two only where they are not as the brick has them
    HWY_ALIGN float unshot[kChannels][kBrickVoxels];
    HWY_ALIGN PackedNormal normals[kBrickVoxels];

    HWY_ALIGN float in[kChannels][kBrickVoxels];
    HWY_ALIGN float out[kChannels][kBrickVoxels];
    HWY_ALIGN float furnace[kBrickVoxels];
    HWY_ALIGN float raysMet[kBrickVoxels];  ///< only where that is not one of each beam
};

/// The order of slices within a brick.
template <int kChannels>
struct SliceView {
    const float* tau;
    const float* unshot[kChannels];
    const PackedNormal* normals;
};

/// A brick on its way through a sweep.
template <int kChannels>
struct VisitedBrick {
    BrickVisit visit;
    Brick<kChannels> brick;
    SliceView<kChannels> view;
    bool whole;      ///< all its voxels meet a ray of each beam
    float thickest;  ///< largest tau
    Exchanged<kChannels> exchanged;
};

/// What is the same for all bricks.
struct Swept {
    const SweptBeams& beams;
    const ExchangeConstants& constants;
    float mostScale;  ///< largest step scale of the beams
};

template <class T>
HWY_INLINE void turn(T* values) {
    HWY_ALIGN T turned[kBrickVoxels];
    transposePlanes(values, turned, 0, kBrickEdge - 1);
    std::copy_n(turned, kBrickVoxels, values);
}

/// Finds 1 / p. @return the largest tau
HWY_INLINE float findEscape(const ExchangeConstants& constants, const float* from, float* inverse) {
    Vec most = hn::Zero(kLanes);
    for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes))) {
        const Vec tau = hn::Load(kLanes, from + i);
        most = hn::Max(most, tau);
        hn::Store(inverseEscape(constants, tau), kLanes, inverse + i);
    }
    return hn::GetLane(hn::MaxOfLanes(kLanes, most));
}

/// Turns what slices read, if they do not lie in the brick as they should.
template <int kChannels>
HWY_INLINE SliceView<kChannels> viewSlices(const SweepAxis& axis, const Brick<kChannels>& brick,
                                           Exchanged<kChannels>& to) {
    SliceView<kChannels> view{brick.tau, {}, brick.normals};
    for (int c = 0; c < kChannels; ++c) view.unshot[c] = brick.unshot[c];
    if (!axis.transposed) return view;
    constexpr int kLast = kBrickEdge - 1;
    turn(to.inverseEscape);
    transposePlanes(brick.tau, to.tau, 0, kLast);
    view.tau = to.tau;
    for (int c = 0; c < kChannels; ++c) {
        transposePlanes(brick.unshot[c], to.unshot[c], 0, kLast);
        view.unshot[c] = to.unshot[c];
    }
    if (brick.normals) transposePlanes(brick.normals, to.normals, 0, kLast);
    view.normals = brick.normals ? to.normals : nullptr;
    return view;
}

/// In a periodic volume a brick may hang over the end of the lattice, and be met as another image there. Takes what
/// lies beyond from the slices: rows without a ray look empty, and lanes without one have nothing to shoot, so that the
/// rays in the lattice's padding, which they meet instead, stay dark.
template <int kChannels>
void clipSlices(const RayFront& front, const BrickClip& clips, SliceView<kChannels>& view, Exchanged<kChannels>& to) {
    for (int j = 0; j < kBrickEdge; ++j) {
        const Clip& clip = clips.slices[j];
        int at = (front.ascending ? j : kBrickEdge - 1 - j) * front.axis.sliceStride;
        for (int row = 0; row < kBrickEdge; ++row, at += front.axis.rowStride)
            for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
                const int i = at + lane;
                const bool missed = clip.missesRow(row) || clip.empty();
                const Vec met = missed ? hn::Zero(kLanes) : hn::IfThenElseZero(clip.lanes(lane), hn::Set(kLanes, 1.0f));
                hn::Store(met, kLanes, to.raysMet + i);
                hn::Store(missed ? hn::Zero(kLanes) : hn::Load(kLanes, view.tau + i), kLanes, to.tau + i);
                for (int c = 0; c < kChannels; ++c)
                    hn::Store(hn::Mul(met, hn::Load(kLanes, view.unshot[c] + i)), kLanes, to.unshot[c] + i);
            }
    }
    view.tau = to.tau;
    for (int c = 0; c < kChannels; ++c) view.unshot[c] = to.unshot[c];
}

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

/// Brings U and D up to date: D += in, U += g in - out + source for each ray met. @param clipped some meet none
template <int kChannels>
HWY_INLINE void bookExchange(const Brick<kChannels>& brick, int beams, bool clipped,
                             const Exchanged<kChannels>& exchanged) {
    const Vec zero = hn::Zero(kLanes);
    for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes))) {
        const Vec raysMet = clipped ? hn::Load(kLanes, exchanged.raysMet + i) : hn::Set(kLanes, float(beams));
        if (brick.furnace) {
            const Vec taken = hn::IfThenElseZero(hn::Gt(raysMet, zero), hn::Load(kLanes, exchanged.furnace + i));
            hn::Store(hn::Add(hn::Load(kLanes, brick.furnace + i), taken), kLanes, brick.furnace + i);
        }
        for (int c = 0; c < kChannels; ++c) {
            const Vec in = hn::Load(kLanes, exchanged.in[c] + i), out = hn::Load(kLanes, exchanged.out[c] + i);
            const Vec source = hn::Load(kLanes, brick.source[c] + i);
            if (hn::AllTrue(kLanes, hn::Eq(hn::Or(hn::Or(in, out), source), zero))) continue;
            Vec inverse = hn::Load(kLanes, exchanged.inverseEscape + i);
            if (brick.normals) inverse = withoutEscape(brick.normals + i, inverse);
            const Vec g = effectiveAlbedo(inverse, hn::Load(kLanes, brick.albedo[c] + i));
            const Vec left = hn::Sub(hn::Load(kLanes, brick.unshot[c] + i), out);
            requireNonNegative(left);
            hn::Store(hn::MulAdd(source, raysMet, hn::MulAdd(g, in, left)), kLanes, brick.unshot[c] + i);
            hn::Store(hn::Add(hn::Load(kLanes, brick.deposit[c] + i), in), kLanes, brick.deposit[c] + i);
        }
    }
}

/// Makes a brick ready for beams.
template <int kChannels>
HWY_INLINE void begin(const Swept& swept, const ExchangeFields& fields, const BrickVisit& visit,
                      VisitedBrick<kChannels>& visited) {
    const RayFront& front = swept.beams.front();
    visited.visit = visit;
    visited.brick = Brick<kChannels>(fields, visit.brick);
    visited.thickest = findEscape(swept.constants, visited.brick.tau, visited.exchanged.inverseEscape);
    visited.view = viewSlices(front.axis, visited.brick, visited.exchanged);
    const BrickClip clips(swept.beams.along.front(), visit);
    visited.whole = clips.whole;
    if (!clips.whole) clipSlices(front, clips, visited.view, visited.exchanged);
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

/// Brings a brick up to date that all beams have passed.
template <int kChannels>
HWY_INLINE void end(const Swept& swept, VisitedBrick<kChannels>& visited) {
    Exchanged<kChannels>& exchanged = visited.exchanged;
    if (swept.beams.front().axis.transposed) {
        turn(exchanged.inverseEscape);
        for (int c = 0; c < kChannels; ++c) {
            turn(exchanged.in[c]);
            turn(exchanged.out[c]);
        }
        if (visited.brick.furnace) turn(exchanged.furnace);
        if (!visited.whole) turn(exchanged.raysMet);
    }
    bookExchange<kChannels>(visited.brick, int(swept.beams.count()), !visited.whole, exchanged);
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
