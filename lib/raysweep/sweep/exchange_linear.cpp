// `linear`: a ray meets the 2x2 voxels around it. Dachille, Mueller and Kaufman 2000, Algorithm 1, with the corrections
// of docs/illumination.md. Compiled once per instruction set; the best one that the machine has is chosen at run time.
//
// With w the bilinear weights between ray and voxel, which sum to 1 for either, voxel v takes alpha_v sum_i w e_i, and
// ray i becomes e_i (1 - sum_v w alpha_v) + sum_v w out_v: what a ray loses is what voxels take, and a ray needs no
// other ray. A brick handles the rays whose lower voxels are its own; the upper ones may be those of the bricks beyond.
#include "raysweep/sweep/exchange.h"

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/sweep/exchange_linear.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/sweep/beam_slice-inl.h"
#include "raysweep/sweep/linear_brick-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// What the voxels of a slice do to the rays of a beam, and the rays before.
template <int kChannels>
struct LinearSlice {
    HWY_ALIGN float opacity[kSlice];
    HWY_ALIGN float out[kChannels][kSlice];
    HWY_ALIGN float taken[kSlice];  ///< opacity inside solids, for the furnace
    HWY_ALIGN float solid[kSlice];  ///< 1 where rays are inside, -1 where they leave, else 0
    // Rays lie one row and one column on: ray (row, column) at [(row + 1) * kEdge + column + 1].
    HWY_ALIGN float rays[kChannels][kSlice + kEdge];
    HWY_ALIGN float furnace[kSlice + kEdge];
    HWY_ALIGN float incoming[kSlice];  ///< what rays bring to each voxel
};

/// Bilinear weights of the voxels around a ray; the same for all rays of a slice.
struct Stencil {
    float columnPart, rowPart;  ///< of the upper voxels
    Vec column, row;

    Stencil(const RayFront& front, int k)
        : columnPart(float(front.column.position(k) - front.column.shift(k))),
          rowPart(float(front.row.position(k) - front.row.shift(k))),
          column(hn::Set(kLanes, columnPart)),
          row(hn::Set(kLanes, rowPart)) {}

    static HWY_INLINE Vec mix(Vec part, Vec lower, Vec upper) {
        return hn::MulAdd(part, upper, hn::NegMulAdd(part, lower, lower));
    }
    HWY_INLINE Vec acrossColumns(const float* at) const {
        return mix(column, hn::LoadU(kLanes, at), hn::LoadU(kLanes, at + 1));
    }
    /// Of voxels, at rays.
    HWY_INLINE Vec atRays(const float* slice, int row0, int lane) const {
        const float* const at = slice + row0 * kEdge + lane;
        return mix(row, acrossColumns(at), acrossColumns(at + kEdge));
    }
};

/// Opacity and emission of the voxels of slice `j` of a brick, for the rays of a beam.
template <int kChannels, bool kThinOnly, bool kSurfaces>
HWY_INLINE void findTerms(const ExchangeRule& rule, const Beam& beam, const LinearBrick<kChannels>& brick, int j,
                          LinearSlice<kChannels>& slice) {
    for (int i = 0; i < kSlice; i += int(hn::Lanes(kLanes))) {
        const Vec tau = hn::Load(kLanes, brick.tau.value[j] + i);
        const Vec shotPart = hn::Load(kLanes, brick.shotPart.value[j] + i);
        VoxelTerms terms = voxelTerms<kThinOnly>(rule, beam.stepScale, tau, shotPart);
        if (kSurfaces) {
            const VoxelSurfaces surfaces = voxelSurfaces(brick.normals.value[j] + i, tau);
            const VoxelSolids solids = applySurfaces(rule, beam.front.direction, surfaces, terms);
            const Vec measured = hn::Load(kLanes, brick.measured.value[j] + i);
            const Vec inside = hn::IfThenElseZero(solids.inside, measured);
            const Vec leaving = hn::IfThenElseZero(solids.leaving, measured);
            hn::Store(hn::Sub(inside, leaving), kLanes, slice.solid + i);
            hn::Store(hn::Mul(inside, terms.opacity), kLanes, slice.taken + i);
        }
        hn::Store(terms.opacity, kLanes, slice.opacity + i);
        for (int c = 0; c < kChannels; ++c)
            hn::Store(hn::Mul(terms.shot, hn::Load(kLanes, brick.unshot[c].value[j] + i)), kLanes, slice.out[c] + i);
    }
}

/// Where ray (row, lane) is remembered.
HWY_INLINE float* remembered(float* rays, int row, int lane) {
    return rays + (row + 1) * kEdge + lane + 1;
}

/// The rays of a beam that a brick handles in one of its slices.
struct HandledRays {
    BeamSlice beam;
    Clip clip;
    Stencil stencil;
    int firstRow;
    int k;  ///< number of the slice, in the order of travel
};

/// Takes rays through a slice, and remembers what they were before.
template <int kChannels, bool kClipped>
HWY_INLINE void stepRays(const HandledRays& rays, LinearSlice<kChannels>& slice) {
    const BeamSlice& beam = rays.beam;
    const Clip& clip = rays.clip;
    const Stencil& stencil = rays.stencil;
    for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
        const int start = rays.firstRow * kEdge + lane;
        Vec opacity = stencil.acrossColumns(slice.opacity + start), out[kChannels];
        for (int c = 0; c < kChannels; ++c) out[c] = stencil.acrossColumns(slice.out[c] + start);
        for (int r = rays.firstRow; r < kBrickEdge; ++r) {
            const int above = (r + 1) * kEdge + lane;
            const Vec opacityAbove = stencil.acrossColumns(slice.opacity + above);
            const Vec lost = Stencil::mix(stencil.row, opacity, opacityAbove);
            opacity = opacityAbove;
            for (int c = 0; c < kChannels; ++c) {
                const Vec outAbove = stencil.acrossColumns(slice.out[c] + above);
                const Vec given = Stencil::mix(stencil.row, out[c], outAbove);
                out[c] = outAbove;
                float* const to = remembered(slice.rays[c], r, lane);
                if (kClipped && clip.missesRow(r)) {
                    hn::StoreU(hn::Zero(kLanes), kLanes, to);
                    continue;
                }
                float* const power = beam.power + c * beam.planeStride + beam.rowStart[r] + lane;
                const Vec e = hn::LoadU(kLanes, power);
                // Weights that sum to 1 but for rounding can leave a dark ray at -1e-8 of what it carried.
                Vec after = hn::Max(hn::Add(hn::NegMulAdd(e, lost, e), given), hn::Zero(kLanes));
                Vec before = e;
                if (kClipped) {
                    const auto lanes = clip.lanes(lane);
                    before = hn::IfThenElseZero(lanes, before);
                    after = hn::IfThenElse(lanes, after, e);
                }
                hn::StoreU(before, kLanes, to);
                hn::StoreU(after, kLanes, power);
            }
        }
    }
}

/// The same for the local furnace.
template <int kChannels>
HWY_NOINLINE void stepFurnace(const HandledRays& rays, LinearSlice<kChannels>& slice) {
    const BeamSlice& beam = rays.beam;
    const Clip& clip = rays.clip;
    const Stencil& stencil = rays.stencil;
    const Vec zero = hn::Zero(kLanes);
    for (int r = rays.firstRow; r < kBrickEdge; ++r)
        for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
            float* const to = remembered(slice.furnace, r, lane);
            if (clip.missesRow(r)) {
                hn::StoreU(zero, kLanes, to);
                continue;
            }
            const std::ptrdiff_t ray = beam.rowStart[r] + lane;
            const Vec f = hn::LoadU(kLanes, beam.furnace + ray), last = hn::LoadU(kLanes, beam.lastSlice + ray);
            const auto close = hn::Ge(last, hn::Set(kLanes, float(rays.k - kSurfaceGap)));
            Vec before = hn::IfThenElse(close, f, hn::Set(kLanes, beam.beam->furnaceRay));
            Vec after = hn::Max(zero, hn::NegMulAdd(before, stencil.atRays(slice.taken, r, lane), before));
            const Vec inside = stencil.atRays(slice.solid, r, lane);
            Vec lastNow = hn::IfThenElse(hn::Lt(inside, zero), hn::Set(kLanes, kLongAgo), last);
            lastNow = hn::IfThenElse(hn::Gt(inside, zero), hn::Set(kLanes, float(rays.k)), lastNow);
            const auto lanes = clip.lanes(lane);
            before = hn::IfThenElseZero(lanes, before);
            after = hn::IfThenElse(lanes, after, f);
            lastNow = hn::IfThenElse(lanes, lastNow, last);
            hn::StoreU(before, kLanes, to);
            hn::StoreU(after, kLanes, beam.furnace + ray);
            hn::StoreU(lastNow, kLanes, beam.lastSlice + ray);
        }
}

/// Adds what the voxels of a slice take of the rays around them.
/// @param rays as remembered  @param incoming room for what rays bring to each voxel
HWY_INLINE void takeFromRays(const Stencil& stencil, const float* opacity, const float* rays, float* incoming,
                             float* in) {
    for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
        const auto fromColumns = [&](int row) {
            const float* const at = rays + row * kEdge + lane;
            return Stencil::mix(stencil.column, hn::LoadU(kLanes, at + 1), hn::LoadU(kLanes, at));
        };
        Vec before = fromColumns(0);
        for (int r = 0; r < kEdge; ++r) {
            const Vec here = fromColumns(r + 1);
            hn::StoreU(Stencil::mix(stencil.row, here, before), kLanes, incoming + r * kEdge + lane);
            before = here;
        }
    }
    // The column beyond meets the last ray of each row.
    for (int r = 0; r < kEdge; ++r) {
        const float before = rays[r * kEdge + kBrickEdge], here = rays[(r + 1) * kEdge + kBrickEdge];
        incoming[r * kEdge + kBrickEdge] = stencil.columnPart * (here + stencil.rowPart * (before - here));
    }
    for (int i = 0; i < kSlice; i += int(hn::Lanes(kLanes))) {
        const Vec taken = hn::Mul(hn::Load(kLanes, opacity + i), hn::Load(kLanes, incoming + i));
        hn::Store(hn::Add(hn::Load(kLanes, in + i), taken), kLanes, in + i);
    }
}

/// `stepRays` where a brick hangs over the lattice, which is rare.
template <int kChannels>
HWY_NOINLINE void stepClippedRays(const HandledRays& rays, LinearSlice<kChannels>& slice) {
    stepRays<kChannels, true>(rays, slice);
}

template <int kChannels, bool kThinOnly, bool kSurfaces>
HWY_NOINLINE void exchangeSlices(const std::vector<SweptBeam>& beams, const BrickVisit& visit,
                                 const ExchangeConstants& constants, LinearBrick<kChannels>& brick,
                                 LinearSlice<kChannels>& slice) {
    const RayFront& front = beams.front().beam->front;
    const ExchangeRule rule(constants);
    clear(slice);
    for (int j = 0; j < kBrickEdge; ++j) {
        const int k = visit.slice + j, at = front.ascending ? j : kBrickEdge - 1 - j;
        const Clip clip = clipToLattice(beams.front(), visit, k);
        if (clip.empty()) continue;
        for (const SweptBeam& swept : beams) {
            const Beam& beam = *swept.beam;
            const HandledRays rays{beamSlice(swept, visit, k, kSurfaces && brick.furnace), clip, Stencil(beam.front, k),
                                   brick.firstRow, k};
            findTerms<kChannels, kThinOnly, kSurfaces>(rule, beam, brick, at, slice);
            if (clip.whole())
                stepRays<kChannels, false>(rays, slice);
            else
                stepClippedRays(rays, slice);
            for (int c = 0; c < kChannels; ++c)
                takeFromRays(rays.stencil, slice.opacity, slice.rays[c], slice.incoming, brick.in[c].value[at]);
            if (!kSurfaces || !brick.furnace) continue;
            stepFurnace(rays, slice);
            takeFromRays(rays.stencil, slice.taken, slice.furnace, slice.incoming, brick.furnaceIn.value[at]);
        }
    }
}

template <int kChannels>
void exchangeVisits(const SweptBeams& swept, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                    const ExchangeConstants& constants) {
    LinearBrick<kChannels> brick;
    LinearSlice<kChannels> slice;
    const float mostScale = swept.mostStepScale();
    const SweepAxis& axis = swept.front().axis;
    const auto pass = [&](const std::vector<SweptBeam>& beams, const BrickVisit& visit) {
        const Quartet quartet(visit);
        fill(axis, quartet, fields, constants, brick);
        if (brick.surfaces)
            exchangeSlices<kChannels, false, true>(beams, visit, constants, brick, slice);
        else if (brick.thickest * mostScale <= kThin)
            exchangeSlices<kChannels, true, false>(beams, visit, constants, brick, slice);
        else
            exchangeSlices<kChannels, false, false>(beams, visit, constants, brick, slice);
        addTaken(axis, quartet, brick, fields);
    };
    for (std::size_t first = 0, end = 0; first < visits.size(); first = end) {
        end = endOfRow(visits, first);
        for (std::size_t i = first; i < end; ++i) pass(swept.along, visits[i]);
        if (swept.against.empty()) continue;
        for (std::size_t i = end; i-- > first;) pass(swept.against, visits[i]);
    }
}

}  // namespace

void linearDispatched(const SweptBeams& swept, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                      const ExchangeConstants& constants) {
    fields.channels == 1 ? exchangeVisits<1>(swept, visits, fields, constants)
                         : exchangeVisits<3>(swept, visits, fields, constants);
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(linearDispatched);

void exchangeLinear(const SweptBeams& beams, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                    const ExchangeConstants& constants) {
    HWY_DYNAMIC_DISPATCH(linearDispatched)(beams, visits, fields, constants);
}

}  // namespace raysweep
#endif  // HWY_ONCE
