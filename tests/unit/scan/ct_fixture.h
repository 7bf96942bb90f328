/// What the tests of reading and preparing projections share.
#pragma once

#include "raysweep/camera/projections.h"
#include "raysweep/core/error.h"
#include "raysweep/core/types.h"
#include "support/expect_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace raysweep::test {

/// A value for each ray that tells which it is, and that no integer type holds.
inline Projections numbered(int width, int height, int views) {
    Projections projections(width, height, views);
    for (std::size_t p = 0; p < projections.values.size(); ++p) projections.values[p] = 0.5f + 0.125f * float(p);
    return projections;
}

/// A disc of extinction `mu` per column's width; x, y, radius in columns, from the axis.
struct Disc {
    double x, y, radius, mu;
};

/// Parallel projections of discs, closed form, mean over each pixel's width from `samples` rays: one row, the axis in
/// column `axis`, angles in degrees.
inline Projections sinogram(const std::vector<Disc>& discs, int width, double axis, const std::vector<double>& angles,
                            int samples = 8) {
    Projections projections(width, 1, int(angles.size()));
    for (std::size_t n = 0; n < angles.size(); ++n) {
        const double c = std::cos(angles[n] * kPi / 180), s = std::sin(angles[n] * kPi / 180);
        for (int x = 0; x < width; ++x) {
            double sum = 0;
            for (const Disc& disc : discs)
                for (int k = 0; k < samples; ++k) {
                    const double at = x + (k + 0.5) / samples - 0.5 - axis - (disc.y * c - disc.x * s);
                    sum += 2 * disc.mu * std::sqrt(std::max(0.0, disc.radius * disc.radius - at * at));
                }
            projections.view(int(n))[x] = float(sum / samples);
        }
    }
    return projections;
}

/// `count` angles from `first`, `step` degrees apart.
inline std::vector<double> anglesFrom(double first, double step, int count) {
    std::vector<double> angles;
    for (int n = 0; n < count; ++n) angles.push_back(first + n * step);
    return angles;
}

/// A body without symmetry, about 90 columns in radius.
inline std::vector<Disc> lopsidedBody() {
    return {{5, -8, 80, 0.01}, {-40, 20, 12, 0.02}, {30, 35, 9, -0.008}, {20, -45, 6, 0.03}, {55, 10, 4, 0.02}};
}

inline double rmsDifference(const Projections& a, const Projections& b) {
    double sum = 0;
    for (std::size_t p = 0; p < a.values.size(); ++p) sum += std::pow(double(a.values[p]) - b.values[p], 2);
    return std::sqrt(sum / double(a.values.size()));
}

}  // namespace raysweep::test
