#include "raysweep/reconstruct/scan_angles.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace raysweep {
namespace {

constexpr double kWideGap = 5;  ///< times the mean of the narrower ones
constexpr double kSame = 1e-9;  ///< radians: views this near look from the same side

/// The mean of the gaps that are part of the sampling: of those that remain when the widest are taken away as long as
/// they are too wide for the rest, and wider than `widest`.
double meanGap(std::vector<double> gaps, double period, double widest) {
    std::sort(gaps.begin(), gaps.end());
    double rest = period;
    while (gaps.size() > 1) {
        rest -= gaps.back();
        const auto narrower = std::count_if(gaps.begin(), gaps.end() - 1, [](double gap) { return gap > kSame; });
        if (narrower == 0) return gaps.back();
        if (!(gaps.back() > widest && gaps.back() > kWideGap * rest / double(narrower)))
            return (rest + gaps.back()) / double(narrower + 1);
        gaps.pop_back();
    }
    return period;
}

/// Arcs between the gaps that are left out. @param gaps after each view of `angles`, which ascend
std::vector<ScanArc> arcsBetween(const std::vector<double>& angles, const std::vector<double>& gaps,
                                 const std::vector<bool>& leftOut, double mean, double period) {
    const std::size_t count = angles.size();
    std::vector<ScanArc> arcs;
    for (std::size_t n = 0; n < count; ++n) {
        if (!leftOut[(n + count - 1) % count]) continue;
        ScanArc arc{angles[n] - 0.5 * mean, mean};
        for (std::size_t m = n; !leftOut[m % count]; ++m) arc.length += gaps[m % count];
        arc.begin -= period * std::floor(arc.begin / period);
        arcs.push_back(arc);
    }
    if (arcs.empty()) arcs.push_back({0, period});
    return arcs;
}

}  // namespace

ScanAngles scanAngles(const std::vector<double>& angles, double period, double widest) {
    const std::size_t count = angles.size();
    std::vector<double> wrapped(count);
    for (std::size_t n = 0; n < count; ++n) wrapped[n] = angles[n] - period * std::floor(angles[n] / period);
    ScanAngles scan;
    scan.order.resize(count);
    std::iota(scan.order.begin(), scan.order.end(), std::size_t(0));
    std::stable_sort(scan.order.begin(), scan.order.end(),
                     [&](std::size_t a, std::size_t b) { return wrapped[a] < wrapped[b]; });

    std::vector<double> ascending(count), gaps(count);  // in order; gaps after each
    for (std::size_t n = 0; n < count; ++n) ascending[n] = wrapped[scan.order[n]];
    for (std::size_t n = 0; n < count; ++n)
        gaps[n] = n + 1 < count ? ascending[n + 1] - ascending[n] : ascending[0] + period - ascending[n];
    const double mean = meanGap(gaps, period, widest);
    std::vector<bool> leftOut(count);
    for (std::size_t n = 0; n < count; ++n) leftOut[n] = gaps[n] > widest && gaps[n] > kWideGap * mean;
    scan.arcs = arcsBetween(ascending, gaps, leftOut, mean, period);
    scan.closed = std::find(leftOut.begin(), leftOut.end(), true) == leftOut.end();
    for (std::size_t n = 0; n < count; ++n)
        if (leftOut[n]) gaps[n] = mean;
    scan.weights.resize(count);
    for (std::size_t n = 0; n < count; ++n) {
        scan.weights[scan.order[n]] = 0.5 * (gaps[n] + gaps[(n + count - 1) % count]);
        scan.arc += gaps[n];
    }
    return scan;
}

}  // namespace raysweep
