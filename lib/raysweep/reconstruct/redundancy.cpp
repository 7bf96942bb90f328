#include "raysweep/reconstruct/redundancy.h"

#include "raysweep/core/types.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// Views on either side that a mean reaches to: its weights fall to 0 there, so that detectors which alternate between
/// two places weigh alike.
constexpr int kNeighbours = 4;
constexpr double kEdge = 0.25;  ///< part of the detector's width in which d falls to 0
/// Of its width: twice as far off the axis the middle of a detector is displaced.
constexpr double kDisplaced = 0.1;
constexpr double kWideGap = 15 * kPi / 180;  ///< radians
constexpr double kLeastMeasured = 1e-6;      ///< M below it: nothing is measured
constexpr int kDirections = 180;             ///< of a turn, in which missing lines are looked for

/// 0 at 0 and below, 1 at 1 and above, smooth in between.
double squaredSine(double x) {
    const double s = std::sin(0.5 * kPi * std::clamp(x, 0.0, 1.0));
    return s * s;
}

/// d of eq. 9.
double windowAt(const DetectorReach& reach, double q) {
    return squaredSine(std::min(q - reach.low, reach.high - q) / (kEdge * (reach.high - reach.low)));
}

double wrap(double angle, double period) {
    return angle - period * std::floor(angle / period);
}

}  // namespace

bool isCentred(const DetectorReach& reach) {
    return std::abs(reach.low + reach.high) < kDisplaced * (reach.high - reach.low);
}

Redundancy::Redundancy(BeamShape beam, const std::vector<double>& angles, const std::vector<DetectorReach>& reaches)
    : cone_(beam == BeamShape::cone),
      folded_(!cone_ && std::all_of(reaches.begin(), reaches.end(), isCentred)),
      period_(folded_ ? kPi : 2 * kPi),
      reaches_(reaches),
      reversed_(angles.size()) {
    scan_ = scanAngles(angles, period_);
    angles_.resize(angles.size());
    for (const ScanDirection& direction : scan_.directions)
        for (std::size_t i = 0; i < direction.count; ++i) angles_[scan_.order[direction.first + i]] = direction.angle;
    for (std::size_t n = 0; n < angles.size(); ++n) {
        reversed_[n] = folded_ && std::lround((angles[n] - angles_[n]) / period_) % 2 != 0;
        if (reversed_[n]) reaches_[n] = {-reaches[n].high, -reaches[n].low};
        furthest_ = std::max({furthest_, std::abs(reaches[n].low), std::abs(reaches[n].high)});
    }
    if (scan_.closed || missed(0.5 * furthest_) == 0) return;
    // What no ray from the other side makes up for is better guessed from its neighbours, unless it is too wide.
    scan_ = scanAngles(angles, period_, kWideGap);
}

/// a of eq. 9. Folded it needs none: the ends of half a turn are each other's neighbours.
double Redundancy::taperAt(double angle) const {
    if (scan_.closed) return 1;
    const double excess = scan_.arc - kPi;  // what is measured twice lies at the ends
    for (const ScanArc& arc : scan_.arcs) {
        const double turned = wrap(angle - arc.begin, period_);
        if (turned > arc.length) continue;
        if (folded_ || excess <= 0) return 1;
        return squaredSine(std::min(turned, arc.length - turned) / std::min(excess, 0.5 * arc.length));
    }
    return 0;
}

/// The mean of d over the views from one angle.
double Redundancy::windowOf(const ScanDirection& direction, double q) const {
    double sum = 0;
    for (std::size_t i = 0; i < direction.count; ++i) sum += windowAt(reaches_[scan_.order[direction.first + i]], q);
    return sum / double(direction.count);
}

/// The mean of d about a direction, by the part of the turn that each stands for: evenly falling to 0 at the distance
/// of the fourth neighbours. @param k of the directions
double Redundancy::windowAbout(std::size_t k, double q) const {
    const std::vector<ScanDirection>& directions = scan_.directions;
    const long count = long(directions.size());
    // Directions go on beyond both ends, a period later and earlier.
    const auto angleAt = [&](long i) {
        const long turns = i >= 0 ? i / count : -((count - 1 - i) / count);
        return directions[std::size_t(i - turns * count)].angle + double(turns) * period_;
    };
    const double here = angleAt(long(k));
    const double reach = 0.5 * (angleAt(long(k) + kNeighbours) - angleAt(long(k) - kNeighbours));
    double sum = 0, parts = 0;
    const auto add = [&](long i) {
        const double nearness = 1 - std::abs(angleAt(i) - here) / reach;
        if (!(nearness > 0)) return false;
        const ScanDirection& direction = directions[std::size_t((i % count + count) % count)];
        sum += nearness * direction.weight * windowOf(direction, q);
        parts += nearness * direction.weight;
        return true;
    };
    for (long i = long(k); i < long(k) + count && add(i);) ++i;
    for (long i = long(k) - 1; i > long(k) - count && add(i);) --i;
    return sum / parts;
}

/// M of eq. 9 without a: linear between directions.
double Redundancy::meanWindow(double angle, double q) const {
    const std::vector<ScanDirection>& directions = scan_.directions;
    const std::size_t count = directions.size();
    angle = wrap(angle, period_);
    const auto later = std::upper_bound(directions.begin(), directions.end(), angle,
                                        [](double a, const ScanDirection& direction) { return a < direction.angle; });
    const std::size_t next = std::size_t(later - directions.begin());
    const std::size_t before = (next + count - 1) % count, after = next % count;
    const double gap = wrap(directions[after].angle - directions[before].angle, period_);
    const double way = gap > 0 ? std::min(1.0, wrap(angle - directions[before].angle, period_) / gap) : 0;
    return (1 - way) * windowAbout(before, q) + (way > 0 ? way * windowAbout(after, q) : 0);
}

double Redundancy::weight(std::size_t n, double q) const {
    if (reversed_[n]) q = -q;
    const double angle = angles_[n];
    const double own = windowAt(reaches_[n], q), taper = taperAt(angle);
    if (!(own > 0 && taper > 0)) return 0;
    double all = taper * meanWindow(angle, q);
    if (!folded_) {
        const double reverse = angle + kPi + (cone_ ? 2 * q : 0);
        all += taperAt(reverse) * meanWindow(reverse, -q);
    }
    return all > 0 ? own * taper / all : 0;  // own may be too small for the mean to know of it
}

/// A view looks at `angle`, and reaches q. Folded, what the other half of the turn sees counts from the other side.
bool Redundancy::seesAt(double angle, double q) const {
    if (folded_ && wrap(angle, 2 * kPi) >= kPi) q = -q;
    return taperAt(angle) > 0 && meanWindow(angle, q) > kLeastMeasured;
}

bool Redundancy::isMeasured(double angle, double q) const {
    return seesAt(angle, q) || (!folded_ && seesAt(angle + kPi + (cone_ ? 2 * q : 0), -q));
}

double Redundancy::missed(double q) const {
    int missed = 0;
    for (int k = 0; k < kDirections; ++k) missed += !isMeasured(2 * kPi * (k + 0.5) / kDirections - (cone_ ? q : 0), q);
    return double(missed) / kDirections;
}

double Redundancy::cut(double q) const {
    int cut = 0;
    for (int k = 0; k < kDirections; ++k) {
        const double angle = 2 * kPi * (k + 0.5) / kDirections - (cone_ ? q : 0);
        const bool looked = taperAt(angle) > 0 || taperAt(angle + kPi + (cone_ ? 2 * q : 0)) > 0;
        cut += looked && !isMeasured(angle, q);
    }
    return double(cut) / kDirections;
}

}  // namespace raysweep
