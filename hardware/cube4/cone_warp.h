/// The warp between a cone's pixels and the lattice of the machine's rays: bilinear, and its adjoint.
#pragma once

#include "cube4/perspective.h"

#include <array>
#include <cmath>

namespace raysweep::cube4 {

/// The four rays of a lattice between which a pixel's ray is, and their parts; all 0 if one of them is missing.
struct LatticePoint {
    std::array<std::size_t, 4> at{};
    std::array<double, 4> part{};

    /// @param ray lattice coordinates
    template <class Word>
    LatticePoint(const RayPlane<Word>& plane, const Imath::V2d& ray) {
        const double left = std::floor(ray.x), below = std::floor(ray.y), x = ray.x - left, y = ray.y - below;
        for (std::size_t i = 0; i < 4; ++i) {
            const double weight = (i & 1 ? x : 1 - x) * (i & 2 ? y : 1 - y);
            if (!(weight > 0)) continue;
            const int u = int(left) + int(i & 1) - plane.lowU, v = int(below) + int(i >> 1) - plane.lowV;
            if (u < 0 || u >= plane.width || v < 0 || v >= plane.height) {
                part = {};
                return;
            }
            at[i] = std::size_t(v) * std::size_t(plane.width) + std::size_t(u);
            part[i] = weight;
        }
    }

    bool isOutside() const { return part == std::array<double, 4>{}; }

    /// @param wordOf a number of a ray
    template <class Rays, class WordOf>
    double interpolated(const Rays& rays, const WordOf& wordOf) const {
        double sum = 0;
        for (std::size_t i = 0; i < at.size(); ++i) sum += part[i] * double(wordOf(rays[at[i]]));
        return sum;
    }

    void spread(double value, std::vector<double>& rays) const {
        for (std::size_t i = 0; i < at.size(); ++i) rays[at[i]] += part[i] * value;
    }
};

/// Calls `visit(pixel, ray, length)` for the pixels of a front: each one's number, row by row, the lattice coordinates
/// of its ray at the level of the last region, and that ray's world length in a slice.
template <class Visit>
void forEachPixel(const PointRays& rays, const MemoryBox& memory, const PerspectiveFront& front, const Visit& visit) {
    const PointPlane plane(rays, memory);
    for (int row = 0; row < rays.height; ++row)
        for (int column = 0; column < rays.width; ++column) {
            const Vec3 way = plane.wayOf(column, row);
            if (!front.has(way)) continue;
            visit(std::size_t(row) * std::size_t(rays.width) + std::size_t(column),
                  front.rayOf(way, front.regions.back().level), front.lengthOf(way, memory.box.worldFromIndex));
        }
}

}  // namespace raysweep::cube4
