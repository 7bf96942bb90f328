#include "raysweep/reconstruct/scan_angles.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace raysweep {
namespace {

constexpr double kWideGap = 5;  ///< times the mean of the narrower ones
constexpr double kSame = 1e-3;  ///< of the period over the views: those this near look from the same side

/// The mean of the gaps that are part of the sampling: of those that remain when the widest are taken away as long as
/// they are too wide for the rest, and wider than `widest`.
double meanGap(std::vector<double> gaps, double period, double widest) {
    std::sort(gaps.begin(), gaps.end());
    double rest = period;
    while (gaps.size() > 1) {
        rest -= gaps.back();
        const double narrower = double(gaps.size() - 1);
        if (!(gaps.back() > widest && gaps.back() > kWideGap * rest / narrower))
            return (rest + gaps.back()) / (narrower + 1);
        gaps.pop_back();
    }
    return period;
}

/// Groups of views that are near the first of each. @param ordered angles, ascending
std::vector<ScanDirection> directionsOf(const std::vector<double>& ordered, double same) {
    std::vector<ScanDirection> directions;
    double sum = 0;
    for (std::size_t k = 0; k < ordered.size(); ++k) {
        if (directions.empty() || ordered[k] - ordered[directions.back().first] > same) {
            directions.push_back({0, k, 0, 0});
            sum = 0;
        }
        ScanDirection& direction = directions.back();
        sum += ordered[k] - ordered[direction.first];
        ++direction.count;
        direction.angle = ordered[direction.first] + sum / double(direction.count);
    }
    return directions;
}

/// Arcs between the gaps that are left out. @param gaps after each direction
std::vector<ScanArc> arcsBetween(const std::vector<ScanDirection>& directions, const std::vector<double>& gaps,
                                 const std::vector<bool>& leftOut, double mean, double period) {
    const std::size_t count = directions.size();
    std::vector<ScanArc> arcs;
    for (std::size_t n = 0; n < count; ++n) {
        if (!leftOut[(n + count - 1) % count]) continue;
        ScanArc arc{directions[n].angle - 0.5 * mean, mean};
        for (std::size_t m = n; !leftOut[m % count]; ++m) arc.length += gaps[m % count];
        arc.begin -= period * std::floor(arc.begin / period);
        arcs.push_back(arc);
    }
    if (arcs.empty()) arcs.push_back({0, period});
    return arcs;
}

}  // namespace

ScanAngles scanAngles(const std::vector<double>& angles, double period, double widest) {
    const double same = kSame * period / double(angles.size());
    std::vector<double> wrapped;
    for (const double angle : angles) {
        const double rest = angle - period * std::floor(angle / period);
        wrapped.push_back(period - rest < same ? rest - period : rest);  // beside the first, not the last
    }
    ScanAngles scan;
    scan.order.resize(angles.size());
    std::iota(scan.order.begin(), scan.order.end(), std::size_t(0));
    std::stable_sort(scan.order.begin(), scan.order.end(),
                     [&](std::size_t a, std::size_t b) { return wrapped[a] < wrapped[b]; });
    std::vector<double> ordered;
    for (const std::size_t n : scan.order) ordered.push_back(wrapped[n]);
    scan.directions = directionsOf(ordered, same);

    const std::size_t count = scan.directions.size();
    std::vector<double> gaps;  // after each direction
    for (std::size_t k = 0; k < count; ++k)
        gaps.push_back(k + 1 < count ? scan.directions[k + 1].angle - scan.directions[k].angle
                                     : scan.directions[0].angle + period - scan.directions[k].angle);
    const double mean = meanGap(gaps, period, widest);
    std::vector<bool> leftOut(count);
    for (std::size_t k = 0; k < count; ++k) leftOut[k] = gaps[k] > widest && gaps[k] > kWideGap * mean;
    scan.arcs = arcsBetween(scan.directions, gaps, leftOut, mean, period);
    scan.closed = std::find(leftOut.begin(), leftOut.end(), true) == leftOut.end();
    for (std::size_t k = 0; k < count; ++k)
        if (leftOut[k]) gaps[k] = mean;
    scan.weights.resize(angles.size());
    for (std::size_t k = 0; k < count; ++k) {
        ScanDirection& direction = scan.directions[k];
        direction.weight = 0.5 * (gaps[k] + gaps[(k + count - 1) % count]);
        scan.arc += gaps[k];
        for (std::size_t i = 0; i < direction.count; ++i)
            scan.weights[scan.order[direction.first + i]] = direction.weight / double(direction.count);
    }
    return scan;
}

}  // namespace raysweep
