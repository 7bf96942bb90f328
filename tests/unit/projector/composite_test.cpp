#include "raysweep/projector/composite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "unit/instruction_sets.h"

using namespace raysweep;

namespace {

constexpr int kChannels4 = 4;  // extinction, red, green, blue; of a ray: transmittance, red, green, blue

/// A number and its derivative in one direction.
struct Dual {
    double value = 0, change = 0;
};
Dual operator+(Dual a, Dual b) {
    return {a.value + b.value, a.change + b.change};
}
Dual operator-(Dual a, Dual b) {
    return {a.value - b.value, a.change - b.change};
}
Dual operator*(Dual a, Dual b) {
    return {a.value * b.value, a.change * b.value + a.value * b.change};
}
Dual exponential(Dual a) {
    return {std::exp(a.value), std::exp(a.value) * a.change};
}

float channelOf(const CompositeVoxel& voxel, int c) {
    return (&voxel.extinction)[c];
}
float channelOf(const RayColor& color, int c) {
    return (&color.transmittance)[c];
}

struct Volume {
    CompositeLayout layout;
    std::vector<CompositeVoxel> voxels;
};

/// The plain twin: every voxel asked for by its place, everything in double.
struct Twin {
    const CompositeLayout& layout;
    const std::vector<CompositeVoxel>&voxels, &changes;

    Dual at(const Index3& place, int c) const {
        for (int axis = 0; axis < 3; ++axis)
            if (place[axis] < 0 || place[axis] >= layout.dims[axis]) return {};
        const std::size_t i = layout.voxel(place);
        return {channelOf(voxels[i], c), channelOf(changes[i], c)};
    }

    Dual interpolated(const Vec3& place, int c) const {
        Dual sum;
        const Index3 below(int(std::floor(place.x)), int(std::floor(place.y)), int(std::floor(place.z)));
        for (int corner = 0; corner < 8; ++corner) {
            double weight = 1;
            Index3 voxel = below;
            for (int axis = 0; axis < 3; ++axis) {
                const double part = place[axis] - below[axis];
                const bool upper = (corner >> axis & 1) != 0;
                weight *= upper ? part : 1 - part;
                voxel[axis] += upper;
            }
            sum = sum + at(voxel, c) * Dual{weight, 0};
        }
        return sum;
    }

    std::array<Dual, 4> composited(const CompositeRay& ray) const {
        const int others[2] = {ray.axis == 0 ? 1 : 0, ray.axis == 2 ? 1 : 2};
        std::array<Dual, 4> sum;
        Dual transmittance{1, 0};
        for (int k = 0; k < ray.count; ++k) {
            Vec3 place;
            place[ray.axis] = double(ray.start) + k * double(ray.step);
            for (int i = 0; i < 2; ++i) place[others[i]] = double(ray.place[i]) + k * double(ray.rate[i]);
            const Dual depth = interpolated(place, 0) * Dual{double(ray.length), 0};
            const Dual behind = transmittance * exponential(Dual{} - depth);
            for (int c = 1; c < kChannels4; ++c)
                sum[std::size_t(c)] = sum[std::size_t(c)] + (transmittance - behind) * interpolated(place, c);
            transmittance = behind;
            if (transmittance.value < kLeastTransmittance) break;
        }
        sum[0] = transmittance;
        return sum;
    }
};

/// Bricks at random places, voxels of them at random; colours and extinctions uniform, so that rays see several bricks.
Volume randomVolume(const Index3& dims, double extinction, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::vector<MaskedBrick> bricks;
    for (int x = 0; x < dims.x; x += 8)
        for (int y = 0; y < dims.y; y += 8)
            for (int z = 0; z < dims.z; z += 8) {
                if (uniform(random) < 0.4f) continue;
                MaskedBrick brick{{x, y, z}, {}};
                for (std::uint64_t& word : brick.mask)
                    for (int bit = 0; bit < 64; ++bit)
                        if (uniform(random) < 0.8f) word |= std::uint64_t(1) << bit;
                bricks.push_back(brick);
            }
    Volume volume{compositeLayout(dims, bricks), {}};
    volume.voxels.resize(volume.layout.voxelCount());
    for (std::size_t b = 1; b < volume.layout.brickCount(); ++b)
        for (int i = 0; i < 512; ++i) {
            CompositeVoxel voxel{float(extinction) * uniform(random), uniform(random), uniform(random),
                                 uniform(random)};
            if (isSet(volume.layout.masks[b], i >> 6, i >> 3 & 7, i & 7))
                volume.voxels[b * 512 + std::size_t(i)] = voxel;
        }
    return volume;
}

/// Numbers of either sign in all voxels that are kept.
std::vector<CompositeVoxel> randomChange(const CompositeLayout& layout, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(-1, 1);
    std::vector<CompositeVoxel> change(layout.voxelCount());
    for (std::size_t b = 1; b < layout.brickCount(); ++b)
        for (int i = 0; i < 512; ++i)
            if (isSet(layout.masks[b], i >> 6, i >> 3 & 7, i & 7))
                change[b * 512 + std::size_t(i)] = {uniform(random), uniform(random), uniform(random), uniform(random)};
    return change;
}

struct Rays {
    std::string name;
    std::vector<CompositeRay> rays;
};

/// Rays towards points near the middle, from all around a direction, in the order of their axes.
Rays raysFrom(const std::string& name, const CompositeLayout& layout, const Vec3& from, int perSlice, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-0.55, 0.55);
    std::vector<CompositeRay> rays;
    const Vec3 middle(layout.dims.x * 0.5, layout.dims.y * 0.5, layout.dims.z * 0.5);
    const Vec3 origin = middle + from * double(layout.dims.x);
    for (int n = 0; n < 300; ++n) {
        const Vec3 target = middle + Vec3(uniform(random) * layout.dims.x, uniform(random) * layout.dims.y,
                                          uniform(random) * layout.dims.z);
        rays.push_back(compositeRay(layout, {origin, (target - origin).normalized()}, perSlice));
    }
    std::stable_sort(rays.begin(), rays.end(), [](const auto& a, const auto& b) { return a.axis < b.axis; });
    return {name, rays};
}

/// Along all axes in both senses, along a diagonal where all three axes are major ones of some rays, and from within.
std::vector<Rays> manyRays(const CompositeLayout& layout, int perSlice) {
    const std::pair<const char*, Vec3> from[] = {
        {"x", {-3, 0.1, 0.2}}, {"-x", {3, 0.3, 0.1}}, {"y", {0.1, -3, 0.2}},      {"-y", {0.2, 3, 0.1}},
        {"z", {0.2, 0.1, -3}}, {"-z", {0.3, 0.2, 3}}, {"mixed", {1.5, 1.4, 1.6}}, {"within", {0.1, 0.05, 0.2}}};
    std::vector<Rays> all;
    for (const auto& [name, place] : from) all.push_back(raysFrom(name, layout, place, perSlice, 5));
    return all;
}

/// Derivatives of a loss that is linear in what the rays see: y as given.
RayLoss linearLoss(const std::vector<RayColor>& y) {
    return [&y](std::size_t first, std::size_t count, const RayColor*, RayColor* derivatives) {
        std::copy_n(y.begin() + std::ptrdiff_t(first), count, derivatives);
    };
}

std::vector<RayColor> randomDerivatives(std::size_t count) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(-1, 1);
    std::vector<RayColor> y(count);
    for (RayColor& color : y) color = {uniform(random), uniform(random), uniform(random), uniform(random)};
    return y;
}

std::vector<CompositeVoxel> gradientOf(const Volume& volume, const std::vector<CompositeRay>& rays,
                                       const std::vector<RayColor>& y) {
    std::vector<CompositeVoxel> gradient(volume.voxels.size());
    CompositeTape tape;
    compositeGradient(volume.layout, volume.voxels.data(), rays, linearLoss(y), tape, gradient.data());
    return gradient;
}

std::vector<RayColor> composited(const Volume& volume, const std::vector<CompositeRay>& rays) {
    std::vector<RayColor> colors(rays.size());
    composite(volume.layout, volume.voxels.data(), rays.data(), rays.size(), colors.data());
    return colors;
}

/// One brick with all voxels the same.
Volume fullVolume(const CompositeVoxel& value, const Index3& dims = {8, 8, 8}) {
    std::vector<MaskedBrick> bricks;
    VoxelMask all;
    all.fill(~std::uint64_t(0));
    for (int x = 0; x < dims.x; x += 8)
        for (int y = 0; y < dims.y; y += 8)
            for (int z = 0; z < dims.z; z += 8) bricks.push_back({{x, y, z}, all});
    Volume volume{compositeLayout(dims, bricks), {}};
    volume.voxels.assign(volume.layout.voxelCount(), value);
    std::fill_n(volume.voxels.begin(), 512, CompositeVoxel{});
    return volume;
}

}  // namespace

// A ray through the middle of a single voxel of extinction σ: linear interpolation makes a tent of area σ. One sample
// in each slice meets its tip, two also its flanks: both sum the tent exactly, so that T = exp(−σ) to rounding, and
// where colour is the same everywhere C = (1 − T) c.
TEST(Composite, OneTranslucentVoxel) {
    for (const int perSlice : {1, 2, 4})
        for (int axis = 0; axis < 3; ++axis) {
            Volume volume = fullVolume({0, 0.2f, 0.4f, 0.8f});
            volume.voxels[volume.layout.voxel({3, 4, 5})].extinction = 0.7f;
            Ray ray{Vec3(3, 4, 5), Vec3(0)};
            ray.origin[axis] = -20;
            ray.direction[axis] = 1;
            const CompositeRay line = compositeRay(volume.layout, ray, perSlice);
            const RayColor color = composited(volume, {line})[0];
            EXPECT_NEAR(color.transmittance, std::exp(-0.7), 2e-6);
            EXPECT_NEAR(color.red, 0.2 * (1 - std::exp(-0.7)), 2e-6);
            EXPECT_NEAR(color.blue, 0.8 * (1 - std::exp(-0.7)), 2e-6);
        }
}

// A slab of extinction σ and thickness d, seen at an angle: T = exp(−σ d / cos). The slab's faces are flanks of a
// voxel's width, whose area samples at slices sum exactly; colour is the same in all of it, and the flanks' samples,
// partly before the slab, see less of it, which is why only T is exact. C differs by no more than the part of the light
// that the two flanks' samples give, if colours were 0 outside: here they are kept everywhere, so C = (1 − T) c as
// well.
TEST(Composite, SlabAtAnAngle) {
    for (const int perSlice : {1, 2, 3}) {
        Volume volume = fullVolume({0, 0.5f, 0.25f, 1}, {24, 24, 24});
        for (int x = 9; x < 15; ++x)
            for (int y = 0; y < 24; ++y)
                for (int z = 0; z < 24; ++z) volume.voxels[volume.layout.voxel({x, y, z})].extinction = 0.3f;
        const Vec3 direction = Vec3(1, 0.3, -0.4).normalized();
        const CompositeRay line =
            compositeRay(volume.layout, {Vec3(11.5, 11.2, 12.7) - direction * 50.0, direction}, perSlice);
        const RayColor color = composited(volume, {line})[0];
        const double expected = std::exp(-0.3 * 6 / direction.x);
        EXPECT_NEAR(color.transmittance, expected, 3e-6);
        EXPECT_NEAR(color.red, 0.5 * (1 - expected), 3e-6);
    }
}

// Nothing behind the camera is seen: of a block only the half before a camera in its middle.
TEST(Composite, FromWithin) {
    const Volume volume = fullVolume({0.1f, 1, 1, 1}, {32, 32, 32});
    for (const double sense : {1.0, -1.0}) {
        const CompositeRay line = compositeRay(volume.layout, {Vec3(15.75, 16, 16), Vec3(sense, 0, 0)}, 2);
        // Samples at 16, 16.5 ... 31, or 15.5, 15 ... 0, and one more half a voxel outside, of half the extinction.
        const double samples = sense > 0 ? 31 + 0.5 : 32 + 0.5;
        EXPECT_NEAR(composited(volume, {line})[0].transmittance, std::exp(-0.1 * 0.5 * samples), 1e-5);
    }
}

// Float against double: a few hundred samples, each rounded to 6e-8, at places rounded to 4e-6 voxels.
TEST(Composite, LikeItsPlainTwin) {
    const Volume volume = randomVolume({40, 32, 48}, 0.2, 3);
    const std::vector<CompositeVoxel> none(volume.voxels.size());
    const Twin twin{volume.layout, volume.voxels, none};
    test::forEachInstructionSet([&] {
        for (const int perSlice : {1, 2, 3})
            for (const Rays& rays : manyRays(volume.layout, perSlice)) {
                SCOPED_TRACE(rays.name);
                const std::vector<RayColor> colors = composited(volume, rays.rays);
                double worst = 0;
                for (std::size_t r = 0; r < rays.rays.size(); ++r) {
                    const auto expected = twin.composited(rays.rays[r]);
                    for (int c = 0; c < kChannels4; ++c)
                        worst = std::max(worst, std::abs(channelOf(colors[r], c) - expected[std::size_t(c)].value));
                }
                EXPECT_LT(worst, 2e-5);
            }
    });
}

// <J dx, y> = <dx, Jᵀ y>: J by the twin's own derivative in double, Jᵀ by the kernels. The products are sums of some
// 10000 terms of either sign; relative to their Euclidean size.
TEST(Composite, DerivativeIsTheAdjoint) {
    const Volume volume = randomVolume({40, 32, 48}, 0.2, 3);
    const std::vector<CompositeVoxel> change = randomChange(volume.layout, 7);
    const Twin twin{volume.layout, volume.voxels, change};
    test::forEachInstructionSet([&] {
        for (const int perSlice : {1, 2, 3})
            for (const Rays& rays : manyRays(volume.layout, perSlice)) {
                SCOPED_TRACE(rays.name);
                const std::vector<RayColor> y = randomDerivatives(rays.rays.size());
                const std::vector<CompositeVoxel> gradient = gradientOf(volume, rays.rays, y);
                double forward = 0, adjoint = 0, size = 0;
                for (std::size_t r = 0; r < rays.rays.size(); ++r) {
                    const auto moved = twin.composited(rays.rays[r]);
                    for (int c = 0; c < kChannels4; ++c) {
                        const double term = moved[std::size_t(c)].change * channelOf(y[r], c);
                        forward += term;
                        size += term * term;
                    }
                }
                for (std::size_t i = 512; i < gradient.size(); ++i)
                    for (int c = 0; c < kChannels4; ++c)
                        adjoint += double(channelOf(gradient[i], c)) * channelOf(change[i], c);
                ASSERT_GT(size, 0);
                EXPECT_NEAR(adjoint, forward, 1e-5 * std::sqrt(size));
            }
    });
}

// What samples are spread by is the transpose of what they are interpolated by: with A the latter, x·AᵀAx = |Ax|².
TEST(Composite, SpreadIsTheTransposeOfSampling) {
    const Volume volume = randomVolume({40, 32, 48}, 0.02, 3);
    for (const int perSlice : {1, 2})
        for (const Rays& rays : manyRays(volume.layout, perSlice)) {
            SCOPED_TRACE(rays.name + ", " + std::to_string(perSlice) + " a slice");
            std::vector<CompositeVoxel> sums(volume.voxels.size());
            std::vector<double> squares(rays.rays.size());
            CompositeTape tape;
            for (int c = 0; c < kChannels4; ++c) {
                const auto rule = [&](std::size_t r, const RaySamples& samples, SampleShare* shares) {
                    for (std::size_t i = 0; i < samples.count; ++i) {
                        const float value = channelOf(samples.samples[i], c);
                        shares[i] = c == 0 ? SampleShare{value, 0} : SampleShare{0, value};
                        squares[r] += double(value) * value;
                    }
                    return std::array<float, 3>{float(c == 1), float(c == 2), float(c == 3)};
                };
                compositeSpread(volume.layout, volume.voxels.data(), rays.rays, rule, tape, sums.data());
            }
            double back = 0, forth = 0;
            for (const double square : squares) forth += square;
            for (std::size_t i = 512; i < sums.size(); ++i)
                for (int c = 0; c < kChannels4; ++c)
                    back += double(channelOf(sums[i], c)) * channelOf(volume.voxels[i], c);
            ASSERT_GT(forth, 100);
            EXPECT_NEAR(back / forth, 1, 1e-6);  // sums of floats of one sign
        }
}

// Of single voxels: central differences of the twin in double, steps small enough (1e-4) that their own error is 1e-8.
TEST(Composite, DerivativeLikeDifferences) {
    const Volume volume = randomVolume({24, 24, 24}, 0.2, 3);
    const Rays rays = raysFrom("mixed", volume.layout, {1.5, 1.4, 1.6}, 2, 5);
    const std::vector<RayColor> y = randomDerivatives(rays.rays.size());
    const std::vector<CompositeVoxel> gradient = gradientOf(volume, rays.rays, y), none(volume.voxels.size());
    const auto loss = [&](const std::vector<CompositeVoxel>& voxels) {
        const Twin twin{volume.layout, voxels, none};
        double sum = 0;
        for (std::size_t r = 0; r < rays.rays.size(); ++r) {
            const auto seen = twin.composited(rays.rays[r]);
            for (int c = 0; c < kChannels4; ++c) sum += seen[std::size_t(c)].value * channelOf(y[r], c);
        }
        return sum;
    };
    std::mt19937 random(1);
    for (int n = 0; n < 40; ++n) {
        const std::size_t i = 512 + random() % (volume.voxels.size() - 512);
        const int c = int(random() % 4);
        std::vector<CompositeVoxel> more = volume.voxels, less = volume.voxels;
        (&more[i].extinction)[c] += 1e-4f;
        (&less[i].extinction)[c] -= 1e-4f;
        const double step = double(channelOf(more[i], c)) - channelOf(less[i], c);
        const double expected = (loss(more) - loss(less)) / step;
        EXPECT_NEAR(channelOf(gradient[i], c), expected, 1e-3 * std::max(0.01, std::abs(expected))) << i << " " << c;
    }
}

// One thread and many: the same bits.
TEST(Composite, SameBitsForAnyThreads) {
    const Volume volume = randomVolume({40, 32, 48}, 0.2, 3);
    const Rays rays = raysFrom("mixed", volume.layout, {1.5, 1.4, 1.6}, 2, 5);
    const std::vector<RayColor> y = randomDerivatives(rays.rays.size());
    std::vector<std::vector<CompositeVoxel>> gradients;
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        gradients.push_back(gradientOf(volume, rays.rays, y));
    }
    for (const auto& gradient : gradients)
        EXPECT_EQ(0, std::memcmp(gradient.data() + 512, gradients[0].data() + 512,
                                 (gradient.size() - 512) * sizeof(CompositeVoxel)));
}

TEST(Composite, RaysInTheOrderOfTheirAxes) {
    const Volume volume = fullVolume({0.1f, 1, 1, 1});
    const CompositeRay x = compositeRay(volume.layout, {Vec3(-9, 4, 4), Vec3(1, 0, 0)}, 1);
    const CompositeRay z = compositeRay(volume.layout, {Vec3(4, 4, -9), Vec3(0, 0, 1)}, 1);
    EXPECT_THROW(gradientOf(volume, {z, x}, randomDerivatives(2)), InvalidArgument);
}
