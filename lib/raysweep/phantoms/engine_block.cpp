#include "raysweep/phantoms/engine_block.h"

#include "raysweep/phantoms/leaf_fill.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

EnginePart box(const Vec3& low, const Vec3& high, float value) {
    EnginePart part;
    part.low = low;
    part.high = high;
    part.value = value;
    return part;
}

/// From `begin` to `end` along `axis`.
EnginePart bar(int axis, Vec3 centre, double begin, double end, double radius, float value) {
    EnginePart part;
    part.axis = axis;
    part.low[axis] = begin;
    part.high[axis] = end;
    part.centre = centre;
    part.radius = radius;
    part.value = value;
    return part;
}

/// Length that the voxel of index `i` has between `low` and `high`.
double overlap(double i, double low, double high) {
    return std::max(0.0, std::min(i + 1, high) - std::max(i, low));
}

/// Part of voxel `v` that `part`, now in voxels, fills.
double coverage(const EnginePart& part, const Vec3& v) {
    double covered = 1;
    for (int axis = 0; axis < 3; ++axis)
        if (part.axis == -1 || part.axis == axis) covered *= overlap(v[axis], part.low[axis], part.high[axis]);
    if (part.axis == -1 || covered == 0) return covered;
    Vec3 out = v + Vec3(0.5) - part.centre;
    out[part.axis] = 0;
    return covered * std::clamp(part.radius - out.length() + 0.5, 0.0, 1.0);
}

/// False if no voxel within kLeafRadius of `centre` can touch the part.
bool isNear(const EnginePart& part, const Vec3& centre) {
    for (int axis = 0; axis < 3; ++axis) {
        const bool across = part.axis != -1 && part.axis != axis;
        const double low = across ? part.centre[axis] - part.radius - 1 : part.low[axis];
        const double high = across ? part.centre[axis] + part.radius + 1 : part.high[axis];
        if (centre[axis] + kLeafRadius + 1 < low || centre[axis] - kLeafRadius > high) return false;
    }
    return true;
}

}  // namespace

std::vector<EnginePart> engineParts() {
    constexpr float kCast = 0.55f, kFlange = 0.7f, kPipe = 0.8f, kLiner = 1;
    std::vector<EnginePart> parts = {
        box(Vec3(0.20, 0.10, 0), Vec3(0.80, 0.90, 0.72), kCast),       // block
        box(Vec3(0.16, 0.08, 0.72), Vec3(0.84, 0.92, 0.80), kFlange),  // flange
        box(Vec3(0.62, 0.18, 0.22), Vec3(0.80, 0.82, 0.60), 0),        // recess in the right side
        bar(1, Vec3(0.40, 0, 0), 0.10, 0.90, 0.09, 0),                 // tunnel of the crankshaft
        bar(1, Vec3(0.62, 0, 0.36), 0.03, 0.10, 0.10, kPipe),          // pulley on the front
        bar(1, Vec3(0.62, 0, 0.36), 0.03, 0.10, 0.03, 0)};             // and its hole
    for (const double y : {0.34, 0.50, 0.66})                          // ribs in the recess
        parts.push_back(box(Vec3(0.62, y - 0.015, 0.22), Vec3(0.80, y + 0.015, 0.60), kCast));
    for (const double y : {0.20, 0.40, 0.60, 0.80}) {
        const Vec3 bore(0.40, y, 0), port(0, y, 0.50);
        parts.push_back(bar(2, bore, 0.25, 0.80, 0.080, kLiner));
        parts.push_back(bar(2, bore, 0.25, 0.80, 0.062, 0));
        parts.push_back(bar(0, port, 0.10, 0.20, 0.045, kPipe));
        parts.push_back(bar(0, port, 0.10, 0.30, 0.028, 0));
    }
    return parts;
}

openvdb::FloatGrid::Ptr makeEngineBlock(const openvdb::Coord& box) {
    std::vector<EnginePart> parts = engineParts();
    const Vec3 edges(box.x(), box.y(), box.z());
    for (EnginePart& part : parts) {
        part.low *= edges;
        part.high *= edges;
        part.centre *= edges;
        part.radius *= edges.x;
    }
    openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0.0f);
    const auto nearParts = [&](const Vec3& centre, std::vector<EnginePart>& near) {
        near.clear();
        std::copy_if(parts.begin(), parts.end(), std::back_inserter(near),
                     [&](const EnginePart& part) { return isNear(part, centre); });
        return !near.empty();
    };
    const FillRegion region{openvdb::CoordBBox(openvdb::Coord(0), box.offsetBy(-1))};
    fillLeaves<std::vector<EnginePart>>(*grid, region, nearParts,
                                        [](const Vec3& v, const std::vector<EnginePart>& near) {
                                            double density = 0;
                                            for (const EnginePart& part : near)
                                                density += (part.value - density) * coverage(part, v);
                                            return density;
                                        });
    return grid;
}

}  // namespace raysweep
