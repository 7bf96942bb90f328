#include "raysweep/volume/statistics.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/channels.h"
#include "raysweep/volume/resample.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::GridBase;
using openvdb::Vec3SGrid;

template <class Value>
struct Range {
    float min[3], max[3];
    std::uint64_t finite = 0, notFinite = 0;

    void add(const Value& v, std::uint64_t voxels) {
        for (int c = 0; c < kChannels<Value>; ++c)
            if (!std::isfinite(channel(v, c))) {
                notFinite += voxels;
                return;
            }
        for (int c = 0; c < kChannels<Value>; ++c) include(c, channel(v, c), channel(v, c));
        finite += voxels;
    }
    void include(int c, float low, float high) {
        min[c] = finite ? std::min(min[c], low) : low;
        max[c] = finite ? std::max(max[c], high) : high;
    }
    Range& operator+=(const Range& other) {
        if (other.finite)
            for (int c = 0; c < kChannels<Value>; ++c) include(c, other.min[c], other.max[c]);
        finite += other.finite;
        notFinite += other.notFinite;
        return *this;
    }
};

template <class GridT>
ValueRange rangeOf(const GridT& grid) {
    using Value = typename GridT::ValueType;
    const auto range = sumOverActive<Range<Value>>(
        grid, [](Range<Value>& sum, const Value& v, const CoordBBox& box) { sum.add(v, box.volume()); });
    ValueRange result;
    result.notFinite = range.notFinite;
    for (int c = 0; c < kChannels<Value> && range.finite; ++c) {
        result.min.push_back(range.min[c]);
        result.max.push_back(range.max[c]);
    }
    return result;
}

struct Sums {
    std::uint64_t voxels = 0;
    double squaredDifference = 0, squaredReference = 0, peak = 0;
    double max = 0;
    Coord maxAt;

    template <class Value>
    void add(const Value& a, const Value& b, const Coord& at) {
        ++voxels;
        for (int c = 0; c < kChannels<Value>; ++c) {
            const double reference = channel(b, c), difference = channel(a, c) - reference;
            squaredDifference += difference * difference;
            squaredReference += reference * reference;
            peak = std::max(peak, std::abs(reference));
            if (std::abs(difference) > max) max = std::abs(difference), maxAt = at;
        }
    }
    Sums& operator+=(const Sums& other) {
        voxels += other.voxels;
        squaredDifference += other.squaredDifference;
        squaredReference += other.squaredReference;
        peak = std::max(peak, other.peak);
        if (other.max > max) max = other.max, maxAt = other.maxAt;
        return *this;
    }
};

template <class GridT>
Sums sumsOverUnion(const GridT& a, const GridT& b) {
    const typename GridT::Ptr both = a.deepCopy();
    both->topologyUnion(b);
    both->tree().voxelizeActiveTiles();
    const auto blocks = activeBlocks(*both);
    return orderedSum<Sums>(blocks.size(), [&](std::size_t i) {
        const auto inA = a.getConstUnsafeAccessor(), inB = b.getConstUnsafeAccessor();
        Sums sums;
        forEachActive(blocks[i], [&](const auto&, const CoordBBox& box) {
            sums.add(inA.getValue(box.min()), inB.getValue(box.min()), box.min());
        });
        return sums;
    });
}

GridDifference differenceFrom(const Sums& sums, int channels) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    GridDifference d;
    d.voxels = sums.voxels;
    const double values = double(sums.voxels) * channels;
    d.rmse = std::sqrt(sums.squaredDifference / values);
    const double reference = std::sqrt(sums.squaredReference / values);
    if (std::isnan(d.rmse) || std::isinf(d.rmse)) {
        d.rmse = d.relativeRmse = d.psnr = d.max = std::numeric_limits<double>::quiet_NaN();
        return d;
    }
    d.relativeRmse = d.rmse == 0 ? 0 : reference > 0 ? d.rmse / reference : kInfinity;
    d.psnr = d.rmse == 0 ? kInfinity : 20 * std::log10(sums.peak / d.rmse);
    d.max = sums.max;
    d.maxAt = sums.maxAt;
    return d;
}

/// By index: the voxels coincide, the types are equal.
GridDifference compareVoxels(const GridBase& grid, const GridBase& reference) {
    return withTypedGrid(grid, [&](const auto& typed) {
        using GridType = std::decay_t<decltype(typed)>;
        const Sums sums = sumsOverUnion(typed, static_cast<const GridType&>(reference));
        if (sums.voxels == 0) throw InvalidArgument("cannot compare grids without any active voxel");
        return differenceFrom(sums, kChannels<typename GridType::ValueType>);
    });
}

}  // namespace

bool hasKnownValues(const GridBase& grid) {
    return grid.isType<FloatGrid>() || grid.isType<Vec3SGrid>();
}

ValueRange valueRange(const GridBase& grid) {
    if (grid.isType<FloatGrid>()) return rangeOf(static_cast<const FloatGrid&>(grid));
    if (grid.isType<Vec3SGrid>()) return rangeOf(static_cast<const Vec3SGrid&>(grid));
    throw InvalidArgument("the grid '" + grid.getName() + "' has the type " + grid.valueType() +
                          ", but float or vec3s is needed");
}

Vec3 middleOf(const FloatGrid& grid) {
    const auto box = grid.evalActiveVoxelBoundingBox();
    const openvdb::Vec3d middle = grid.indexToWorld(0.5 * (box.min().asVec3d() + box.max().asVec3d()));
    return Vec3(middle.x(), middle.y(), middle.z());
}

GridDifference compareGrids(const GridBase& grid, const GridBase& reference) {
    if (!hasKnownValues(grid) || grid.type() != reference.type())
        throw InvalidArgument("cannot compare grids of type " + grid.valueType() + " and " + reference.valueType() +
                              "; both must be float, or both vec3s");
    if (grid.transform() == reference.transform()) return compareVoxels(grid, reference);
    const bool referenceIsCoarser = reference.transform().voxelVolume() > grid.transform().voxelVolume();
    GridDifference difference = referenceIsCoarser ? compareVoxels(grid, *sampledOnto(reference, grid))
                                                   : compareVoxels(*sampledOnto(grid, reference), reference);
    difference.resampled = referenceIsCoarser ? GridDifference::Resampled::reference : GridDifference::Resampled::grid;
    return difference;
}

}  // namespace raysweep
