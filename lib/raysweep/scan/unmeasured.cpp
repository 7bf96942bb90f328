// Pixels that do not measure: found, and filled in. See line_integrals.h.
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/scan/line_integrals.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace raysweep {
namespace {

/// Views that it takes to call a pixel dead.
constexpr int kViewsForProof = 8;

/// More do not change a majority, but take time.
constexpr int kViewsAsked = 64;

/// Calls `use(index)` for the other pixels of the 5 x 3 around column x, row y; at an edge, of the 5 x 3 beside it.
template <class Use>
void forNeighbours(const Projections& p, int x, int y, const Use& use) {
    const int left = std::max(0, std::min(x - 2, p.width - 5)), right = std::min(p.width - 1, left + 4);
    for (int j = std::max(0, y - 1); j <= std::min(p.height - 1, y + 1); ++j)
        for (int i = left; i <= right; ++i)
            if (i != x || j != y) use(std::size_t(j) * std::size_t(p.width) + std::size_t(i));
}

/// Whether each pixel has at least two different values.
std::vector<char> varying(const Projections& projections) {
    std::vector<char> varies(projections.pixelsPerView(), 0);
    parallelFor(std::size_t(projections.height), [&](std::size_t y) {
        const auto width = std::size_t(projections.width);
        for (std::size_t p = y * width; p < (y + 1) * width; ++p) {
            float first = std::numeric_limits<float>::quiet_NaN();
            for (int n = 0; n < projections.views && !varies[p]; ++n) {
                const float value = projections.view(n)[p];
                if (std::isnan(first)) first = value;
                varies[p] = !std::isnan(value) && value != first;
            }
        }
    });
    return varies;
}

/// A pixel that never varies, though one of the two on either side does. Air beside a body does not vary either, but
/// has such neighbours on one side only.
bool isStuck(const Projections& projections, const std::vector<char>& varies, int x, int y) {
    const auto at = [&](int column) {
        return column >= 0 && column < projections.width &&
               varies[std::size_t(y) * std::size_t(projections.width) + std::size_t(column)];
    };
    return !at(x) && (at(x - 2) || at(x - 1)) && (at(x + 1) || at(x + 2));
}

/// True if the pixel stands out in one view.
bool standsOut(const Projections& projections, const float* view, int x, int y) {
    float neighbours[17];  // 14 at most; GCC 12 wants room for the 16 that its sort takes apart
    int count = 0;
    forNeighbours(projections, x, y, [&](std::size_t p) {
        if (!std::isnan(view[p])) neighbours[count++] = view[p];
    });
    if (count < 4) return false;
    std::sort(neighbours, neighbours + count);
    const float median = 0.5f * (neighbours[(count - 1) / 2] + neighbours[count / 2]);
    const float value = view[std::size_t(y) * std::size_t(projections.width) + std::size_t(x)];
    // Equal neighbours, of a body without noise, have no range: what little the last bits differ by is no sign of
    // death.
    return std::abs(value - median) > 2 * (neighbours[count - 1] - neighbours[0]) + 1e-3f * std::abs(median);
}

bool isOutlier(const Projections& projections, int x, int y) {
    const int asked = std::min(projections.views, kViewsAsked);
    int votes = 0;
    for (int n = 0; n < asked; ++n)
        votes += standsOut(projections, projections.view(int(std::int64_t(n) * projections.views / asked)), x, y);
    return 2 * votes > asked;
}

/// @return whether anything was measured in the row.
bool fillRow(float* row, int width) {
    int last = -1;  // measured column
    for (int x = 0; x < width; ++x) {
        if (std::isnan(row[x])) continue;
        for (int gap = last + 1; gap < x; ++gap)
            row[gap] = last < 0 ? row[x] : row[last] + (row[x] - row[last]) * float(gap - last) / float(x - last);
        last = x;
    }
    if (last < 0) return false;
    std::fill(row + last + 1, row + width, row[last]);
    return true;
}

/// @return whether anything was measured in the view.
bool fillView(float* view, int width, int height) {
    std::vector<int> measured;
    for (int y = 0; y < height; ++y)
        if (fillRow(view + std::ptrdiff_t(y) * width, width)) measured.push_back(y);
    if (measured.empty()) return false;
    for (int y = 0; y < height; ++y) {
        const int nearest = *std::min_element(measured.begin(), measured.end(),
                                              [y](int a, int b) { return std::abs(a - y) < std::abs(b - y); });
        if (nearest != y) std::copy_n(view + std::ptrdiff_t(nearest) * width, width, view + std::ptrdiff_t(y) * width);
    }
    return true;
}

}  // namespace

std::size_t markDeadPixels(Projections& projections) {
    if (projections.views < kViewsForProof) return 0;
    const std::vector<char> varies = varying(projections);
    std::vector<char> dead(projections.pixelsPerView(), 0);
    parallelFor(std::size_t(projections.height), [&](std::size_t row) {
        const int y = int(row);
        for (int x = 0; x < projections.width; ++x)
            dead[row * std::size_t(projections.width) + std::size_t(x)] =
                isStuck(projections, varies, x, y) || isOutlier(projections, x, y);
    });
    std::size_t found = 0;
    for (std::size_t p = 0; p < dead.size(); ++p) {
        if (!dead[p]) continue;
        bool known = true;
        for (int n = 0; n < projections.views; ++n) {
            float& value = projections.view(n)[p];
            known = known && std::isnan(value);
            value = std::numeric_limits<float>::quiet_NaN();
        }
        found += !known;
    }
    return found;
}

std::size_t fillUnmeasured(Projections& projections) {
    const auto unmeasured = std::size_t(std::count_if(projections.values.begin(), projections.values.end(),
                                                      [](float value) { return std::isnan(value); }));
    if (unmeasured == 0) return 0;
    std::vector<char> filled(std::size_t(projections.views), 0);
    parallelFor(filled.size(), [&](std::size_t n) {
        filled[n] = fillView(projections.view(int(n)), projections.width, projections.height);
    });
    const auto empty = std::find(filled.begin(), filled.end(), 0);
    if (empty != filled.end())
        throw InvalidArgument("nothing was measured in view " + std::to_string(empty - filled.begin()) +
                              " (counted from 0); leave it out");
    return unmeasured;
}

}  // namespace raysweep
