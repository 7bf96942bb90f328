#include "raysweep/reconstruct/truncation.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raysweep {
namespace {

/// Pixels as lateral x row, whichever way the detector lies.
struct Rows {
    const ProjectionGeometry& geometry;
    bool sideways;

    int width() const { return sideways ? geometry.height : geometry.width; }
    int count() const { return sideways ? geometry.width : geometry.height; }
    Vec3 pixel(std::size_t n, double x, double row) const {
        return sideways ? geometry.views[n].pixel(row, x) : geometry.views[n].pixel(x, row);
    }
    std::size_t index(int x, int row) const {
        return sideways ? std::size_t(x) * std::size_t(geometry.width) + std::size_t(row)
                        : std::size_t(row) * std::size_t(geometry.width) + std::size_t(x);
    }
};

Rows rowsOf(const Truncation& truncation, const ProjectionGeometry& geometry) {
    return {geometry, truncation.sideways};
}

/// The ray of a pixel in the plane across the axis; `length` times its line integral is that of the ray itself.
struct PlaneRay {
    PlaneLine line;
    double length = 1;
};

PlaneRay planeRay(const Truncation& t, const XrayView& view, BeamShape beam, const Vec3& pixel) {
    const Vec3 ray = beam == BeamShape::cone ? pixel - view.source : view.direction;
    const double x = ray.dot(t.planeX), y = ray.dot(t.planeY), across = std::hypot(x, y);
    const Vec3 place = pixel - t.orbit.center;
    PlaneRay in;
    in.line.normalX = -y / across;
    in.line.normalY = x / across;
    in.line.distance = in.line.normalX * place.dot(t.planeX) + in.line.normalY * place.dot(t.planeY);
    in.length = ray.length() / across;
    return in;
}

/// Median of the three outermost pixels of a row that were measured, or of as many as there are; NaN without any.
float endOf(const Rows& rows, const float* view, int row, bool high) {
    float values[3];
    int count = 0;
    for (int i = 0; i < rows.width() && count < 3; ++i) {
        const float value = view[rows.index(high ? rows.width() - 1 - i : i, row)];
        if (!std::isnan(value)) values[count++] = value;
    }
    if (count == 0) return std::numeric_limits<float>::quiet_NaN();
    std::sort(values, values + count);
    return values[count / 2];
}

/// True if the views look from all sides: no gap is five times as wide as they are apart on average.
bool isFullTurn(const OrbitFit& orbit) {
    std::vector<double> angles = orbit.angles;
    std::sort(angles.begin(), angles.end());
    double widest = angles.front() + 2 * kPi - angles.back();
    for (std::size_t n = 1; n < angles.size(); ++n) widest = std::max(widest, angles[n] - angles[n - 1]);
    return angles.size() > 2 && widest < 5 * 2 * kPi / double(angles.size());
}

/// How far from the axis the rays at either end of the rows pass, in the view where that is least.
void findField(Truncation& t, const ProjectionGeometry& geometry) {
    constexpr double kDisplaced = 0.95;
    const Rows rows = rowsOf(t, geometry);
    double reach[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (std::size_t n = 0; n < geometry.views.size(); ++n)
        for (const bool high : {false, true}) {
            const Vec3 end = rows.pixel(n, high ? rows.width() - 0.5 : -0.5, 0.5 * (rows.count() - 1));
            reach[high] =
                std::min(reach[high], std::abs(planeRay(t, geometry.views[n], geometry.beam, end).line.distance));
        }
    const bool full = isFullTurn(t.orbit);
    t.low = !full || reach[0] >= kDisplaced * reach[1];
    t.high = !full || reach[1] >= kDisplaced * reach[0];
    t.radius = full ? std::max(reach[0], reach[1]) : std::min(reach[0], reach[1]);
}

/// Ends of one row: what share of them is within the object, and how much is measured there.
struct Ends {
    std::size_t all = 0, cut = 0;
    double sum = 0;  ///< of line integrals at those that are cut
};

Ends endsOf(const Truncation& t, const Rows& rows, const Projections& projections, int row) {
    const int views = projections.views, window = std::max(1, views / 24);  // on either side
    Ends ends;
    std::vector<float> values(static_cast<std::size_t>(views));
    for (const bool high : {false, true}) {
        if (!(high ? t.high : t.low)) continue;
        for (int n = 0; n < views; ++n) values[std::size_t(n)] = endOf(rows, projections.view(n), row, high);
        for (int n = 0; n < views; ++n) {
            double sum = 0, count = 0;
            for (int m = std::max(0, n - window); m <= std::min(views - 1, n + window); ++m)
                if (!std::isnan(values[std::size_t(m)])) sum += values[std::size_t(m)], ++count;
            if (count == 0) continue;
            ++ends.all;
            if (!(sum > t.threshold * count)) continue;
            ++ends.cut;
            ends.sum += sum / count;
        }
    }
    return ends;
}

/// The lines of one row, evenly some of them.
std::vector<PlaneLine> linesOf(const Truncation& t, const Projections& projections, const ProjectionGeometry& geometry,
                               int row) {
    constexpr int kViews = 60, kPixels = 64;
    const Rows rows = rowsOf(t, geometry);
    const int views = std::min(kViews, projections.views), pixels = std::min(kPixels, rows.width());
    std::vector<PlaneLine> lines;
    for (int i = 0; i < views; ++i)
        for (int k = 0; k < pixels; ++k) {
            const int n = int(std::int64_t(i) * projections.views / views);
            const int x = pixels < 2 ? 0 : int(std::int64_t(k) * (rows.width() - 1) / (pixels - 1));
            const float value = projections.view(n)[rows.index(x, row)];
            if (std::isnan(value)) continue;
            PlaneRay ray =
                planeRay(t, geometry.views[std::size_t(n)], geometry.beam, rows.pixel(std::size_t(n), x, row));
            ray.line.value = value / ray.length;
            lines.push_back(ray.line);
        }
    return lines;
}

/// Bodies of the rows that are `cut`, some of them fitted, those between as what is between.
void fitBodies(Truncation& t, const Projections& projections, const ProjectionGeometry& geometry,
               const std::vector<int>& cut) {
    constexpr std::size_t kFits = 64;
    const std::size_t fits = std::min(kFits, cut.size());
    std::vector<std::size_t> at(fits);  // of `cut`
    for (std::size_t i = 0; i < fits; ++i) at[i] = fits < 2 ? 0 : i * (cut.size() - 1) / (fits - 1);
    std::vector<EllipticBody> fitted(fits);
    parallelFor(fits, [&](std::size_t i) {
        fitted[i] = fitEllipticBody(linesOf(t, projections, geometry, cut[at[i]]), t.radius);
    });
    std::size_t next = 0;
    for (std::size_t k = 0; k < cut.size(); ++k) {
        while (next + 1 < fits && at[next] < k) ++next;
        const std::size_t before = next > 0 ? next - 1 : 0;
        const double part = next > 0 ? double(k - at[before]) / double(at[next] - at[before]) : 0;
        EllipticBody& body = t.bodies[std::size_t(cut[k])];
        body = EllipticBody::between(fitted[before], fitted[next], part);
        t.reach = std::max(t.reach, body.reach());
    }
}

/// What the body of a row measures at a pixel, which may be beside the detector.
double bodyAt(const Truncation& t, const Rows& rows, std::size_t n, double x, int row) {
    const EllipticBody& body = t.bodies[std::size_t(row)];
    if (!(body.extinction > 0)) return 0;
    const PlaneRay ray = planeRay(t, rows.geometry.views[n], rows.geometry.beam, rows.pixel(n, x, row));
    return ray.length * body.lineIntegral(ray.line.normalX, ray.line.normalY, ray.line.distance);
}

/// Continues one side of a row: the body, moved at the end to where the row is, and less of it where the row ends
/// beside the object. @param to pixel i beyond the end is `to(i)`, i from 1
template <class To>
void continueRow(const Truncation& t, const Rows& rows, std::size_t n, int row, float end, bool high, int count,
                 const To& to) {
    const double part = std::clamp(2 * end / double(t.threshold) - 1, 0.0, 1.0);
    if (!(part > 0)) return;
    const int last = rows.width() - 1, inward = std::min(1, last);  // the median is of three pixels
    const double offset = end - bodyAt(t, rows, n, high ? last - inward : inward, row);
    const double fading = std::max(4.0, 0.1 * rows.width());  // pixels
    for (int i = 1; i <= count; ++i) {
        const double value = bodyAt(t, rows, n, high ? last + i : -i, row) + offset * std::exp(-i / fading);
        to(i) = float(part * std::max(0.0, value));
    }
}

}  // namespace

std::string Truncation::warning() const {
    return "the object is wider than the detector: " + brief(100 * share, 3) + " % of its rows end within it, at " +
           brief(100 * border, 3) +
           " % of the largest line integral. Beyond, it is taken for ellipses of one extinction; "
           "densities are good within " +
           brief(radius, 4) + " of the axis, and left out further away";
}

std::optional<Truncation> findTruncation(const Projections& projections, const ProjectionGeometry& geometry) {
    constexpr double kWithin = 0.05, kViews = 0.05;  // of the largest line integral, of the ends of a row
    Truncation t;
    try {
        t.orbit = fitOrbit(geometry);
    } catch (const InvalidArgument&) {
        return {};
    }
    const XrayView& first = geometry.views.front();
    t.sideways = std::abs(first.column.dot(t.orbit.axis)) * first.row.length() >
                 std::abs(first.row.dot(t.orbit.axis)) * first.column.length();
    t.planeX = t.orbit.inPlane(t.sideways ? first.row : first.column).normalized();
    t.planeY = t.orbit.axis.cross(t.planeX);
    findField(t, geometry);
    const double largest = usualLargest(projections);
    t.threshold = float(kWithin * largest);
    if (!(largest > 0)) return {};

    const Rows rows = rowsOf(t, geometry);
    std::vector<Ends> ends(std::size_t(rows.count()));
    parallelFor(ends.size(), [&](std::size_t row) { ends[row] = endsOf(t, rows, projections, int(row)); });
    std::vector<int> cut;
    Ends all;
    for (std::size_t row = 0; row < ends.size(); ++row) {
        all.all += ends[row].all;
        if (ends[row].cut == 0 || double(ends[row].cut) < kViews * double(ends[row].all)) continue;
        all.cut += ends[row].cut;
        all.sum += ends[row].sum;
        cut.push_back(int(row));
    }
    if (cut.empty()) return {};
    t.share = double(all.cut) / double(all.all);
    t.border = all.sum / double(all.cut) / largest;
    t.bodies.resize(ends.size());
    fitBodies(t, projections, geometry, cut);
    return t;
}

void widen(const Truncation& t, Projections& projections, ProjectionGeometry& geometry) {
    const Rows rows = rowsOf(t, geometry);
    const double pixel = 2 * t.radius / rows.width();  // at the axis, or larger
    const int needed = int(std::ceil(std::max(0.0, t.reach - t.radius) / pixel)) + 2;
    const int beyond = std::min(needed, 2 * rows.width());
    const int low = t.low ? beyond : 0, high = t.high ? beyond : 0;

    ProjectionGeometry wide = geometry;
    (t.sideways ? wide.height : wide.width) += low + high;
    for (XrayView& view : wide.views) view.origin -= (t.sideways ? view.row : view.column) * double(low);
    const Rows wideRows = rowsOf(t, wide);
    Projections all(wide.width, wide.height, projections.views);
    all.saturation = projections.saturation;
    parallelFor(std::size_t(projections.views), [&](std::size_t n) {
        const float* from = projections.view(int(n));
        float* to = all.view(int(n));
        for (int row = 0; row < rows.count(); ++row) {
            for (int x = 0; x < rows.width(); ++x) to[wideRows.index(low + x, row)] = from[rows.index(x, row)];
            const auto below = [&](int i) -> float& { return to[wideRows.index(low - i, row)]; };
            const auto above = [&](int i) -> float& { return to[wideRows.index(low + rows.width() - 1 + i, row)]; };
            continueRow(t, rows, n, row, endOf(rows, from, row, false), false, low, below);
            continueRow(t, rows, n, row, endOf(rows, from, row, true), true, high, above);
        }
    });
    projections = std::move(all);
    geometry = std::move(wide);
}

}  // namespace raysweep
