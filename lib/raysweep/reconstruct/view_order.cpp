#include "raysweep/reconstruct/view_order.h"

#include "raysweep/core/shuffle.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace raysweep {
namespace {

Vec3 middleRay(const ProjectionGeometry& geometry, int n) {
    const XrayView& view = geometry.views[std::size_t(n)];
    if (geometry.beam == BeamShape::parallel) return view.direction;
    return (view.pixel(0.5 * (geometry.width - 1), 0.5 * (geometry.height - 1)) - view.source).normalized();
}

/// How far each view is along the way from the first, in half turns, the whole ones taken off.
std::vector<double> halfTurns(const ProjectionGeometry& geometry) {
    std::vector<double> turns(geometry.views.size());
    double turned = 0;
    for (int n = 1; n < int(turns.size()); ++n) {
        const double cosine = middleRay(geometry, n).dot(middleRay(geometry, n - 1));
        turned += std::acos(std::clamp(cosine, -1.0, 1.0)) / kPi;
        turns[std::size_t(n)] = turned - std::floor(turned);
    }
    return turns;
}

/// Always the view nearest to a golden section further on, of those not yet taken.
std::vector<int> goldenOrder(const ProjectionGeometry& geometry) {
    const double golden = 0.5 * (std::sqrt(5.0) - 1);
    const std::vector<double> turns = halfTurns(geometry);
    std::vector<int> left(turns.size()), order;
    std::iota(left.begin(), left.end(), 0);
    for (std::size_t step = 0; step < turns.size(); ++step) {
        const double target = std::fmod(double(step) * golden, 1.0);
        const auto distance = [&](int n) {
            const double apart = std::abs(turns[std::size_t(n)] - target);
            return std::min(apart, 1 - apart);
        };
        const auto next =
            std::min_element(left.begin(), left.end(), [&](int a, int b) { return distance(a) < distance(b); });
        order.push_back(*next);
        left.erase(next);
    }
    return order;
}

}  // namespace

std::vector<int> viewOrder(const ProjectionGeometry& geometry, ViewOrder order, std::uint32_t seed, int pass) {
    if (order == ViewOrder::golden) return goldenOrder(geometry);
    std::vector<int> views(geometry.views.size());
    std::iota(views.begin(), views.end(), 0);
    if (order == ViewOrder::sequential) return views;
    std::mt19937 random(seed + 7919u * std::uint32_t(pass));
    shuffle(views, random);
    return views;
}

}  // namespace raysweep
