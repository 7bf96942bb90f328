#include "cube4/traversal.h"

#include "cube4/arithmetic.h"
#include "cube4/fixed_point.h"

#include <cmath>

namespace raysweep::cube4 {

Traversal traverse(const Index3& memory, const ContentBox& content, const Direction& direction, Resampling resampling) {
    Traversal traversal;
    traversal.major = majorAxis(direction.alongIndex);
    // As sweeps have it: of the two lateral axes u is z, except where z is the major one.
    traversal.axisU = traversal.major == 2 ? 1 : 2;
    traversal.axisV = traversal.major == 0 ? 1 : 0;
    const double along = direction.alongIndex[traversal.major], perSlice = std::abs(along);
    traversal.descending = along < 0;
    traversal.reach = resampling == Resampling::linear ? 1 : 0;
    traversal.stepLength = 1 / perSlice;
    const int axes[3] = {traversal.axisU, traversal.axisV, traversal.major};
    for (int i = 0; i < 3; ++i) {
        const bool whole = traversal.reach > 0 && i < 2;
        const int low = whole ? 0 : content.low[axes[i]], high = whole ? memory[axes[i]] : content.high[axes[i]];
        traversal.size[i] = high - low;
        traversal.origin[axes[i]] = traversal.descending ? high - 1 : low;
        if (i == 2) continue;
        // Lattice coordinates are counted from the content, whatever is around it.
        traversal.slope[std::size_t(i)] = direction.alongIndex[axes[i]] / perSlice;
        traversal.offset[std::size_t(i)] = i == 0 ? direction.offsetU : direction.offsetV;
    }
    return traversal;
}

LatticeShift latticeShift(const Traversal& traversal, int lateral, int slice) {
    const double at = traversal.offset[std::size_t(lateral)] + slice * traversal.slope[std::size_t(lateral)];
    const double whole = std::floor(at);
    // Counted downwards, the voxel below is the one above, and the way to it the rest of the way.
    if (traversal.descending) return {-int(whole), 1 - (at - whole)};
    return {int(whole), at - whole};
}

template <class Arithmetic>
std::vector<SliceSetup<typename Arithmetic::Weight>> slicesOf(const Traversal& traversal, const Arithmetic& arithmetic,
                                                              int ending) {
    const auto between = [&](double fraction) {
        Between<typename Arithmetic::Weight> weights;
        weights.high = arithmetic.weight(traversal.reach > 0 ? fraction : 0);
        weights.low = arithmetic.weight(1) - weights.high;
        return weights;
    };
    std::vector<SliceSetup<typename Arithmetic::Weight>> slices(std::size_t(traversal.size.z));
    for (int k = 0; k < traversal.size.z; ++k) {
        auto& slice = slices[std::size_t(k)];
        slice.number = k;
        slice.first = k == 0;
        slice.last = k == traversal.size.z - 1;
        const LatticeShift u = latticeShift(traversal, 0, k), v = latticeShift(traversal, 1, k);
        slice.shiftU = u.shift;
        slice.shiftV = v.shift;
        slice.u = between(u.fraction);
        slice.v = between(v.fraction);
        slice.fromU = u.shift - latticeShift(traversal, 0, k - 1).shift;
        slice.fromV = v.shift - latticeShift(traversal, 1, k - 1).shift;
        slice.toU = latticeShift(traversal, 0, k + 1).shift - u.shift;
        slice.toV = latticeShift(traversal, 1, k + 1).shift - v.shift;
        slice.slantU = latticeShift(traversal, 0, k + 1).fraction - latticeShift(traversal, 0, k - 1).fraction;
        slice.slantV = latticeShift(traversal, 1, k + 1).fraction - latticeShift(traversal, 1, k - 1).fraction;
        // Along u and v, and to the next slice; less what it has moved already.
        slice.hops = slice.toU + slice.toV + 1 - 2 * ending;
    }
    return slices;
}

template std::vector<SliceSetup<float>> slicesOf(const Traversal&, const FloatArithmetic&, int);
template std::vector<SliceSetup<FixedPoint::Weight>> slicesOf(const Traversal&, const FixedPoint&, int);

}  // namespace raysweep::cube4
