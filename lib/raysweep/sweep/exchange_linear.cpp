// `linear`: a ray meets the 2x2 voxels around it. Dachille, Mueller and Kaufman 2000, Algorithm 1, with the corrections
// of docs/illumination.md. Compiled once per instruction set; the best one that the machine has is chosen at run time.
//
// With w the bilinear weights between ray and voxel, which sum to 1 for either, voxel v takes alpha_v sum_i w e_i, and
// ray i becomes e_i (1 - sum_v w alpha_v) + sum_v w out_v: what a ray loses is what voxels take, and a ray needs no
// other ray. A brick handles the rays whose lower voxels are its own; the upper ones may be those of the bricks beyond.
#include "raysweep/sweep/exchange.h"

#include <algorithm>
#include <cstring>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/sweep/exchange_linear.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/sweep/beam_slice-inl.h"
#include "raysweep/sweep/exchange_terms-inl.h"
#include "raysweep/sweep/transpose-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

constexpr int kEdge = kBrickEdge + 1;  ///< a brick's own rows or columns and the first one beyond
constexpr int kSlice = 88;             ///< kEdge^2 values, and some to fill the last vector

/// Values of a brick and of the first row and column of the bricks beyond: value (row, column) of a slice is at
/// [slice][row * kEdge + column].
template <class T>
struct Padded {
    HWY_ALIGN T value[kBrickEdge][kSlice];
};

/// Where voxel (slice, row, column) of a sweep axis is in a brick.
struct Strides {
    int slice, row, column;
    explicit Strides(const SweepAxis& axis)
        : slice(64 >> 3 * axis.major), row(64 >> 3 * axis.row), column(64 >> 3 * axis.column) {}
};

/// Calls `visit(j, i, at)` for value i of slice j that lies in the brick beyond the rows, the columns or both, with its
/// offset there.
template <class Visit>
HWY_INLINE void forEachBeyond(const Strides& strides, bool rows, bool columns, const Visit& visit) {
    for (int j = 0; j < kBrickEdge; ++j)
        for (int r = rows ? kBrickEdge : 0; r < (rows ? kEdge : kBrickEdge); ++r)
            for (int c = columns ? kBrickEdge : 0; c < (columns ? kEdge : kBrickEdge); ++c)
                visit(j, r * kEdge + c, j * strides.slice + (r & 7) * strides.row + (c & 7) * strides.column);
}

/// The four bricks whose voxels the rays of a visit meet.
struct Quartet {
    struct Part {
        std::uint32_t brick;
        bool rows, columns;  ///< beyond
    };
    Part parts[4];

    explicit Quartet(const BrickVisit& visit)
        : parts{{visit.brick, false, false},
                {visit.beyondRow, true, false},
                {visit.beyondColumn, false, true},
                {visit.beyondBoth, true, true}} {}
};

/// Copies the voxels of a brick's field to where they belong in the padding. @param from 512 values
template <class T>
HWY_INLINE void pad(const SweepAxis& axis, const Quartet::Part& part, const T* from, Padded<T>& to) {
    const Strides strides(axis);
    if (part.rows || part.columns)
        return forEachBeyond(strides, part.rows, part.columns,
                             [&](int j, int i, int at) { to.value[j][i] = from[at]; });
    HWY_ALIGN T turned[kBrickVoxels];
    if (axis.transposed) transposePlanes(from, turned, 0, kBrickEdge - 1);
    const T* const rows = axis.transposed ? turned : from;
    for (int j = 0; j < kBrickEdge; ++j)
        for (int r = 0; r < kBrickEdge; ++r)
            std::memcpy(to.value[j] + r * kEdge, rows + j * axis.sliceStride + r * axis.rowStride,
                        kBrickEdge * sizeof(T));
}

/// Adds the padding's values to a brick's field.
HWY_INLINE void addTo(const SweepAxis& axis, const Quartet::Part& part, const Padded<float>& from, float* to) {
    const Strides strides(axis);
    if (part.rows || part.columns)
        return forEachBeyond(strides, part.rows, part.columns,
                             [&](int j, int i, int at) { to[at] += from.value[j][i]; });
    HWY_ALIGN float rows[kBrickVoxels];
    HWY_ALIGN float turned[kBrickVoxels];
    for (int j = 0; j < kBrickEdge; ++j)
        for (int r = 0; r < kBrickEdge; ++r)
            std::memcpy(rows + j * axis.sliceStride + r * axis.rowStride, from.value[j] + r * kEdge,
                        kBrickEdge * sizeof(float));
    if (axis.transposed) transposePlanes(rows, turned, 0, kBrickEdge - 1);
    const float* const values = axis.transposed ? turned : rows;
    for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes)))
        hn::Store(hn::Add(hn::Load(kLanes, to + i), hn::Load(kLanes, values + i)), kLanes, to + i);
}

/// A visit's voxels, and what they take.
template <int kChannels>
struct LinearBrick {
    Padded<float> tau, shotPart, unshot[kChannels], in[kChannels];
    // Only where there are surfaces:
    Padded<PackedNormal> normals;
    Padded<float> measured;  ///< 1 where the furnace is measured: in bricks that have surfaces
    Padded<float> furnaceIn;
    bool surfaces, furnace;
    int firstRay;  ///< first row of rays that meet anything
    float thickest;
};

template <class T>
HWY_INLINE void clear(T& values) {
    std::memset(&values, 0, sizeof values);
}

template <int kChannels>
HWY_INLINE void fillSurfaces(const SweepAxis& axis, const Quartet& quartet, const ExchangeFields& fields,
                             LinearBrick<kChannels>& brick) {
    const auto normalsOf = [&](const Quartet::Part& part) {
        return fields.surfaces && part.brick != kNoBrick ? fields.surfaces->normals(part.brick) : nullptr;
    };
    brick.surfaces = std::any_of(quartet.parts, quartet.parts + 4, normalsOf);
    brick.furnace = brick.surfaces && fields.furnace.data;
    if (!brick.surfaces) return;
    clear(brick.normals);
    clear(brick.measured);
    clear(brick.furnaceIn);
    HWY_ALIGN float ones[kBrickVoxels];
    std::fill_n(ones, kBrickVoxels, 1.0f);
    for (const Quartet::Part& part : quartet.parts) {
        if (!normalsOf(part)) continue;
        pad(axis, part, normalsOf(part), brick.normals);
        pad(axis, part, ones, brick.measured);
    }
}

template <int kChannels>
HWY_NOINLINE void fill(const SweepAxis& axis, const Quartet& quartet, const ExchangeFields& fields,
                       const ExchangeStep& step, LinearBrick<kChannels>& brick) {
    clear(brick.tau);
    for (int c = 0; c < kChannels; ++c) {
        clear(brick.unshot[c]);
        clear(brick.in[c]);
    }
    for (const Quartet::Part& part : quartet.parts) {
        if (part.brick == kNoBrick) continue;
        pad(axis, part, fields.tau.brick(part.brick), brick.tau);
        for (int c = 0; c < kChannels; ++c) pad(axis, part, fields.unshot[c].brick(part.brick), brick.unshot[c]);
    }
    fillSurfaces(axis, quartet, fields, brick);
    const bool last = quartet.parts[0].brick == kNoBrick && quartet.parts[2].brick == kNoBrick;
    brick.firstRay = last ? kBrickEdge - 1 : 0;
    const Vec part = hn::Set(kLanes, ShotRule(step).part);
    Vec most = hn::Zero(kLanes);
    for (int j = 0; j < kBrickEdge; ++j)
        for (int i = 0; i < kSlice; i += int(hn::Lanes(kLanes))) {
            const Vec tau = hn::Load(kLanes, brick.tau.value[j] + i);
            most = hn::Max(most, tau);
            hn::Store(hn::Mul(inverseEscape(step, tau), part), kLanes, brick.shotPart.value[j] + i);
        }
    brick.thickest = hn::GetLane(hn::MaxOfLanes(kLanes, most));
}

/// Adds what a visit's voxels took to the fields of their bricks.
template <int kChannels>
void addTaken(const SweepAxis& axis, const Quartet& quartet, const LinearBrick<kChannels>& brick,
              const ExchangeFields& fields) {
    for (const Quartet::Part& part : quartet.parts) {
        if (part.brick == kNoBrick) continue;
        for (int c = 0; c < kChannels; ++c) addTo(axis, part, brick.in[c], fields.fresh[c].brick(part.brick));
        if (brick.furnace && fields.surfaces->normals(part.brick))
            addTo(axis, part, brick.furnaceIn, fields.furnace.brick(fields.surfaces->slots[part.brick]));
    }
}

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

/// Opacity and emission of the voxels of slice `j`.
template <int kChannels, bool kThinOnly, bool kSurfaces>
HWY_INLINE void findTerms(const ExchangeStep& step, const ShotRule& rule, const Beam& beam,
                          const LinearBrick<kChannels>& brick, int j, LinearSlice<kChannels>& slice) {
    for (int i = 0; i < kSlice; i += int(hn::Lanes(kLanes))) {
        const Vec tau = hn::Load(kLanes, brick.tau.value[j] + i);
        const Vec shotPart = hn::Load(kLanes, brick.shotPart.value[j] + i);
        RowTerms terms = rowTerms<kThinOnly>(rule, beam.stepScale, tau, shotPart);
        if (kSurfaces) {
            const RowSurfaces surfaces = rowSurfaces(step, brick.normals.value[j] + i, tau);
            const RowSolids solids = applySurfaces(rule, beam.front.direction, surfaces, terms);
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

/// Takes the rays of a beam through a slice, and remembers what they were before.
template <int kChannels, bool kClipped>
HWY_INLINE void stepRays(const BeamSlice& beam, const Clip& clip, const Stencil& stencil, int firstRay,
                         LinearSlice<kChannels>& slice) {
    for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
        const int start = firstRay * kEdge + lane;
        Vec opacity = stencil.acrossColumns(slice.opacity + start), out[kChannels];
        for (int c = 0; c < kChannels; ++c) out[c] = stencil.acrossColumns(slice.out[c] + start);
        for (int r = firstRay; r < kBrickEdge; ++r) {
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
HWY_NOINLINE void stepFurnace(const BeamSlice& beam, const Clip& clip, const Stencil& stencil, int firstRay, int k,
                              LinearSlice<kChannels>& slice) {
    const Vec zero = hn::Zero(kLanes);
    for (int r = firstRay; r < kBrickEdge; ++r)
        for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
            float* const to = remembered(slice.furnace, r, lane);
            if (clip.missesRow(r)) {
                hn::StoreU(zero, kLanes, to);
                continue;
            }
            const std::ptrdiff_t ray = beam.rowStart[r] + lane;
            const Vec f = hn::LoadU(kLanes, beam.furnace + ray), last = hn::LoadU(kLanes, beam.lastSlice + ray);
            const auto close = hn::Ge(last, hn::Set(kLanes, float(k - kSurfaceGap)));
            Vec before = hn::IfThenElse(close, f, hn::Set(kLanes, beam.beam->furnaceRay));
            Vec after = hn::Max(zero, hn::NegMulAdd(before, stencil.atRays(slice.taken, r, lane), before));
            const Vec inside = stencil.atRays(slice.solid, r, lane);
            Vec lastNow = hn::IfThenElse(hn::Lt(inside, zero), hn::Set(kLanes, kLongAgo), last);
            lastNow = hn::IfThenElse(hn::Gt(inside, zero), hn::Set(kLanes, float(k)), lastNow);
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
HWY_NOINLINE void stepClippedRays(const BeamSlice& beam, const Clip& clip, const Stencil& stencil, int firstRay,
                                  LinearSlice<kChannels>& slice) {
    stepRays<kChannels, true>(beam, clip, stencil, firstRay, slice);
}

template <int kChannels, bool kThinOnly, bool kSurfaces>
HWY_NOINLINE void exchangeSlices(const SweptBeams& swept, const BrickVisit& visit, const ExchangeStep& step,
                                 LinearBrick<kChannels>& brick, LinearSlice<kChannels>& slice) {
    const RayFront& front = swept.beams[0].front;
    const ShotRule rule(step);
    clear(slice);
    for (int j = 0; j < kBrickEdge; ++j) {
        const int k = visit.step + j, at = front.ascending ? j : kBrickEdge - 1 - j;
        const Clip clip = clipToLattice(front, swept.rays[0], visit, k);
        if (clip.empty()) continue;
        for (std::size_t b = 0; b < swept.count(); ++b) {
            const Beam& beam = swept.beams[b];
            const BeamSlice rays = beamSlice(beam, swept.rays[b], visit, k, kSurfaces && brick.furnace);
            const Stencil stencil(beam.front, k);
            findTerms<kChannels, kThinOnly, kSurfaces>(step, rule, beam, brick, at, slice);
            if (clip.whole())
                stepRays<kChannels, false>(rays, clip, stencil, brick.firstRay, slice);
            else
                stepClippedRays(rays, clip, stencil, brick.firstRay, slice);
            for (int c = 0; c < kChannels; ++c)
                takeFromRays(stencil, slice.opacity, slice.rays[c], slice.incoming, brick.in[c].value[at]);
            if (!kSurfaces || !brick.furnace) continue;
            stepFurnace(rays, clip, stencil, brick.firstRay, k, slice);
            takeFromRays(stencil, slice.taken, slice.furnace, slice.incoming, brick.furnaceIn.value[at]);
        }
    }
}

template <int kChannels>
void exchangeVisits(const SweptBeams& swept, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                    const ExchangeStep& step) {
    LinearBrick<kChannels> brick;
    LinearSlice<kChannels> slice;
    const float mostScale = mostStepScale(swept);
    const SweepAxis& axis = swept.beams[0].front.axis;
    for (const BrickVisit& visit : visits) {
        const Quartet quartet(visit);
        fill(axis, quartet, fields, step, brick);
        if (brick.surfaces)
            exchangeSlices<kChannels, false, true>(swept, visit, step, brick, slice);
        else if (brick.thickest * mostScale <= kThin)
            exchangeSlices<kChannels, true, false>(swept, visit, step, brick, slice);
        else
            exchangeSlices<kChannels, false, false>(swept, visit, step, brick, slice);
        addTaken(axis, quartet, brick, fields);
    }
}

}  // namespace

void linearDispatched(const SweptBeams& swept, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                      const ExchangeStep& step) {
    fields.channels == 1 ? exchangeVisits<1>(swept, visits, fields, step)
                         : exchangeVisits<3>(swept, visits, fields, step);
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(linearDispatched);

void exchangeLinear(const SweptBeams& beams, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                    const ExchangeStep& step) {
    HWY_DYNAMIC_DISPATCH(linearDispatched)(beams, visits, fields, step);
}

}  // namespace raysweep
#endif  // HWY_ONCE
