#include "raysweep/reconstruct/aligned_views.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace raysweep {
namespace {

constexpr double kAligned = 0.1;    ///< pixels by which an aligned detector's corners may lie elsewhere
constexpr double kFacing = 0.17;    ///< least cosine of a ray with the way to the axis, 80 degrees
constexpr double kInCommon = 0.75;  ///< part of the width that all rows must measure to be what counts

/// Where a detector would have to stand.
struct Plane {
    Vec3 facing, along, up;  ///< length 1: to the axis; of rows; of columns
    Vec3 middle;             ///< of the view's own detector
};

Plane alignedPlane(const XrayView& view, const ProjectionGeometry& geometry, const OrbitFit& orbit) {
    Plane plane;
    const bool cone = geometry.beam == BeamShape::cone;
    plane.facing = orbit.inPlane(cone ? orbit.center - view.source : view.direction).normalized();
    plane.along = orbit.axis.cross(plane.facing);
    plane.up = orbit.axis;
    plane.middle = view.pixel(0.5 * (geometry.width - 1), 0.5 * (geometry.height - 1));
    // The senses of its own detector, so that few are mirrored.
    const Vec3& rows = std::abs(view.column.dot(plane.up)) > std::abs(view.row.dot(plane.up)) ? view.row : view.column;
    const Vec3& columns = &rows == &view.row ? view.column : view.row;
    if (rows.dot(plane.along) < 0) plane.along = -plane.along;
    if (columns.dot(plane.up) < 0) plane.up = -plane.up;
    return plane;
}

Vec3 rayTo(const Vec3& point, const XrayView& view, BeamShape beam) {
    return beam == BeamShape::cone ? point - view.source : view.direction;
}

/// Where the ray through a point meets the plane.
Vec3 onPlane(const Vec3& point, const XrayView& view, BeamShape beam, const Plane& plane) {
    const Vec3 ray = rayTo(point, view, beam);
    return point + ray * (plane.facing.dot(plane.middle - point) / plane.facing.dot(ray));
}

/// Corners of the detector, the centres of pixels, in turn.
std::array<Vec3, 4> cornersOf(const XrayView& view, int width, int height) {
    return {view.pixel(0, 0), view.pixel(width - 1, 0), view.pixel(width - 1, height - 1), view.pixel(0, height - 1)};
}

void requireFacing(const XrayView& view, const ProjectionGeometry& geometry, const Plane& plane, std::size_t n) {
    for (const Vec3& corner : cornersOf(view, geometry.width, geometry.height))
        if (!(rayTo(corner, view, geometry.beam).normalized().dot(plane.facing) > kFacing))
            throw InvalidArgument("view " + std::to_string(n) +
                                  ": rays of its detector run more aside, or along the axis of the turn, than towards "
                                  "it; filtered backprojection cannot use them, iterative methods can");
}

/// True if the view's own detector is aligned but for a turn about the axis, which filtering allows.
bool isAligned(const XrayView& view, const ProjectionGeometry& geometry, const OrbitFit& orbit) {
    XrayView aligned = view;
    aligned.column = orbit.inPlane(view.column);
    aligned.row = orbit.axis * view.row.dot(orbit.axis);
    if (!(aligned.column.length() > 0.5 * view.column.length() && aligned.row.length() > 0.5 * view.row.length()))
        return false;
    const double x = 0.5 * (geometry.width - 1), y = 0.5 * (geometry.height - 1);
    aligned.origin = view.pixel(x, y) - aligned.column * x - aligned.row * y;
    const ViewMatrix matrix = viewMatrix(view, geometry.beam);
    for (const double cornerX : {0.0, 2 * x})
        for (const double cornerY : {0.0, 2 * y}) {
            const Vec3 p = aligned.pixel(cornerX, cornerY);
            const double depth = matrix.depth(p);
            if (!(std::hypot(matrix.x(p) / depth - cornerX, matrix.y(p) / depth - cornerY) < kAligned)) return false;
        }
    return true;
}

/// World units that move a ray's place on the view's own detector by one pixel, along `step` of length 1.
double pitchAlong(const Vec3& step, const ViewMatrix& measured, const Vec3& at) {
    const Vec3 next = at + step * 1e-3;
    const auto place = [&](const Vec3& p) {
        return std::array{measured.x(p) / measured.depth(p), measured.y(p) / measured.depth(p)};
    };
    const auto a = place(at), b = place(next);
    return 1e-3 / std::hypot(b[0] - a[0], b[1] - a[1]);
}

/// Columns that rows measure: where they cross the outline of the measured pixels.
DetectorReach reachOf(const std::array<Vec3, 4>& outline, const AlignedView& view) {
    DetectorReach common{-1e30, 1e30}, any{1e30, -1e30};
    std::array<std::array<double, 2>, 4> corners;  // columns and rows
    const double perColumn = view.xray.column.dot(view.xray.column), perRow = view.xray.row.dot(view.xray.row);
    for (int i = 0; i < 4; ++i) {
        const Vec3 p = outline[std::size_t(i)] - view.xray.origin;
        corners[std::size_t(i)] = {p.dot(view.xray.column) / perColumn, p.dot(view.xray.row) / perRow};
        any = {std::min(any.low, corners[std::size_t(i)][0]), std::max(any.high, corners[std::size_t(i)][0])};
    }
    for (int row = 0; row < view.height; ++row) {
        DetectorReach reach{1e30, -1e30};
        for (std::size_t i = 0; i < 4; ++i) {
            const auto &a = corners[i], &b = corners[(i + 1) % 4];
            if ((a[1] < row) == (b[1] < row)) continue;
            const double x = a[0] + (row - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            reach = {std::min(reach.low, x), std::max(reach.high, x)};
        }
        if (reach.low > reach.high) continue;
        common = {std::max(common.low, reach.low), std::min(common.high, reach.high)};
    }
    return common.high - common.low > kInCommon * (any.high - any.low) ? common : any;
}

AlignedView resampledView(const XrayView& view, const ProjectionGeometry& geometry, const Plane& plane,
                          const DetectorPart& part) {
    AlignedView aligned;
    aligned.resampled = true;
    aligned.measured = viewMatrix(view, geometry.beam);
    const Vec3 columnStep = plane.along * pitchAlong(plane.along, aligned.measured, plane.middle);
    const Vec3 rowStep = plane.up * pitchAlong(plane.up, aligned.measured, plane.middle);
    const std::array<Vec3, 4> corners = cornersOf(view, geometry.width, geometry.height);
    double low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
    for (const Vec3& corner : corners) {
        const Vec3 p = onPlane(corner, view, geometry.beam, plane) - plane.middle;
        const double at[2] = {p.dot(columnStep) / columnStep.dot(columnStep), p.dot(rowStep) / rowStep.dot(rowStep)};
        for (int i = 0; i < 2; ++i) low[i] = std::min(low[i], at[i]), high[i] = std::max(high[i], at[i]);
    }
    // In step with the detector's own pixels in the middle, where a slightly rolled one is hardly resampled then.
    const bool isUpright =
        std::abs(view.column.normalized().dot(plane.along)) >= std::abs(view.row.normalized().dot(plane.along));
    const int own[2] = {isUpright ? geometry.width : geometry.height, isUpright ? geometry.height : geometry.width};
    constexpr double kRounding = 1e-6;
    int count[2];
    double first[2];
    for (int i = 0; i < 2; ++i) {
        const double middle = 0.5 * (own[i] - 1);
        first[i] = std::floor(low[i] + middle + kRounding) - middle;
        count[i] = int(std::ceil(high[i] - first[i] - kRounding)) + 1;
    }
    aligned.width = count[0];
    aligned.height = count[1];
    aligned.xray = view;
    aligned.xray.column = columnStep;
    aligned.xray.row = rowStep;
    aligned.xray.origin = plane.middle + columnStep * first[0] + rowStep * first[1];
    std::array<Vec3, 4> outline;
    const std::array<Vec3, 4> edges{view.pixel(part.left, part.top), view.pixel(part.right, part.top),
                                    view.pixel(part.right, part.bottom), view.pixel(part.left, part.bottom)};
    for (std::size_t i = 0; i < 4; ++i) outline[i] = onPlane(edges[i], view, geometry.beam, plane);
    aligned.reach = reachOf(outline, aligned);
    return aligned;
}

/// Samples of Lanczos' kernel sinc(x) sinc(x/3) about a place, in steps of a thousandth of a pixel. Its passband is
/// flatter than that of cubic kernels, which would take from the detail that the ramp filter is to bring out.
class Lanczos {
  public:
    static constexpr int kTaps = 6, kBefore = 2;  ///< samples; of them before the one at or below the place
    using Weights = std::array<float, kTaps>;

    Lanczos() {
        for (int phase = 0; phase < kPhases; ++phase) {
            double sum = 0;
            std::array<double, kTaps> weights;
            for (int i = 0; i < kTaps; ++i) {
                const double x = i - kBefore - double(phase) / kPhases;
                weights[std::size_t(i)] = x == 0 ? 1 : std::abs(x) < 3 ? sinc(x) * sinc(x / 3) : 0;
                sum += weights[std::size_t(i)];
            }
            for (int i = 0; i < kTaps; ++i)
                weights_[std::size_t(phase)][std::size_t(i)] = float(weights[std::size_t(i)] / sum);
        }
    }

    /// Weights about `place`, and the sample at or below it.
    const Weights& about(double place, int& below) const {
        const long steps = std::lround(place * kPhases);
        below = int(std::floor(double(steps) / kPhases));
        return weights_[std::size_t(steps - long(below) * kPhases)];
    }

  private:
    static constexpr int kPhases = 1024;
    static double sinc(double x) { return std::sin(kPi * x) / (kPi * x); }
    std::array<Weights, kPhases> weights_;
};

/// The value at a place on the detector; beyond its outermost pixels their values go on.
float valueAt(const float* pixels, int width, int height, double x, double y) {
    static const Lanczos lanczos;
    int column, row;
    const Lanczos::Weights &wx = lanczos.about(x, column), &wy = lanczos.about(y, row);
    float value = 0;
    for (int j = 0; j < Lanczos::kTaps; ++j) {
        const int from = std::clamp(row + j - Lanczos::kBefore, 0, height - 1);
        const float* line = pixels + std::size_t(from) * std::size_t(width);
        float sum = 0;
        for (int i = 0; i < Lanczos::kTaps; ++i)
            sum += wx[std::size_t(i)] * line[std::clamp(column + i - Lanczos::kBefore, 0, width - 1)];
        value += wy[std::size_t(j)] * sum;
    }
    return value;
}

void resample(const AlignedView& view, const ProjectionGeometry& geometry, const float* pixels, float* rows) {
    constexpr double kEdge = 0.5 + 1e-6;  // pixels reach so far about their centres
    parallelFor(
        std::size_t(view.width),
        [&](std::size_t x) {
            int first = view.height, last = -1;  // measured
            for (int y = 0; y < view.height; ++y) {
                const Vec3 p = view.xray.pixel(double(x), y);
                const double depth = view.measured.depth(p);
                const double u = view.measured.x(p) / depth, v = view.measured.y(p) / depth;
                float& value = rows[std::size_t(y) * std::size_t(view.width) + x];
                value = 0;
                if (!(u >= -kEdge && v >= -kEdge && u <= geometry.width - 1 + kEdge &&
                      v <= geometry.height - 1 + kEdge))
                    continue;
                value = valueAt(pixels, geometry.width, geometry.height, u, v);
                first = std::min(first, y);
                last = y;
            }
            if (last < 0) return;
            const auto at = [&](int y) -> float& { return rows[std::size_t(y) * std::size_t(view.width) + x]; };
            for (int y = 0; y < first; ++y) at(y) = at(first);
            for (int y = last + 1; y < view.height; ++y) at(y) = at(last);
        },
        8);
}

}  // namespace

DetectorPart wholeDetector(const ProjectionGeometry& geometry) {
    return {-0.5, geometry.width - 0.5, -0.5, geometry.height - 0.5};
}

std::vector<AlignedView> alignedViews(const ProjectionGeometry& geometry, const OrbitFit& orbit,
                                      const std::vector<DetectorPart>& parts) {
    std::vector<AlignedView> views;
    for (std::size_t n = 0; n < geometry.views.size(); ++n) {
        const XrayView& view = geometry.views[n];
        const DetectorPart part = parts.empty() ? wholeDetector(geometry) : parts[n];
        const Plane plane = alignedPlane(view, geometry, orbit);
        requireFacing(view, geometry, plane, n);
        if (isAligned(view, geometry, orbit)) {
            AlignedView own;
            own.xray = view;
            own.width = geometry.width;
            own.height = geometry.height;
            own.reach = {part.left, part.right};
            views.push_back(own);
        } else {
            views.push_back(resampledView(view, geometry, plane, part));
        }
    }
    return views;
}

void widen(AlignedView& view, int before, int after) {
    view.before += before;
    view.width += before + after;
    view.reach.low += before;
    view.reach.high += before;
    view.xray.origin -= view.xray.column * double(before);
}

void alignedRows(const AlignedView& view, const ProjectionGeometry& geometry, const float* pixels, float* rows) {
    if (view.resampled) return resample(view, geometry, pixels, rows);
    const std::size_t width = std::size_t(view.width), own = std::size_t(geometry.width);
    std::fill_n(rows, width * std::size_t(view.height), 0.0f);
    for (std::size_t y = 0; y < std::size_t(view.height); ++y)
        std::copy_n(pixels + y * own, own, rows + y * width + std::size_t(view.before));
}

}  // namespace raysweep
