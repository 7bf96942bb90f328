#include "raysweep/sweep/ray_front.h"

#include "raysweep/core/finite.h"

#include <algorithm>
#include <cstdlib>

namespace raysweep {
namespace {

struct SliceRange {
    int first, last;  ///< inclusive; empty if last < first
};

/// Slices in which the ray at lattice coordinate `ray` is within the volume laterally.
SliceRange slicesInside(const RayFront& front, const Lateral& lateral, int ray) {
    const auto inside = [&](int k) {
        const int voxel = ray + lateral.shift(k);
        return voxel >= lateral.low - front.reach && voxel < lateral.high;
    };
    const int last = front.slices - 1;
    if (lateral.periodic) return {0, last};
    if (lateral.slope == 0) return inside(0) ? SliceRange{0, last} : SliceRange{0, -1};
    // Bounds from the slope, a slice too wide on either side, then moved to the exact ones.
    const double a = (lateral.low - front.reach - ray - lateral.offset) / lateral.slope;
    const double b = (lateral.high - ray - lateral.offset) / lateral.slope;
    const auto clampSlice = [&](double k) { return int(std::clamp(k, -1.0, double(last) + 1)); };
    int first = std::max(0, clampSlice(std::floor(std::min(a, b)) - 1));
    int end = std::min(last, clampSlice(std::ceil(std::max(a, b)) + 1));
    while (first <= end && !inside(first)) ++first;
    while (end >= first && !inside(end)) --end;
    return {first, end};
}

}  // namespace

RayFront parallelFront(const BrickLayout& layout, const Vec3& direction, int reach, const LatticeOffset& offset,
                       const Periodic& periodic) {
    RayFront front;
    front.direction = unitVector(direction);
    const Vec3 inIndex = front.direction * layout.worldFromIndex.inverse();
    front.axis = sweepAxis(majorAxis(inIndex));
    front.directionClass = directionClass(inIndex);
    const int major = front.axis.major;
    const double perSlice = std::abs(inIndex[major]);
    front.ascending = inIndex[major] > 0;
    front.firstSlice = front.ascending ? layout.low[major] : layout.high[major] - 1;
    front.slices = layout.high[major] - layout.low[major];
    const auto lateral = [&](int axis, double at) {
        return Lateral{inIndex[axis] / perSlice, at, layout.low[axis], layout.high[axis], periodic[std::size_t(axis)]};
    };
    front.column = lateral(front.axis.column, offset.column);
    front.row = lateral(front.axis.row, offset.row);
    front.stepLength = 1 / perSlice;
    front.crossSection = layout.voxelVolume * perSlice;
    front.reach = reach;
    front.periodic = periodic[std::size_t(major)];
    return front;
}

RayRange rayExtent(const RayFront& front, const Lateral& lateral) {
    if (lateral.periodic) return {lateral.low, lateral.high};
    const auto [least, most] = std::minmax({lateral.shift(0), lateral.shift(front.slices - 1)});
    return {lateral.low - front.reach - most, lateral.high - least};
}

RayRange raysInside(const RayFront& front, const Lateral& lateral, int k) {
    if (lateral.periodic) return {lateral.low, lateral.high};
    return {lateral.low - front.reach - lateral.shift(k), lateral.high - lateral.shift(k)};
}

RayRange raysThatEnter(const RayFront& front, int row) {
    const SliceRange slices = slicesInside(front, front.row, row);
    if (slices.last < slices.first) return {};
    if (front.column.periodic) return {front.column.low, front.column.high};
    const auto [least, most] = std::minmax({front.column.shift(slices.first), front.column.shift(slices.last)});
    return {front.column.low - front.reach - most, front.column.high - least};
}

double countRaysThatEnter(const RayFront& front) {
    const double columns = front.column.size() + (front.column.periodic ? 0 : front.reach);
    const double rows = front.row.size() + (front.row.periodic ? 0 : front.reach);
    double count = front.periodic ? 0 : columns * rows;
    for (int k = front.periodic ? 0 : 1; k < front.slices; ++k) {
        const int du = front.column.periodic ? 0 : std::abs(front.column.shift(k) - front.column.shift(k - 1));
        const int dv = front.row.periodic ? 0 : std::abs(front.row.shift(k) - front.row.shift(k - 1));
        count += du * rows + dv * columns - du * dv;
    }
    return count;
}

CrossingRays::CrossingRays(const RayFront& front, int channelCount, bool withFurnace) : channels(channelCount) {
    const auto face = [&](const Lateral& lateral) {
        return RayRange{lateral.low - (lateral.periodic ? 0 : front.reach), lateral.high};
    };
    columns = face(front.column);
    rows = face(front.row);
    const std::size_t rays = std::size_t(rows.size()) * std::size_t(columns.size());
    power.assign(std::size_t(channels) * rays, 0.0f);
    if (!withFurnace) return;
    furnace.assign(rays, 0.0f);
    slice.assign(rays, 0.0f);
}

RayFront nextRepetition(const RayFront& front) {
    RayFront next = front;
    for (Lateral* lateral : {&next.column, &next.row}) {
        const double position = lateral->position(front.slices);
        lateral->offset = std::min(position - std::floor(position), 1 - 0x1.0p-53);
    }
    return next;
}

int rayInNextRepetition(const RayFront& front, const Lateral& lateral, int ray) {
    const int there = ray + lateral.shift(front.slices);
    if (!lateral.periodic) return there;
    const int period = lateral.size(), past = (there - lateral.low) % period;
    return lateral.low + (past < 0 ? past + period : past);
}

}  // namespace raysweep
