// The voxels that the rays of a brick meet in `linear`: its own, padded with the first of the bricks beyond. Included
// once per instruction set.
#if defined(RAYSWEEP_SWEEP_LINEAR_BRICK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_SWEEP_LINEAR_BRICK_INL_H
#undef RAYSWEEP_SWEEP_LINEAR_BRICK_INL_H
#else
#define RAYSWEEP_SWEEP_LINEAR_BRICK_INL_H
#endif

#include "raysweep/sweep/exchange_terms-inl.h"
#include "raysweep/sweep/transpose-inl.h"

#include <algorithm>
#include <cstring>

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
    int firstRow;  ///< first row of rays that meet anything
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
                       const ExchangeConstants& constants, LinearBrick<kChannels>& brick) {
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
    brick.firstRow = last ? kBrickEdge - 1 : 0;
    const Vec part = hn::Set(kLanes, ExchangeRule(constants).part);
    Vec most = hn::Zero(kLanes);
    for (int j = 0; j < kBrickEdge; ++j)
        for (int i = 0; i < kSlice; i += int(hn::Lanes(kLanes))) {
            const Vec tau = hn::Load(kLanes, brick.tau.value[j] + i);
            most = hn::Max(most, tau);
            hn::Store(hn::Mul(inverseEscape(constants, tau), part), kLanes, brick.shotPart.value[j] + i);
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

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
