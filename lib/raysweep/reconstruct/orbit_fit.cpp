#include "raysweep/reconstruct/orbit_fit.h"

#include "raysweep/core/directions.h"
#include "raysweep/core/error.h"

#include <ImathMatrixAlgo.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace raysweep {
namespace {

constexpr double kTolerance = 0.02;  ///< of the radius, or of a direction's length 1
const char* const kInstead = "; filtered backprojection needs a turn about an axis, iterative methods do not";

/// The direction in which `vectors` reach least.
Vec3 flattestDirection(const std::vector<Vec3>& vectors) {
    Matrix3 scatter(0.0), directions;
    for (const Vec3& v : vectors)
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) scatter[a][b] += v[a] * v[b];
    Vec3 sizes;
    Imath::jacobiEigenSolver(scatter, sizes, directions);
    int order[3] = {0, 1, 2};
    std::sort(order, order + 3, [&](int a, int b) { return std::abs(sizes[a]) < std::abs(sizes[b]); });
    if (!(std::abs(sizes[order[1]]) > 1e-8 * std::abs(sizes[order[2]])))
        throw InvalidArgument(std::string("all views look from the same side") + kInstead);
    const int n = order[0];
    Vec3 axis = Vec3(directions[0][n], directions[1][n], directions[2][n]).normalized();
    const int largest = std::abs(axis.z) >= std::max(std::abs(axis.x), std::abs(axis.y)) ? 2
                        : std::abs(axis.y) >= std::abs(axis.x)                           ? 1
                                                                                         : 0;
    return axis[largest] < 0 ? -axis : axis;
}

/// Two directions that make a right-handed system with the axis.
void planeOf(const Vec3& axis, Vec3& e1, Vec3& e2) {
    const Vec3 aside = axisAside(axis);
    e1 = (aside - axis * aside.dot(axis)).normalized();
    e2 = axis.cross(e1);
}

/// Solves equations . x = values for least squares, by the normal equations; `equations` holds their coefficients.
/// `ridge` pulls the last unknown to 0 where they leave it open.
Vec3 leastSquares(const std::vector<Vec3>& equations, const std::vector<double>& values, double ridge) {
    Matrix3 normal(0.0);
    Vec3 right(0);
    for (std::size_t n = 0; n < equations.size(); ++n)
        for (int a = 0; a < 3; ++a) {
            for (int b = 0; b < 3; ++b) normal[a][b] += equations[n][a] * equations[n][b];
            right[a] += equations[n][a] * values[n];
        }
    normal[2][2] += ridge * double(equations.size());
    return right * normal.inverse();  // symmetric: row and column vectors are alike
}

double angleIn(const Vec3& v, const Vec3& e1, const Vec3& e2) {
    const double angle = std::atan2(v.dot(e2), v.dot(e1));
    return angle < 0 ? angle + 2 * kPi : angle;
}

/// Circle through the sources: |s|² = 2 c.s + (r² - |c|²) is linear in the centre c and what is in brackets.
OrbitFit fitSources(const ProjectionGeometry& geometry) {
    const std::size_t count = geometry.views.size();
    if (count < 3) throw InvalidArgument("there are " + std::to_string(count) + " views, at least 3 are needed");
    Vec3 mean(0);
    for (const XrayView& view : geometry.views) mean += view.source / double(count);
    std::vector<Vec3> sources;
    for (const XrayView& view : geometry.views) sources.push_back(view.source - mean);
    OrbitFit fit;
    fit.axis = flattestDirection(sources);
    Vec3 e1, e2;
    planeOf(fit.axis, e1, e2);
    std::vector<Vec3> equations;
    std::vector<double> values;
    for (const Vec3& s : sources) {
        const double x = s.dot(e1), y = s.dot(e2);
        equations.emplace_back(2 * x, 2 * y, 1);
        values.push_back(x * x + y * y);
    }
    const Vec3 solution = leastSquares(equations, values, 0);
    fit.center = mean + e1 * solution.x + e2 * solution.y;
    fit.radius = std::sqrt(solution.z + solution.x * solution.x + solution.y * solution.y);
    for (std::size_t n = 0; n < count; ++n) {
        const Vec3 s = geometry.views[n].source - fit.center;
        const double off = std::hypot(s.dot(fit.axis), (s - fit.axis * s.dot(fit.axis)).length() - fit.radius);
        if (!(off <= kTolerance * fit.radius))
            throw InvalidArgument("view " + std::to_string(n) + ": its source is " + std::to_string(off) +
                                  " away from the circle of radius " + std::to_string(fit.radius) +
                                  " that fits all sources best" + kInstead);
        fit.angles.push_back(angleIn(s, e1, e2));
    }
    return fit;
}

/// Where the axis falls on the detector is one unknown number s in all views: with u at right angles to ray and axis,
/// middle.u = center.u + s.
OrbitFit fitDirections(const ProjectionGeometry& geometry) {
    std::vector<Vec3> directions;
    for (const XrayView& view : geometry.views) directions.push_back(view.direction);
    OrbitFit fit;
    fit.axis = flattestDirection(directions);
    Vec3 e1, e2;
    planeOf(fit.axis, e1, e2);
    std::vector<Vec3> equations;
    std::vector<double> values;
    double height = 0;
    for (std::size_t n = 0; n < directions.size(); ++n) {
        if (!(std::abs(directions[n].dot(fit.axis)) <= kTolerance))
            throw InvalidArgument("view " + std::to_string(n) +
                                  ": its rays are not at right angles to the axis that fits all views best" + kInstead);
        fit.angles.push_back(angleIn(-directions[n], e1, e2));
        const Vec3 u = fit.axis.cross(directions[n]).normalized();
        const Vec3 middle = geometry.views[n].pixel(0.5 * (geometry.width - 1), 0.5 * (geometry.height - 1));
        equations.emplace_back(u.dot(e1), u.dot(e2), 1);
        values.push_back(middle.dot(u));
        height += middle.dot(fit.axis) / double(directions.size());
    }
    const Vec3 solution = leastSquares(equations, values, 1e-9);
    fit.center = e1 * solution.x + e2 * solution.y + fit.axis * height;
    return fit;
}

}  // namespace

OrbitFit fitOrbit(const ProjectionGeometry& geometry) {
    geometry.validate();
    return geometry.beam == BeamShape::cone ? fitSources(geometry) : fitDirections(geometry);
}

std::optional<OrbitFit> findOrbit(const ProjectionGeometry& geometry) {
    try {
        return fitOrbit(geometry);
    } catch (const InvalidArgument&) {
        return {};
    }
}

}  // namespace raysweep
