/// Noise of our own, so that a seed gives the same volume on every machine.
#pragma once

#include "raysweep/core/types.h"

#include <cmath>
#include <cstdint>

namespace raysweep {

/// Uniform 32 bits for a lattice point.
inline std::uint32_t latticeHash(int x, int y, int z, std::uint32_t seed) {
    std::uint32_t h = seed * 0x9e3779b9u + 0x7f4a7c15u;
    for (const int c : {x, y, z}) {
        h ^= static_cast<std::uint32_t>(c);
        h *= 0x85ebca6bu;
        h ^= h >> 15;
        h *= 0xc2b2ae35u;
        h ^= h >> 13;
    }
    return h;
}

/// Uniform in [0,1).
inline double latticeRandom(int x, int y, int z, std::uint32_t seed) {
    return latticeHash(x, y, z, seed) * (1.0 / 4294967296.0);
}

/// Gradient noise with features of about size 1; in about [-1,1], zero on average. Perlin, "Improving Noise",
/// SIGGRAPH 2002: the same fade and gradients, with a hash instead of a table.
inline double gradientNoise(const Vec3& p, std::uint32_t seed) {
    const Vec3 base(std::floor(p.x), std::floor(p.y), std::floor(p.z));
    const Vec3 f = p - base;
    const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
    const double u = fade(f.x), v = fade(f.y), w = fade(f.z);
    const auto corner = [&](int dx, int dy, int dz) {
        const std::uint32_t h = latticeHash(int(base.x) + dx, int(base.y) + dy, int(base.z) + dz, seed) >> 28;
        const double x = f.x - dx, y = f.y - dy, z = f.z - dz;
        const double a = h < 8 ? x : y, b = h < 4 ? y : (h == 12 || h == 14 ? x : z);
        return (h & 1 ? -a : a) + (h & 2 ? -b : b);
    };
    const auto mix = [](double t, double a, double b) { return a + t * (b - a); };
    const auto row = [&](int dy, int dz) { return mix(u, corner(0, dy, dz), corner(1, dy, dz)); };
    return mix(w, mix(v, row(0, 0), row(1, 0)), mix(v, row(0, 1), row(1, 1)));
}

/// Sum of octaves of gradientNoise, each of half the size and `gain` times the height of the one before; in about
/// [-1,1].
inline double fractalNoise(const Vec3& p, int octaves, double gain, std::uint32_t seed) {
    double sum = 0, total = 0, height = 1;
    Vec3 q = p;
    for (int i = 0; i < octaves; ++i) {
        sum += height * gradientNoise(q, seed + std::uint32_t(i));
        total += height;
        height *= gain;
        q = q * 2.03;  // not exactly 2, so that lattices of octaves do not line up
    }
    return sum / total;
}

/// As fractalNoise, of the noise's absolute value: round bumps with sharp valleys, as on a cauliflower; in [0,1].
inline double billowNoise(const Vec3& p, int octaves, double gain, std::uint32_t seed) {
    double sum = 0, total = 0, height = 1;
    Vec3 q = p;
    for (int i = 0; i < octaves; ++i) {
        sum += height * std::fabs(gradientNoise(q, seed + std::uint32_t(i)));
        total += height;
        height *= gain;
        q = q * 2.03;
    }
    return sum / total;
}

}  // namespace raysweep
