#include "raysweep/reconstruct/scan_angles.h"

#include "raysweep/core/types.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace raysweep {
namespace {

constexpr double kWideGap = 5;  ///< times the others' mean
constexpr double kSame = 1e-9;  ///< radians: views this near look from the same side

double squareOfSine(double x) {
    const double s = std::sin(x);
    return s * s;
}

}  // namespace

ScanAngles scanAngles(const std::vector<double>& angles, double period) {
    const std::size_t count = angles.size();
    std::vector<double> wrapped(count);
    for (std::size_t n = 0; n < count; ++n) wrapped[n] = angles[n] - period * std::floor(angles[n] / period);
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return wrapped[a] < wrapped[b]; });

    std::vector<double> gaps(count);  // after each, in order
    for (std::size_t n = 0; n < count; ++n)
        gaps[n] =
            n + 1 < count ? wrapped[order[n + 1]] - wrapped[order[n]] : wrapped[order[0]] + period - wrapped[order[n]];
    const std::size_t widest = std::size_t(std::max_element(gaps.begin(), gaps.end()) - gaps.begin());
    const auto differ = std::count_if(gaps.begin(), gaps.end(), [](double gap) { return gap > kSame; });

    ScanAngles scan;
    const double mean = differ > 1 ? (period - gaps[widest]) / double(differ - 1) : period;
    scan.closed = !(gaps[widest] > kWideGap * mean);
    if (!scan.closed) gaps[widest] = mean;
    scan.begin = wrapped[order[(widest + 1) % count]] - 0.5 * gaps[widest];
    scan.weights.resize(count);
    for (std::size_t n = 0; n < count; ++n) {
        scan.weights[order[n]] = 0.5 * (gaps[n] + gaps[(n + count - 1) % count]);
        scan.arc += gaps[n];
    }
    return scan;
}

double parkerWeight(double beta, double gamma, double delta) {
    if (delta <= 0) return 1;  // nothing is measured twice
    const double inside = delta * (1 - 1e-9);
    gamma = std::clamp(gamma, -inside, inside);
    if (beta < 0 || beta > kPi + 2 * delta) return 0;
    if (beta < 2 * (delta - gamma)) return squareOfSine(0.25 * kPi * beta / (delta - gamma));
    if (beta <= kPi - 2 * gamma) return 1;
    return squareOfSine(0.25 * kPi * (kPi + 2 * delta - beta) / (delta + gamma));
}

}  // namespace raysweep
