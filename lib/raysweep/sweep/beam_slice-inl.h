// The rays of a beam at one slice of a brick. Included once per instruction set.
#if defined(RAYSWEEP_SWEEP_BEAM_SLICE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_SWEEP_BEAM_SLICE_INL_H
#undef RAYSWEEP_SWEEP_BEAM_SLICE_INL_H
#else
#define RAYSWEEP_SWEEP_BEAM_SLICE_INL_H
#endif

#include "raysweep/sweep/exchange_terms-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// Those at row r of the brick are at `power + rowStart[r]`, the next channel's `planeStride` on.
struct BeamSlice {
    float* power;
    const std::ptrdiff_t* rowStart;
    std::ptrdiff_t planeStride;
    float* furnace;    ///< f; null if not measured
    float* lastSlice;  ///< in which a ray was in a solid
    const Beam* beam;
};

HWY_INLINE BeamSlice beamSlice(const SweptBeam& swept, const BrickVisit& visit, int k, bool furnace) {
    FrontRays& rays = *swept.rays;
    const std::ptrdiff_t column = visit.column - rays.columnShift(k);
    return {rays.power() + column,
            rays.rowStarts() + (visit.row - rays.rowShift(k)),
            std::ptrdiff_t(rays.planeStride()),
            furnace ? rays.furnace() + column : nullptr,
            furnace ? rays.lastSlice() + column : nullptr,
            swept.beam};
}

/// Part of a brick's slice that lies over the lattice.
struct Clip {
    int firstRow = 0, endRow = kBrickEdge, firstColumn = 0, endColumn = kBrickEdge;

    bool empty() const { return endRow <= firstRow || endColumn <= firstColumn; }
    bool whole() const { return firstRow == 0 && firstColumn == 0 && endRow == kBrickEdge && endColumn == kBrickEdge; }
    bool missesRow(int row) const { return row < firstRow || row >= endRow; }
    /// Columns from `lane` on that take part.
    HWY_INLINE hn::Mask<Lanes> lanes(int lane) const {
        const Vec index = hn::Iota(kLanes, float(lane));
        return hn::And(hn::Ge(index, hn::Set(kLanes, float(firstColumn))),
                       hn::Lt(index, hn::Set(kLanes, float(endColumn))));
    }
};

/// In a periodic volume a brick may hang over the end of the lattice, where it is met as another image.
inline Clip clipToLattice(const SweptBeam& swept, const BrickVisit& visit, int k) {
    const RayFront& front = swept.beam->front;
    const FrontRays& rays = *swept.rays;
    Clip clip;
    const auto clipAxis = [](const Lateral& lateral, int first, int& begin, int& end) {
        if (!lateral.periodic) return;
        begin = std::max(0, lateral.low - first);
        end = std::min(kBrickEdge, lateral.high - first);
    };
    clipAxis(front.row, visit.row - rays.rowShift(k), clip.firstRow, clip.endRow);
    clipAxis(front.column, visit.column - rays.columnShift(k), clip.firstColumn, clip.endColumn);
    return clip;
}

/// The same for all slices of a brick, in the order of travel.
struct BrickClip {
    Clip slices[kBrickEdge];
    bool whole = true;  ///< nothing is clipped

    BrickClip(const SweptBeam& swept, const BrickVisit& visit) {
        const RayFront& front = swept.beam->front;
        if (!front.column.periodic && !front.row.periodic) return;
        for (int j = 0; j < kBrickEdge; ++j) {
            slices[j] = clipToLattice(swept, visit, visit.slice + j);
            whole = whole && slices[j].whole();
        }
    }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
