#include "raysweep/reconstruct/elliptic_body.h"

#include "raysweep/core/normal_equations.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raysweep {
namespace {

using Equations = NormalEquations<6>;

/// xx, yx, yy, centerX, centerY, extinction
constexpr double EllipticBody::*kUnknowns[] = {&EllipticBody::xx,      &EllipticBody::yx,
                                               &EllipticBody::yy,      &EllipticBody::centerX,
                                               &EllipticBody::centerY, &EllipticBody::extinction};

/// The line integral and its derivatives by the unknowns.
struct Slopes {
    double value = 0;
    Equations::Vector by{};
};

Slopes slopesOf(const EllipticBody& body, const PlaneLine& line) {
    const double nx = line.normalX, ny = line.normalY;
    const double p = body.xx * nx + body.yx * ny, q = body.yy * ny, w = p * p + q * q;
    const double d = line.distance - nx * body.centerX - ny * body.centerY;
    if (!(d * d < w)) return {};
    // At the rim the slope is infinite: no line is there for more than a thousandth of the width.
    const double h = std::max(std::sqrt(w - d * d), 1e-3 * std::sqrt(w));
    const double area = body.xx * body.yy, twice = 2 * body.extinction;
    const double byW = twice * area * (0.5 / (h * w) - h / (w * w)), byD = -twice * area * d / (h * w);
    Slopes slopes;
    slopes.value = twice * area * h / w;
    slopes.by = {byW * 2 * p * nx + twice * body.yy * h / w,
                 byW * 2 * p * ny,
                 byW * 2 * q * ny + twice * body.xx * h / w,
                 -byD * nx,
                 -byD * ny,
                 2 * area * h / w};
    return slopes;
}

double costOf(const EllipticBody& body, const std::vector<PlaneLine>& lines, double scale) {
    double cost = 0;
    for (const PlaneLine& line : lines) {
        const double r = (line.value - body.lineIntegral(line.normalX, line.normalY, line.distance)) / scale;
        cost += std::log1p(r * r);
    }
    return cost;
}

EllipticBody bounded(EllipticBody body, double field) {
    const double least = 0.25 * field, most = 4 * field;
    body.xx = std::clamp(body.xx, least, most);
    body.yy = std::clamp(body.yy, least, most);
    body.yx = std::clamp(body.yx, -most, most);
    body.centerX = std::clamp(body.centerX, -most, most);
    body.centerY = std::clamp(body.centerY, -most, most);
    body.extinction = std::max(body.extinction, 0.0);
    return body;
}

/// Improves `body` until nothing is gained. @return its cost
double improve(EllipticBody& body, const std::vector<PlaneLine>& lines, double scale, double field) {
    constexpr int kMostSteps = 60;
    constexpr double kNoGain = 1e-6;
    double cost = costOf(body, lines, scale), damping = 1e-3;
    for (int step = 0; step < kMostSteps && damping < 1e8; ++step) {
        Equations equations;
        for (const PlaneLine& line : lines) {
            const Slopes slopes = slopesOf(body, line);
            const double residual = line.value - slopes.value, r = residual / scale;
            equations.add(slopes.by, residual, 1 / (1 + r * r));
        }
        double gain = 0;
        while (damping < 1e8) {
            const Equations::Vector change = equations.solved(damping);
            EllipticBody next = body;
            for (std::size_t k = 0; k < change.size(); ++k) next.*kUnknowns[k] += change[k];
            next = bounded(next, field);
            const double nextCost = costOf(next, lines, scale);
            if (nextCost < cost) {
                gain = cost - nextCost;
                body = next;
                cost = nextCost;
                damping = std::max(1e-9, 0.1 * damping);
                break;
            }
            damping *= 10;
        }
        if (gain < kNoGain * cost) break;
    }
    return cost;
}

/// A circle about the origin: p² = 4 μ² (R² - s²) is a straight line in s².
EllipticBody circleOf(const std::vector<PlaneLine>& lines, double field) {
    NormalEquations<2> equations;
    for (const PlaneLine& line : lines)
        equations.add({1, -line.distance * line.distance}, std::max(line.value, 0.0) * line.value, 1);
    const auto [constant, slope] = equations.solved(0);
    double radius = slope > 0 && constant > 0 ? std::sqrt(constant / slope) : 1.5 * field;
    radius = std::clamp(radius, 0.8 * field, 3 * field);
    EllipticBody circle;
    circle.xx = circle.yy = radius;
    circle.extinction = std::sqrt(std::max(constant, 0.0)) / (2 * radius);
    return circle;
}

}  // namespace

double EllipticBody::lineIntegral(double normalX, double normalY, double distance) const {
    const double p = xx * normalX + yx * normalY, q = yy * normalY, w = p * p + q * q;
    const double d = distance - normalX * centerX - normalY * centerY;
    return d * d < w ? 2 * extinction * xx * yy * std::sqrt(w - d * d) / w : 0;
}

bool EllipticBody::contains(double x, double y) const {
    const double a = (x - centerX) / xx, b = (y - centerY - yx * a) / yy;
    return a * a + b * b <= 1;
}

double EllipticBody::reach() const {
    // The larger singular value of L.
    const double half = 0.5 * (xx * xx + yx * yx + yy * yy), area = xx * yy;
    return std::hypot(centerX, centerY) + std::sqrt(half + std::sqrt(std::max(0.0, half * half - area * area)));
}

EllipticBody EllipticBody::between(const EllipticBody& a, const EllipticBody& b, double part) {
    EllipticBody body;
    for (const auto unknown : kUnknowns) body.*unknown = a.*unknown + part * (b.*unknown - a.*unknown);
    return body;
}

EllipticBody fitEllipticBody(const std::vector<PlaneLine>& lines, double field) {
    constexpr double kCoarse = 0.1, kFine = 0.01;  // scales, of the largest line integral
    constexpr double kDrawnOut = 1.2;
    double largest = 0;
    for (const PlaneLine& line : lines) largest = std::max(largest, line.value);
    EllipticBody best;
    if (!(largest > 0)) return best;
    const EllipticBody circle = circleOf(lines, field);
    double least = std::numeric_limits<double>::infinity();
    for (int way = 0; way < 4; ++way) {
        // Along 0, 45, 90 and 135 degrees: L of a matrix with these main axes.
        const double c = std::cos(way * 0.7853981633974483), s = std::sin(way * 0.7853981633974483);
        const double a = kDrawnOut * circle.xx, b = circle.xx / kDrawnOut;
        EllipticBody body = circle;
        const double qxx = a * a * c * c + b * b * s * s, qyx = (a * a - b * b) * c * s;
        body.xx = std::sqrt(qxx);
        body.yx = qyx / body.xx;
        body.yy = a * b / body.xx;
        improve(body, lines, kCoarse * largest, field);
        const double cost = improve(body, lines, kFine * largest, field);
        if (cost < least) least = cost, best = body;
    }
    return best;
}

}  // namespace raysweep
