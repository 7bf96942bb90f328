#include "raysweep/phantoms/cloud_shape.h"

#include "raysweep/core/parallel.h"
#include "raysweep/phantoms/noise.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

constexpr double kBump = 0.22;       ///< height of the largest bumps
constexpr double kBumpSize = 0.34;   ///< their width
constexpr double kEdge = 0.09;       ///< depth below the surface at which the density is full
constexpr double kBlend = 0.05;      ///< radius of the fillets between puffs and at the base
constexpr double kThinnest = 0.004;  ///< lower densities are left out: they cost voxels and are not seen
constexpr int kBigPuffs = 7, kSmallPerBig = 7;

/// Smallest of two distances with a fillet of radius k. Quilez, "smooth minimum", polynomial.
double smoothMin(double a, double b, double k) {
    const double h = std::max(k - std::fabs(a - b), 0.0) / k;
    return std::min(a, b) - h * h * k * 0.25;
}

/// How far from a puff's surface density may still be.
double reachOfPuff() {
    return kBump + kBlend;
}

double smoothStep(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

std::vector<CloudPuff> makePuffs(std::uint32_t seed) {
    std::vector<CloudPuff> puffs;
    const auto random = [&](int i, int j, int k) { return latticeRandom(i, j, k, seed ^ 0x5eedu); };
    for (int i = 0; i < kBigPuffs; ++i) {
        // The largest stand in the middle, so that the whole heaps up rather than being a wall.
        const double along = (i + 0.5) / kBigPuffs * 2 - 1 + 0.12 * (random(i, 0, 0) - 0.5);
        const double middle = 1 - along * along;
        const double radius = 0.16 + 0.19 * middle * (0.7 + 0.6 * random(i, 1, 0));
        const Vec3 centre(0.8 * along, 0.45 * (random(i, 2, 0) - 0.5) * (0.4 + middle),
                          0.08 + middle * 0.26 * random(i, 3, 0));
        puffs.push_back({centre, radius});
        for (int j = 1; j <= kSmallPerBig; ++j) {
            const double turn = 2 * kPi * (j + random(i, 4, j)) / kSmallPerBig, up = -0.15 + 1.1 * random(i, 5, j);
            const double flat = std::sqrt(std::max(0.0, 1 - up * up));
            const Vec3 direction(flat * std::cos(turn), flat * std::sin(turn), std::min(up, 1.0));
            puffs.push_back({centre + direction * (radius * 0.85), radius * (0.3 + 0.35 * random(i, 6, j))});
        }
    }
    return puffs;
}

/// Finds the box of what is really there on a coarse grid: the puffs' own box is larger, by bumps that they lack.
void fitBox(CloudShape& shape) {
    const Vec3 low = shape.outerLow, high = shape.outerHigh, size = high - low;
    constexpr int kSamples = 96;
    const double step = std::max({size.x, size.y, size.z}) / kSamples;
    struct Slab {
        bool any = false;
        Vec3 low, high;
    };
    std::vector<Slab> slabs(std::size_t(size.x / step) + 1);
    parallelFor(slabs.size(), [&](std::size_t i) {
        for (double y = low.y; y <= high.y; y += step)
            for (double z = low.z; z <= high.z; z += step) {
                const Vec3 p(low.x + double(i) * step, y, z);
                const auto puffs = puffsNear(shape, p, 0);
                if (puffs.empty() || cloudDensity(shape, puffs, p) <= 0) continue;
                Slab& slab = slabs[i];
                for (int axis = 0; axis < 3; ++axis) {
                    slab.low[axis] = slab.any ? std::min(slab.low[axis], p[axis]) : p[axis];
                    slab.high[axis] = slab.any ? std::max(slab.high[axis], p[axis]) : p[axis];
                }
                slab.any = true;
            }
    });
    shape.low = high;
    shape.high = low;
    for (const Slab& slab : slabs)
        for (int axis = 0; axis < 3 && slab.any; ++axis) {
            shape.low[axis] = std::min(shape.low[axis], slab.low[axis] - step);
            shape.high[axis] = std::max(shape.high[axis], slab.high[axis] + step);
        }
}

}  // namespace

CloudShape makeCloudShape(std::uint32_t seed) {
    CloudShape shape;
    shape.seed = seed;
    shape.puffs = makePuffs(seed);
    shape.outerLow = shape.outerHigh = shape.puffs.front().centre;
    for (const CloudPuff& puff : shape.puffs)
        for (int axis = 0; axis < 3; ++axis) {
            const double reach = puff.radius + reachOfPuff();
            shape.outerLow[axis] = std::min(shape.outerLow[axis], puff.centre[axis] - reach);
            shape.outerHigh[axis] = std::max(shape.outerHigh[axis], puff.centre[axis] + reach);
        }
    shape.outerLow.z = std::max(shape.outerLow.z, shape.base - kBump);
    fitBox(shape);
    return shape;
}

std::vector<CloudPuff> puffsNear(const CloudShape& shape, const Vec3& p, double reach) {
    std::vector<CloudPuff> near;
    for (const CloudPuff& puff : shape.puffs)
        if ((p - puff.centre).length() <= puff.radius + reach + reachOfPuff()) near.push_back(puff);
    return near;
}

double cloudDensity(const CloudShape& shape, const std::vector<CloudPuff>& puffs, const Vec3& p) {
    double distance = 1e3;
    for (const CloudPuff& puff : puffs)
        distance = smoothMin(distance, (p - puff.centre).length() - puff.radius, kBlend);
    distance = -smoothMin(-distance, p.z - shape.base, 2 * kBlend);  // cut the base off flat
    if (distance > kBump) return 0;
    // The domain is warped first: bumps of pure noise lie on a lattice, and the eye finds it.
    const Vec3 q = p * (1 / kBumpSize);
    const Vec3 warp(gradientNoise(q * 0.7, shape.seed + 101), gradientNoise(q * 0.7, shape.seed + 202),
                    gradientNoise(q * 0.7, shape.seed + 303));
    const double bumps = billowNoise(q + warp * 0.35, 6, 0.5, shape.seed);
    const double depth = kBump * (2.2 * bumps - 0.45) - distance;
    if (depth <= 0) return 0;
    const double body = 0.8 + 0.35 * fractalNoise(q * 1.7, 4, 0.5, shape.seed + 77);
    const double density = smoothStep(depth / kEdge) * std::clamp(body, 0.3, 1.0);
    return density < kThinnest ? 0 : density;
}

}  // namespace raysweep
