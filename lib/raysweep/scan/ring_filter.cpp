#include "raysweep/scan/ring_filter.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace raysweep {
namespace {

/// Means over all views of the pixels in row y; NaN where nothing was measured.
std::vector<double> meanOverViews(const Projections& projections, std::size_t y) {
    const auto width = std::size_t(projections.width);
    std::vector<double> sums(width, 0.0);
    std::vector<int> counts(width, 0);
    for (int n = 0; n < projections.views; ++n) {
        const float* row = projections.view(n) + y * width;
        for (std::size_t x = 0; x < width; ++x) {
            if (std::isnan(row[x])) continue;
            sums[x] += row[x];
            ++counts[x];
        }
    }
    for (std::size_t x = 0; x < width; ++x)
        sums[x] = counts[x] ? sums[x] / counts[x] : std::numeric_limits<double>::quiet_NaN();
    return sums;
}

/// Calls `use(value)` for the values around column x as far as they have a partner on the other side, so that slopes
/// even out, and for that of x itself.
template <class Use>
void forPairs(const std::vector<double>& profile, int x, int reach, const Use& use) {
    const auto at = [&](int column) { return profile[std::size_t(column)]; };
    if (!std::isnan(at(x))) use(at(x));
    for (int i = 1; i <= std::min({reach, x, int(profile.size()) - 1 - x}); ++i) {
        if (std::isnan(at(x - i)) || std::isnan(at(x + i))) continue;
        use(at(x - i));
        use(at(x + i));
    }
}

/// What remains of the profile without its mean over `window` columns.
std::vector<double> withoutMean(const std::vector<double>& profile, int window) {
    std::vector<double> rest(profile.size());
    for (int x = 0; x < int(profile.size()); ++x) {
        double sum = 0;
        int count = 0;
        forPairs(profile, x, window / 2, [&](double value) {
            sum += value;
            ++count;
        });
        rest[std::size_t(x)] = profile[std::size_t(x)] - sum / count;
    }
    return rest;
}

/// What remains of the profile without its median over `window` columns.
std::vector<double> withoutMedian(const std::vector<double>& profile, int window) {
    std::vector<double> rest(profile.size()), around;
    for (int x = 0; x < int(profile.size()); ++x) {
        around.clear();
        forPairs(profile, x, window / 2, [&](double value) { around.push_back(value); });
        std::sort(around.begin(), around.end());
        const std::size_t count = around.size();
        rest[std::size_t(x)] =
            profile[std::size_t(x)] - (count ? 0.5 * (around[(count - 1) / 2] + around[count / 2]) : 0);
    }
    return rest;
}

}  // namespace

void RingFilterOptions::validate() const {
    requireField(window >= 3 && window % 2 == 1, "ring filter window", window, "odd and at least 3");
}

void filterRings(Projections& projections, const RingFilterOptions& options) {
    options.validate();
    parallelFor(std::size_t(projections.height), [&](std::size_t y) {
        // A slope moves the median of columns with a ring among them, so slopes go first; the ring's own share in the
        // mean is about the same in all columns around it, and goes with the median.
        const std::vector<double> profile = meanOverViews(projections, y);
        const std::vector<double> ring = withoutMedian(withoutMean(profile, options.window), options.window);
        const auto width = std::size_t(projections.width);
        for (int n = 0; n < projections.views; ++n) {
            float* row = projections.view(n) + y * width;
            for (std::size_t x = 0; x < width; ++x)  // NaN stays NaN
                if (!(row[x] >= projections.saturation)) row[x] -= float(ring[x]);
        }
    });
}

}  // namespace raysweep
