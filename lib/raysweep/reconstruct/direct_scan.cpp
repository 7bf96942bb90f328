#include "raysweep/reconstruct/direct_scan.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace raysweep {
namespace {

constexpr double kDegrees = 180 / kPi;
constexpr double kMissed = 0.02;   ///< part of the lines at a distance that may be missing
constexpr double kTooMany = 0.05;  ///< of them, and less far out than kInside of what the scan reaches: no result
constexpr double kInside = 0.9;
constexpr double kVisible = 0.02;  ///< of the largest line integral: what missing lines show if they show anything
constexpr double kNearAxis = 6;    ///< pixels
constexpr int kDistances = 64;     ///< at which missing lines are looked for
constexpr double kSteep = 0.21;    ///< a pixel: weights that change more near the axis leave a spot there

/// Of the rays of a column of an aligned detector, what passOf says of a point.
double passOf(const ProjectionGeometry& geometry, const OrbitFit& orbit, const AlignedView& view, double column) {
    return passOf(geometry, orbit, view.xray, view.xray.pixel(column, 0.5 * (view.height - 1)));
}

std::vector<DetectorReach> reachesOf(const ProjectionGeometry& geometry, const OrbitFit& orbit,
                                     const std::vector<AlignedView>& views) {
    std::vector<DetectorReach> reaches;
    for (const AlignedView& view : views) {
        const double a = passOf(geometry, orbit, view, view.reach.low);
        const double b = passOf(geometry, orbit, view, view.reach.high);
        reaches.push_back({std::min(a, b), std::max(a, b)});
    }
    return reaches;
}

/// What filtering pixels as if their distance were 1, and backprojecting with 1/depth², leaves to be done: 1/pitch,
/// and for cones distance of source and axis over that of source and detector, both in the orbit's plane.
double scaleOf(const ProjectionGeometry& geometry, const OrbitFit& orbit, const XrayView& view) {
    const Vec3 column = orbit.inPlane(view.column);
    if (geometry.beam == BeamShape::parallel) return 1 / column.cross(view.direction).length();
    const Vec3 normal = orbit.inPlane(view.column.cross(view.row)).normalized();
    const double distance = std::abs((view.origin - view.source).dot(normal));
    return orbit.radius / (distance * column.length());
}

}  // namespace

double passOf(const ProjectionGeometry& geometry, const OrbitFit& orbit, const XrayView& view, const Vec3& point) {
    if (geometry.beam == BeamShape::parallel)
        return (point - orbit.center).dot(orbit.axis.cross(orbit.inPlane(view.direction)).normalized());
    const Vec3 toAxis = orbit.inPlane(orbit.center - view.source), ray = orbit.inPlane(point - view.source);
    return std::atan2(toAxis.cross(ray).dot(orbit.axis), toAxis.dot(ray));
}

double distanceOf(const ProjectionGeometry& geometry, const OrbitFit& orbit, double q) {
    return geometry.beam == BeamShape::cone ? orbit.radius * std::sin(q) : q;
}

DirectScan::DirectScan(const ProjectionGeometry& geometry, const OrbitFit& orbit,
                       const std::vector<DetectorPart>& parts)
    : geometry(geometry),
      orbit(orbit),
      views(alignedViews(geometry, orbit, parts)),
      redundancy(geometry.beam, orbit.angles, reachesOf(geometry, orbit, views)) {
    // To both sides of the axis as far as any view reaches: there what a displaced detector does not see is filtered
    // from what it does see.
    const double furthest = redundancy.furthest() * (1 - 1e-6);
    for (AlignedView& view : views) {
        const double edges[2] = {-0.5, view.width - 0.5};
        const double first = passOf(geometry, orbit, view, edges[0]), last = passOf(geometry, orbit, view, edges[1]);
        const int most = 2 * view.width;
        int more[2] = {0, 0};
        for (int side = 0; side < 2; ++side) {
            const bool negative = (first < last) == (side == 0);
            const auto reaches = [&](int columns) {
                const double q = passOf(geometry, orbit, view, edges[side] + (side ? columns : -columns));
                return negative ? q <= -furthest : q >= furthest;
            };
            while (more[side] < most && !reaches(more[side])) ++more[side];
        }
        widen(view, more[0], more[1]);
    }
}

std::vector<double> DirectScan::columnWeights(std::size_t n) const {
    const double scale = scaleOf(geometry, orbit, views[n].xray) * redundancy.scan().weights[n];
    std::vector<double> weights;
    for (int x = 0; x < views[n].width; ++x)
        weights.push_back(scale * redundancy.weight(n, passOf(geometry, orbit, views[n], x)));
    return weights;
}

double DirectScan::cosine(std::size_t n, double x, double y) const {
    if (geometry.beam == BeamShape::parallel) return 1;
    const XrayView& view = views[n].xray;
    const Vec3 ray = view.pixel(x, y) - view.source;
    return ray.dot(orbit.inPlane(orbit.center - view.source).normalized()) / ray.length();
}

void DirectScan::requireAxisSeen() const {
    const std::vector<DetectorReach> reaches = reachesOf(geometry, orbit, views);
    double nearest = redundancy.furthest();  // that any view sees
    for (const DetectorReach& reach : reaches) nearest = std::min(nearest, std::max({0.0, reach.low, -reach.high}));
    const double pixel = (reaches[0].high - reaches[0].low) / (views[0].reach.high - views[0].reach.low);
    if (nearest > pixel)
        throw InvalidArgument(
            "the detector does not see the axis of the turn: lines of sight that pass it at less than " +
            brief(distanceOf(geometry, orbit, nearest)) +
            " world units are measured from no side, and filtered backprojection needs those through "
            "all of the object; iterative methods take what there is");
    for (std::size_t n = 0; n < views.size() && redundancy.scan().closed; ++n)
        if (!isCentred(reaches[n]) && steepness(n, kNearAxis * pixel) > kSteep)
            throw InvalidArgument(
                "view " + std::to_string(n) +
                ": the displaced detector reaches less than 4 pixels beyond the axis of the turn, too "
                "little for filtered backprojection to join the two sides; iterative methods can");
}

/// The most by which weights change from a pixel of view n to the next, of rays that pass the axis at less than q.
double DirectScan::steepness(std::size_t n, double q) const {
    const AlignedView& view = views[n];
    double most = 0, last = -1;
    for (int x = int(std::ceil(view.reach.low)); x < view.reach.high; ++x) {
        const double pass = passOf(geometry, orbit, view, x);
        const double weight = redundancy.weight(n, pass);
        if (last >= 0 && std::abs(pass) < q) most = std::max(most, std::abs(weight - last));
        last = weight;
    }
    return most;
}

/// Less than half a turn and the fan about the axis.
std::string DirectScan::shortArcWarning() const {
    const ScanAngles& scan = redundancy.scan();
    double fan = 0;
    for (const AlignedView& view : views) {
        if (geometry.beam == BeamShape::parallel) break;
        for (const double x : {view.reach.low + 0.5, view.reach.high - 0.5})
            fan = std::max(fan, std::abs(passOf(geometry, orbit, view, x)));
    }
    if (redundancy.scan().closed) return "";
    const double needed = 180 + 2 * fan * kDegrees, arc = scan.arc * kDegrees;
    if (arc > needed - 1) return "";
    std::ostringstream text;
    text << std::fixed << std::setprecision(1) << "the views cover " << arc << " degrees, but filtered backprojection "
         << "needs " << needed << (geometry.beam == BeamShape::cone ? " (half a turn and the angle of the fan)" : "")
         << ": expect streaks, or take an iterative method";
    return text.str();
}

/// True if rays that pass the axis at q or further show something, as far as some of them tell.
bool DirectScan::showsBeyond(double q, const Projections& projections) const {
    constexpr int kViews = 64, kRows = 32;  // that are looked at
    const float least = float(kVisible) * largestValue(projections);
    const int viewStep = std::max(1, projections.views / kViews), rowStep = std::max(1, projections.height / kRows);
    for (int n = 0; n < projections.views; n += viewStep)
        for (int y = rowStep / 2; y < projections.height; y += rowStep)
            for (int x = 0; x < projections.width; ++x) {
                const float value =
                    projections.view(n)[std::size_t(y) * std::size_t(projections.width) + std::size_t(x)];
                if (!(value > least)) continue;
                const XrayView& view = geometry.views[std::size_t(n)];
                if (std::abs(passOf(geometry, orbit, view, view.pixel(x, y))) >= q) return true;
            }
    return false;
}

/// @param part of what the scan reaches, from the axis outward, that is looked at
DirectScan::MissingLines DirectScan::missingLines(double part) const {
    MissingLines lines;
    for (int i = 0; i < int(part * kDistances); ++i) {
        const double q = redundancy.furthest() * (i + 0.5) / kDistances;
        if (distanceOf(geometry, orbit, q) > field) break;
        const double missed = redundancy.missed(q);
        if (!(missed > kMissed)) continue;
        if (lines.most == 0) lines.from = q;
        lines.to = q;
        lines.most = std::max(lines.most, missed);
    }
    return lines;
}

std::string DirectScan::describe(const MissingLines& lines) const {
    return "lines of sight that pass the axis at " + brief(distanceOf(geometry, orbit, lines.from)) + " to " +
           brief(distanceOf(geometry, orbit, lines.to)) + " world units are measured from some sides only, up to " +
           brief(100 * lines.most) + " % of them from none";
}

bool DirectScan::isSimple() const {
    const std::vector<DetectorReach> reaches = reachesOf(geometry, orbit, views);
    return redundancy.scan().arcs.size() == 1 && std::all_of(reaches.begin(), reaches.end(), isCentred);
}

void DirectScan::requireLines(const Projections& projections) const {
    if (isSimple()) return;
    const MissingLines lines = missingLines(kInside);
    if (lines.most > kTooMany && showsBeyond(lines.from, projections))
        throw InvalidArgument(describe(lines) +
                              "; filtered backprojection needs them all, iterative methods take what there is");
}

std::string DirectScan::warning(const Projections* projections) const {
    if (isSimple()) return shortArcWarning();
    const MissingLines lines = missingLines(1);
    if (lines.most == 0 || (projections && !showsBeyond(lines.from, *projections))) return "";
    return describe(lines) + ": expect shading and streaks there, or take an iterative method";
}

}  // namespace raysweep
