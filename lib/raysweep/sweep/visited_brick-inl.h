// A brick on its way through a `nearest` sweep: what it holds, how its slices read it, and how it is brought up to
// date. Included once per instruction set.
#if defined(RAYSWEEP_SWEEP_VISITED_BRICK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_SWEEP_VISITED_BRICK_INL_H
#undef RAYSWEEP_SWEEP_VISITED_BRICK_INL_H
#else
#define RAYSWEEP_SWEEP_VISITED_BRICK_INL_H
#endif

#include "raysweep/sweep/beam_slice-inl.h"
#include "raysweep/sweep/exchange_terms-inl.h"
#include "raysweep/sweep/transpose-inl.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

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

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
