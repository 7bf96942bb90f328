/// Henyey and Greenstein's phase function for the Monte Carlo reference.
#pragma once

#include <algorithm>
#include <cmath>

#include "raysweep/core/types.h"

namespace raysweep::test {

/// Cosine of a scattering angle, distributed as Henyey and Greenstein's phase function (1941) of mean cosine `g`;
/// `u` uniform in [0,1).
inline double henyeyGreensteinCosine(double g, double u) {
    if (std::abs(g) < 1e-6) return 1 - 2 * u;
    const double root = (1 - g * g) / (1 - g + 2 * g * u);
    return std::min(1.0, std::max(-1.0, (1 + g * g - root * root) / (2 * g)));
}

/// Turns the unit vector `direction` by an angle of the given cosine, in the plane given by `azimuth`. The orthonormal
/// frame is that of Duff et al. 2017.
inline void deflect(double cosine, double azimuth, double* direction) {
    const double x = direction[0], y = direction[1], z = direction[2], sign = std::copysign(1.0, z);
    const double a = -1 / (sign + z), b = x * y * a, sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const double u = sine * std::cos(azimuth), v = sine * std::sin(azimuth);
    direction[0] = cosine * x + u * (1 + sign * x * x * a) + v * b;
    direction[1] = cosine * y + u * sign * b + v * (sign + y * y * a);
    direction[2] = cosine * z - u * sign * x - v * y;
    const double length =
        std::sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    for (int i = 0; i < 3; ++i) direction[i] /= length;
}

}  // namespace raysweep::test
