// Where the axis falls onto the detector. A parallel beam sees the same from both sides: with s the distance from the
// axis, p(s, angle + 180) = p(-s, angle). For an axis in column c, two such views a and b have a(x) = b(2c - x).
// Minimised over c is (docs/ct.md, eq. 8)
//
//     mismatch(c) = Σ_x (a(x) - b(2c - x))² / (Σ_x (a(x) - mean a)² + Σ_x (b(x) - mean b)²)                    (8)
//
// x: all columns that a and the mirrored b share. It is 1 for views without relation, whatever their noise: else few
// columns of empty space would fit best. 2c is taken whole, so that nothing needs to be interpolated along x, and a
// parabola finds the place between.
#include "raysweep/scan/rotation_center.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/types.h"
#include "raysweep/scan/line_integrals.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <sstream>
#include <string>

namespace raysweep {
namespace {

// As many as an answer to a hundredth of a column needs; more only take time.
constexpr int kMostRows = 32;
constexpr std::size_t kMostPairs = 8;
/// Steps between views that the last one may end before half a turn.
constexpr double kMostStepsShort = 1.5;
/// Views this close together, in degrees, are taken together against noise.
constexpr double kWindow = 1;
/// Of the detector's width, that both views of a pair must see.
constexpr double kLeastShared = 0.25;
/// Of the variance of all views: less than it in what two views share counts as nothing to see.
constexpr double kLeastVariance = 1e-6;
/// A mismatch above it is as good as anywhere.
constexpr double kMostMismatch = 0.5;

/// What would be seen at some angle: a sum of views.
struct Estimate {
    std::vector<int> views;
    std::vector<double> weights;
    double reach = 0;  ///< degrees to the view farthest from the angle
};

/// Two views half a turn apart.
struct Pair {
    Estimate view, opposite;
};

/// Rows of some views, smoothed.
struct Rows {
    int width = 0;
    std::vector<double> values;  ///< rows of `width`
    const double* row(std::size_t n) const { return values.data() + n * std::size_t(width); }
    std::size_t count() const { return values.size() / std::size_t(width); }
};

/// Views by angle.
struct Turn {
    std::vector<int> views;
    std::vector<double> angles;  ///< rising
};

Turn sortedByAngle(const std::vector<double>& angles) {
    Turn turn;
    turn.views.resize(angles.size());
    std::iota(turn.views.begin(), turn.views.end(), 0);
    std::stable_sort(turn.views.begin(), turn.views.end(),
                     [&](int a, int b) { return angles[std::size_t(a)] < angles[std::size_t(b)]; });
    for (const int view : turn.views) turn.angles.push_back(angles[std::size_t(view)]);
    return turn;
}

/// The straight line, by least squares, through the views within the window about `angle`; if there are less than two,
/// through the two that are nearest on both sides, or beyond the ends; or the view itself that is at the angle.
Estimate estimateAt(const Turn& turn, double angle) {
    const auto after = std::lower_bound(turn.angles.begin(), turn.angles.end(), angle - kWindow);
    std::size_t first = std::size_t(after - turn.angles.begin()), end = first;
    while (end < turn.angles.size() && turn.angles[end] <= angle + kWindow) ++end;
    const bool exact = end == first + 1 && std::abs(turn.angles[first] - angle) < 1e-3 * kWindow;
    if (end < first + 2 && !exact) {
        const auto next = std::lower_bound(turn.angles.begin() + 1, turn.angles.end() - 1, angle);
        end = std::size_t(next - turn.angles.begin()) + 1;
        first = end - 2;
    }
    Estimate estimate;
    const double count = double(end - first);
    const double mean =
        std::accumulate(turn.angles.begin() + std::ptrdiff_t(first), turn.angles.begin() + std::ptrdiff_t(end), 0.0) /
        count;
    double spread = 0;
    for (std::size_t n = first; n < end; ++n) spread += std::pow(turn.angles[n] - mean, 2);
    for (std::size_t n = first; n < end; ++n) {
        const double slope = spread > 0 ? (angle - mean) * (turn.angles[n] - mean) / spread : 0;
        estimate.views.push_back(turn.views[n]);
        estimate.weights.push_back(1 / count + slope);
        estimate.reach = std::max(estimate.reach, std::abs(turn.angles[n] - angle));
    }
    return estimate;
}

[[noreturn]] void failArc(double arc) {
    std::ostringstream message;
    message << "the views span " << arc
            << " degrees, but the centre of rotation is found from views that are 180 apart; "
            << "give the axis' column instead";
    throw InvalidArgument(message.str());
}

/// Pairs whose second is among the measured views; only if there are none, the one that is not far beyond the last.
std::vector<Pair> opposites(const std::vector<double>& angles) {
    const Turn turn = sortedByAngle(angles);
    const std::size_t count = angles.size();
    const double last = turn.angles.back(), arc = last - turn.angles.front();
    // Rounding of angles is no gap.
    const double step = count < 2 ? 0 : arc / double(count - 1), within = last + 1e-3 * step;
    std::size_t starts = 0;
    while (starts < count && turn.angles[starts] + 180 <= within) ++starts;
    if (starts == 0) {
        if (count < 3 || turn.angles[0] + 180 > last + kMostStepsShort * step) failArc(arc);
        starts = 1;
    }
    std::vector<Pair> pairs;
    for (std::size_t n = 0; n < std::min(starts, kMostPairs); ++n) {
        const double angle = turn.angles[n * starts / std::min(starts, kMostPairs)];
        pairs.push_back({estimateAt(turn, angle), estimateAt(turn, angle + 180)});
    }
    return pairs;
}

/// Standard deviation, in columns, of the details that views made of others lack. What lies at the detector's edge
/// moves by half its width times the angle between them. Where each view is a measured one only noise is to be
/// smoothed.
double lostDetail(const std::vector<Pair>& pairs, int width) {
    double reach = 0;
    for (const Pair& pair : pairs) reach = std::max({reach, pair.view.reach, pair.opposite.reach});
    return std::max(1.0, std::min(0.5 * width * reach * kPi / 180, width / 24.0));
}

/// Gaussian of standard deviation `sigma`; columns beyond the ends are like the last ones.
void smooth(double* row, int width, double sigma) {
    const int reach = int(std::ceil(3 * sigma));
    std::vector<double> weights(std::size_t(reach) + 1), from(row, row + width);
    double sum = 0;
    for (int i = 0; i <= reach; ++i) {
        weights[std::size_t(i)] = std::exp(-0.5 * i * i / (sigma * sigma));
        sum += (i ? 2 : 1) * weights[std::size_t(i)];
    }
    for (int x = 0; x < width; ++x) {
        double value = 0;
        for (int i = -reach; i <= reach; ++i)
            value += weights[std::size_t(std::abs(i))] * from[std::size_t(std::clamp(x + i, 0, width - 1))];
        row[x] = value / sum;
    }
}

/// Some rows, evenly chosen among those of which every view measured a part.
std::vector<std::size_t> measuredRows(const Projections& projections) {
    const std::size_t width = std::size_t(projections.width);
    std::vector<std::size_t> measured, chosen;
    for (std::size_t y = 0; y < std::size_t(projections.height); ++y) {
        bool all = true;
        for (int view = 0; view < projections.views && all; ++view) {
            const float* row = projections.view(view) + y * width;
            all = std::any_of(row, row + width, [](float value) { return std::isfinite(value); });
        }
        if (all) measured.push_back(y);
    }
    if (measured.empty())
        throw InvalidArgument("no detector row was measured in all views: the axis cannot be found; give its column");
    const std::size_t rows = std::min(measured.size(), std::size_t(kMostRows));
    for (std::size_t n = 0; n < rows; ++n) chosen.push_back(measured[(2 * n + 1) * measured.size() / (2 * rows)]);
    return chosen;
}

void appendRows(const Projections& projections, const std::vector<std::size_t>& rows, const Estimate& estimate,
                double sigma, Rows& to) {
    const int width = projections.width;
    Projections row(width, 1, 1);
    for (const std::size_t y : rows) {
        std::vector<double> sum(std::size_t(width), 0.0);
        for (std::size_t v = 0; v < estimate.views.size(); ++v) {
            std::copy_n(projections.view(estimate.views[v]) + y * std::size_t(width), width, row.values.begin());
            fillUnmeasured(row);
            for (std::size_t x = 0; x < sum.size(); ++x) sum[x] += estimate.weights[v] * row.values[x];
        }
        smooth(sum.data(), width, sigma);
        to.values.insert(to.values.end(), sum.begin(), sum.end());
    }
}

double variance(const std::vector<double>& values) {
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
    double sum = 0;
    for (const double value : values) sum += (value - mean) * (value - mean);
    return sum / double(values.size());
}

/// Eq. 8 for an axis in column `twice` / 2. Columns within `margin` of an end, where smoothing
/// lacks neighbours, are left out.
double mismatch(const Rows& a, const Rows& b, int twice, int margin, double leastVariance) {
    const int from = std::max(margin, twice - (a.width - 1 - margin)), to = twice - from;
    const double shared = to - from + 1;
    double difference = 0, variation = 0;
    for (std::size_t n = 0; n < a.count(); ++n) {
        const double *rowA = a.row(n), *rowB = b.row(n);
        double sumA = 0, sumB = 0, squares = 0;
        for (int x = from; x <= to; ++x) {
            const double one = rowA[x], other = rowB[twice - x];
            difference += (one - other) * (one - other);
            squares += one * one + other * other;
            sumA += one;
            sumB += other;
        }
        variation += squares - (sumA * sumA + sumB * sumB) / shared;
    }
    const double samples = shared * double(a.count());
    return variation > leastVariance * samples ? difference / variation : 1;
}

void requireSinogram(const Projections& projections, const std::vector<double>& angles) {
    if (angles.size() != std::size_t(projections.views))
        throw InvalidArgument(std::to_string(angles.size()) + " angles do not fit " +
                              std::to_string(projections.views) + " views; there must be one for each");
    if (angles.empty()) throw InvalidArgument("there are no views");
    for (const double angle : angles)
        if (!std::isfinite(angle)) throw InvalidArgument("the angles of the views must be finite");
    if (projections.width < 16)
        throw InvalidArgument("the detector has " + std::to_string(projections.width) +
                              " columns: too few to find the centre of rotation; give the axis' column instead");
}

/// Where the parabola through the least value and its neighbours is lowest, from the least value on.
double parabolaOffset(const std::vector<double>& misfits, std::vector<double>::const_iterator best) {
    if (best == misfits.begin() || best + 1 == misfits.end()) return 0;
    const double before = *(best - 1), after = *(best + 1), curvature = before - 2 * *best + after;
    return curvature > 0 ? 0.5 * (before - after) / curvature : 0;
}

}  // namespace

RotationCenter findRotationCenter(const Projections& projections, const std::vector<double>& angles) {
    requireSinogram(projections, angles);
    const std::vector<Pair> pairs = opposites(angles);
    const int width = projections.width;
    const double sigma = lostDetail(pairs, width);
    const std::vector<std::size_t> rows = measuredRows(projections);
    Rows a{width, {}}, b{width, {}};
    for (const Pair& pair : pairs) {
        appendRows(projections, rows, pair.view, sigma, a);
        appendRows(projections, rows, pair.opposite, sigma, b);
    }
    const double leastVariance = kLeastVariance * (variance(a.values) + variance(b.values));
    const int margin = std::min(int(std::ceil(2 * sigma)), width / 12);
    const int least = int(std::ceil(kLeastShared * width)) + 2 * margin, most = 2 * (width - 1) - least;
    std::vector<double> misfits(std::size_t(most - least + 1));
    parallelFor(misfits.size(),
                [&](std::size_t n) { misfits[n] = mismatch(a, b, least + int(n), margin, leastVariance); });
    const auto best = std::min_element(misfits.cbegin(), misfits.cend());
    if (!(*best <= kMostMismatch))
        throw InvalidArgument(
            "opposite views have nothing in common: the beam must be parallel, the axis along the detector's columns, "
            "and the angles those of the views; or give the axis' column");
    return {0.5 * (least + double(best - misfits.cbegin()) + parabolaOffset(misfits, best)), *best};
}

}  // namespace raysweep
