#include "raysweep/reconstruct/rays_beside.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raysweep {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSees = 0.05;   ///< of the largest line integral, as where truncation.h looks for the object
constexpr double kShare = 0.01;  ///< rays that matter

/// Sums over rays that see the object.
struct RaySums {
    double all = 0, beside = 0;  ///< numbers
    double measured = 0;         ///< line integrals of those beside
    RaySums& operator+=(const RaySums& other) {
        all += other.all;
        beside += other.beside;
        measured += other.measured;
        return *this;
    }
};

/// The voxels that rays meet, those that Joseph's weights reach included; without ends along an axis that all rays are
/// at right angles to.
Box3 reachedBox(const ProjectionGeometry& geometry, const ReconstructionGrid& grid) {
    constexpr double kParallel = 1e-6;
    Box3 box = grid.box();
    box.min -= 0.5 * grid.spacing;
    box.max += 0.5 * grid.spacing;
    if (geometry.beam == BeamShape::cone) return box;
    for (int axis = 0; axis < 3; ++axis) {
        const auto isLevel = [axis](const XrayView& view) { return std::abs(view.direction[axis]) <= kParallel; };
        if (!std::all_of(geometry.views.begin(), geometry.views.end(), isLevel)) continue;
        box.min[axis] = -kInfinity;
        box.max[axis] = kInfinity;
    }
    return box;
}

/// Slab by slab; a parallel ray has no beginning.
bool meets(const Box3& box, const Vec3& from, const Vec3& along, bool begins) {
    double first = begins ? 0 : -kInfinity, last = kInfinity;
    for (int axis = 0; axis < 3; ++axis) {
        if (along[axis] == 0) {
            if (from[axis] < box.min[axis] || from[axis] > box.max[axis]) return false;
            continue;
        }
        const double a = (box.min[axis] - from[axis]) / along[axis], b = (box.max[axis] - from[axis]) / along[axis];
        first = std::max(first, std::min(a, b));
        last = std::min(last, std::max(a, b));
    }
    return first <= last;
}

}  // namespace

std::string RaysBeside::warning() const {
    return "the object is larger than the volume: " + brief(100 * share, 3) +
           " % of the rays that see it run beside the volume, and measure " + brief(100 * mean, 3) +
           " % of the largest line integral on average. Iterative methods put what lies beyond into the volume, mostly "
           "at its faces; make it larger, or use filtered backprojection, which needs no more than what is asked for";
}

std::optional<RaysBeside> findRaysBeside(const Projections& projections, const ProjectionGeometry& geometry,
                                         const ReconstructionGrid& grid) {
    constexpr std::size_t kRays = 1 << 21;
    const double largest = usualLargest(projections);
    if (!(largest > 0)) return {};
    const Box3 box = reachedBox(geometry, grid);
    const bool cone = geometry.beam == BeamShape::cone;
    const std::size_t pixels = projections.pixelsPerView(), views = geometry.views.size();
    const std::size_t step = std::max<std::size_t>(1, pixels * views / kRays);
    const RaySums sums = orderedSum<RaySums>(
        views,
        [&](std::size_t n) {
            const XrayView& view = geometry.views[n];
            RaySums sum;
            for (std::size_t i = n % step; i < pixels; i += step) {
                const double value = projections.view(int(n))[i];
                if (!(value > kSees * largest)) continue;  // nor NaN
                const Vec3 pixel =
                    view.pixel(double(i % std::size_t(geometry.width)), double(i / std::size_t(geometry.width)));
                const bool beside = cone ? !meets(box, view.source, pixel - view.source, true)
                                         : !meets(box, pixel, view.direction, false);
                sum += {1, beside ? 1.0 : 0.0, beside ? value : 0};
            }
            return sum;
        },
        1);
    if (!(sums.beside > kShare * sums.all)) return {};
    return RaysBeside{sums.beside / sums.all, sums.measured / sums.beside / largest};
}

}  // namespace raysweep
