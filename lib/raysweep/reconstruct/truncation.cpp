#include "raysweep/reconstruct/truncation.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/reconstruct/direct_scan.h"
#include "raysweep/reconstruct/redundancy.h"

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

/// By how much rays pass the axis at either end of a view's rows: q of redundancy.h.
double passAt(const Truncation& t, const Rows& rows, std::size_t n, bool high) {
    const Vec3 end = rows.pixel(n, high ? rows.width() - 0.5 : -0.5, 0.5 * (rows.count() - 1));
    return passOf(rows.geometry, t.orbit, rows.geometry.views[n], end);
}

std::vector<DetectorReach> reachesOf(const Truncation& t, const Rows& rows) {
    std::vector<DetectorReach> reaches;
    for (std::size_t n = 0; n < rows.geometry.views.size(); ++n) {
        const double a = passAt(t, rows, n, false), b = passAt(t, rows, n, true);
        reaches.push_back({std::min(a, b), std::max(a, b)});
    }
    return reaches;
}

/// The q up to which no detector ends before a line that it looks along, unless another view measures it; 0 if there is
/// none. @param least what is nearer to the axis is not looked at
double measuredUpTo(const Redundancy& lines, double least) {
    constexpr double kMostCut = 0.02;  // of the lines at one distance
    constexpr int kDistances = 64, kHalvings = 14;
    if (lines.cut(least) > kMostCut) return 0;
    double measured = least, cut = least;
    while (cut <= lines.furthest()) {
        cut = measured + lines.furthest() / kDistances;
        if (lines.cut(cut) > kMostCut) break;
        measured = cut;
    }
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (measured + cut);
        (lines.cut(middle) > kMostCut ? cut : measured) = middle;
    }
    return measured;
}

/// The detector's end just beyond q: rays at the very end count too little for `measuredUpTo` to see them. q if none is
/// within `most`.
double endNear(double q, double most, const std::vector<DetectorReach>& reaches) {
    double end = q + most;
    for (const DetectorReach& reach : reaches)
        for (const double at : {std::abs(reach.low), std::abs(reach.high)})
            if (q > 0 && at >= q) end = std::min(end, at);
    return q > 0 && end < q + most ? end : q;
}

/// Radius and ends, from what all views measure together. @return false if there is no field
bool findField(Truncation& t, const ProjectionGeometry& geometry) {
    constexpr double kAside = 0.05;  // of the furthest: ends that are as near to each other are alike
    const Rows rows = rowsOf(t, geometry);
    const std::vector<DetectorReach> reaches = reachesOf(t, rows);
    const Redundancy lines(geometry.beam, t.orbit.angles, reaches);
    const double pixel = (reaches[0].high - reaches[0].low) / rows.width();
    const double field = endNear(measuredUpTo(lines, pixel), 0.5 * pixel, reaches);
    t.radius = distanceOf(geometry, t.orbit, field);
    const double aside = kAside * lines.furthest();
    for (std::size_t n = 0; n < reaches.size(); ++n) {
        const bool turned = passAt(t, rows, n, false) > passAt(t, rows, n, true);
        const bool below = !lines.isMeasured(t.orbit.angles[n], reaches[n].low - aside);
        const bool above = !lines.isMeasured(t.orbit.angles[n], reaches[n].high + aside);
        t.ends.push_back({turned ? above : below, turned ? below : above});
    }
    return t.radius > 0;
}

/// Outer ends of one row: what share of them is within the object, and how much is measured there.
struct Ends {
    std::size_t all = 0, cut = 0;
    double sum = 0;  ///< of line integrals at those that are cut
};

Ends endsOf(const Truncation& t, const Rows& rows, const Projections& projections, int row) {
    const int views = projections.views, window = std::max(1, views / 24);  // on either side
    Ends ends;
    std::vector<float> values(static_cast<std::size_t>(views));
    for (const bool high : {false, true}) {
        const auto isOuter = [&](int n) { return high ? t.ends[std::size_t(n)].high : t.ends[std::size_t(n)].low; };
        for (int n = 0; n < views; ++n)
            values[std::size_t(n)] =
                isOuter(n) ? endOf(rows, projections.view(n), row, high) : std::numeric_limits<float>::quiet_NaN();
        for (int n = 0; n < views; ++n) {
            if (!isOuter(n)) continue;
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

/// A row of a view.
struct ViewRow {
    const Truncation& truncation;
    const Rows& rows;
    std::size_t view;
    int row;

    /// What its body measures at a pixel, which may be beside the detector.
    double bodyAt(double x) const {
        const EllipticBody& body = truncation.bodies[std::size_t(row)];
        if (!(body.extinction > 0)) return 0;
        const XrayView& from = rows.geometry.views[view];
        const PlaneRay ray = planeRay(truncation, from, rows.geometry.beam, rows.pixel(view, x, row));
        return ray.length * body.lineIntegral(ray.line.normalX, ray.line.normalY, ray.line.distance);
    }
};

/// Continues one side of a row: the body, moved at the end to where the row is, and less of it where the row ends
/// beside the object. @param to pixel i beyond the end is `to(i)`, i from 1
template <class To>
void continueRow(const ViewRow& row, float end, bool high, int count, const To& to) {
    const double part = std::clamp(2 * end / double(row.truncation.threshold) - 1, 0.0, 1.0);
    if (!(part > 0)) return;
    const int last = row.rows.width() - 1, inward = std::min(1, last);  // the median is of three pixels
    const double offset = end - row.bodyAt(high ? last - inward : inward);
    const double fading = std::max(4.0, 0.1 * row.rows.width());  // pixels
    for (int i = 1; i <= count; ++i) {
        const double value = row.bodyAt(high ? last + i : -i) + offset * std::exp(-i / fading);
        to(i) = float(part * std::max(0.0, value));
    }
}

/// How many pixels rows need at one side until all rays beyond pass the object; at most twice what they have.
int pixelsBeyond(const Truncation& t, const Rows& rows, bool high) {
    constexpr int kMore = 2;
    int pixels = 0;
    for (std::size_t n = 0; n < t.ends.size(); ++n) {
        if (!(high ? t.ends[n].high : t.ends[n].low)) continue;
        const double side = passAt(t, rows, n, high) > passAt(t, rows, n, !high) ? 1 : -1;
        const auto passes = [&](int i) {
            const Vec3 pixel = rows.pixel(n, high ? rows.width() - 1 + i : -i, 0.5 * (rows.count() - 1));
            return side * planeRay(t, rows.geometry.views[n], rows.geometry.beam, pixel).line.distance >= t.reach;
        };
        int needed = 0;
        while (needed + kMore < 2 * rows.width() && !passes(needed)) ++needed;
        pixels = std::max(pixels, needed + kMore);
    }
    return pixels;
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
    const std::optional<OrbitFit> orbit = findOrbit(geometry);
    return orbit ? findTruncation(projections, geometry, *orbit) : std::optional<Truncation>();
}

std::optional<Truncation> findTruncation(const Projections& projections, const ProjectionGeometry& geometry,
                                         const OrbitFit& orbit) {
    constexpr double kWithin = 0.05, kViews = 0.05;  // of the largest line integral, of the ends of a row
    Truncation t;
    t.orbit = orbit;
    const XrayView& first = geometry.views.front();
    t.sideways = std::abs(first.column.dot(t.orbit.axis)) * first.row.length() >
                 std::abs(first.row.dot(t.orbit.axis)) * first.column.length();
    t.planeX = t.orbit.inPlane(t.sideways ? first.row : first.column).normalized();
    t.planeY = t.orbit.axis.cross(t.planeX);
    const double largest = usualLargest(projections);
    t.threshold = float(kWithin * largest);
    if (!(largest > 0) || !findField(t, geometry)) return {};

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

WideDetector wideDetector(const Truncation& t, const ProjectionGeometry& geometry) {
    const Rows rows = rowsOf(t, geometry);
    const int low = pixelsBeyond(t, rows, false), high = pixelsBeyond(t, rows, true);
    WideDetector wide{geometry, {}, low, high};
    (t.sideways ? wide.geometry.height : wide.geometry.width) += low + high;
    for (XrayView& view : wide.geometry.views) view.origin -= (t.sideways ? view.row : view.column) * double(low);
    for (const OuterEnds& ends : t.ends) {
        DetectorPart part = wholeDetector(wide.geometry);
        if (!ends.low) (t.sideways ? part.top : part.left) += low;
        if (!ends.high) (t.sideways ? part.bottom : part.right) -= high;
        wide.parts.push_back(part);
    }
    return wide;
}

std::vector<float> continuedView(const Truncation& t, const ProjectionGeometry& geometry, const WideDetector& wide,
                                 std::size_t n, const float* measured) {
    const Rows rows = rowsOf(t, geometry), wideRows = rowsOf(t, wide.geometry);
    std::vector<float> values(std::size_t(wide.geometry.width) * std::size_t(wide.geometry.height));
    parallelFor(std::size_t(rows.count()), [&](std::size_t number) {
        const int row = int(number), last = rows.width() - 1;
        const auto at = [&](int x) -> float& { return values[wideRows.index(wide.low + x, row)]; };
        for (int x = 0; x <= last; ++x) at(x) = measured[rows.index(x, row)];
        for (const bool high : {false, true}) {
            const int count = high ? wide.high : wide.low;
            const auto beyond = [&](int i) -> float& { return at(high ? last + i : -i); };
            if (high ? t.ends[n].high : t.ends[n].low)
                continueRow({t, rows, n, row}, endOf(rows, measured, row, high), high, count, beyond);
            else
                for (int i = 1; i <= count; ++i) beyond(i) = at(high ? last : 0);
        }
    });
    return values;
}

}  // namespace raysweep
