// Integers of given widths: what rounding does, and what it must not do.
#include "cube4/fixed_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "cube4/free_run.h"
#include "cube4/illumination.h"
#include "cube4/replay.h"
#include "raysweep/core/error.h"
#include "support/expect_error.h"

using namespace raysweep;
using namespace raysweep::cube4;

namespace {

FixedPoint withRounding(Rounding rounding) {
    NumberFormat format;
    format.rounding = rounding;
    return FixedPoint(format);
}

/// A random medium of 16^3 voxels, lit from all sides and by a source in each voxel.
DenseMedium randomMedium(float albedo) {
    DenseMedium medium;
    medium.box.high = Index3(16);
    medium.box.worldFromIndex.makeIdentity();
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (std::size_t i = 0; i < medium.box.voxels(); ++i) {
        medium.extinction.push_back(0.4f * uniform(random));
        medium.albedo.push_back(albedo);
        medium.source.push_back(uniform(random));
    }
    return medium;
}

/// RMS of the deposit in a format, relative to floats.
double rmsOf(int bits, Rounding rounding) {
    const DenseMedium medium = randomMedium(0.9f);
    IlluminationSetup setup;
    setup.pipelines = 4;
    Illumination exact(medium, setup);
    SceneLight light;
    light.sweeps = 20;
    const FreeRun run = runFreely(exact, medium.box, sumOf(medium.source), light);
    NumberFormat format;
    format.energy = bits;
    format.scalar = 16;
    format.part = 20;
    format.rounding = rounding;
    setup.format = format;
    setup.largestPower = exact.largestPower();
    Illumination rounded(medium, setup);
    repeat(run, rounded);
    return compareFields(rounded.deposit(), exact.deposit(), medium.box).rms;
}

}  // namespace

TEST(Cube4FixedPoint, RoundsAsItIsTold) {
    const FixedPoint truncate = withRounding(Rounding::truncate), nearest = withRounding(Rounding::nearest),
                     stochastic = withRounding(Rounding::stochastic);
    for (const std::int64_t value : {-9, -8, -5, -4, -3, 0, 3, 4, 5, 11, 12}) {
        EXPECT_EQ(truncate.shifted(value, 3), std::int64_t(std::floor(double(value) / 8))) << value;
        EXPECT_EQ(nearest.shifted(value, 3), std::int64_t(std::floor(double(value) / 8 + 0.5))) << value;
        double sum = 0;
        constexpr int kTries = 100000;
        for (int n = 0; n < kTries; ++n) {
            const std::int64_t rounded = stochastic.shifted(value, 3);
            EXPECT_LE(std::abs(double(rounded) - double(value) / 8), 1);
            sum += double(rounded);
        }
        // Five standard deviations of a mean of numbers that are off by at most half a unit.
        EXPECT_NEAR(sum / kTries, double(value) / 8, 5 * 0.5 / std::sqrt(double(kTries))) << value;
    }
}

TEST(Cube4FixedPoint, InterpolatingTheSameGivesTheSame) {
    const FixedPoint arithmetic = withRounding(Rounding::nearest);
    for (int part = 0; part <= 8; ++part) {
        Between<FixedPoint::Weight> weights;
        weights.high = arithmetic.weight(part / 8.0);
        weights.low = arithmetic.weight(1) - weights.high;
        for (const std::int64_t value : {0, 1, 77, 65535}) EXPECT_EQ(arithmetic.mix(weights, value, value), value);
    }
    EXPECT_EQ(arithmetic.partOf(12345, arithmetic.one()), 12345);
    EXPECT_EQ(arithmetic.add(65535, 1), 65535);  // saturates
}

// What a black medium takes from rays it has, to the last unit, whatever the rounding: rays, U and D share a unit.
TEST(Cube4FixedPoint, NearestExchangeLosesNothing) {
    for (const Rounding rounding : {Rounding::truncate, Rounding::nearest, Rounding::stochastic}) {
        DenseMedium medium = randomMedium(0);
        medium.unshot = medium.source;
        medium.source.clear();
        IlluminationSetup setup;
        setup.pipelines = 4;
        NumberFormat format;
        format.energy = 14;
        format.rounding = rounding;
        setup.format = format;
        setup.largestPower = 16383;  // so that a unit is 1
        for (float& power : medium.unshot) power = std::floor(600 * power);
        Illumination machine(medium, setup);
        double balance = sumOf(medium.unshot);
        for (const Vec3& direction : {Vec3(1, 0.3, -0.7), Vec3(-0.2, 1, 0.4), Vec3(0.1, -0.9, -1)}) {
            const FrontPower power = machine.sweep({{direction, 0.3, 0.6, 500}}, false).front();
            balance += power.entered - power.escaped;
        }
        EXPECT_EQ(balance, sumOf(machine.unshot()) + sumOf(machine.deposit()));
        EXPECT_GT(sumOf(machine.deposit()), 1000);
    }
}

// A bit more halves the error. Found, 10 to 16 bits: 2.05 a bit; at 12 bits 5.5e-4, truncating 7.2e-3, at
// random 4.7e-4.
TEST(Cube4FixedPoint, ErrorHalvesWithEachBit) {
    const double at10 = rmsOf(10, Rounding::nearest), at16 = rmsOf(16, Rounding::nearest);
    EXPECT_NEAR(std::pow(at10 / at16, 1.0 / 6), 2, 0.1);
    // What is always rounded down is lost.
    EXPECT_GT(rmsOf(12, Rounding::truncate), 10 * rmsOf(12, Rounding::nearest));
}

TEST(Cube4FixedPoint, SaysWhatAWidthCannotHold) {
    const DenseMedium medium = randomMedium(0.9f);
    IlluminationSetup setup;
    setup.format = NumberFormat{};
    setup.largestPower = 0.25;
    test::expectError<InvalidArgument>([&] { Illumination machine(medium, setup); },
                                       "energy words of 16 bits hold powers up to 0.25");
    setup.format->energy = 3;
    EXPECT_EQ(test::errorOf(setup), "energy 3: must be 4 to 31 bits");
    setup.format->energy = 16;
    setup.format->sum = 49;
    EXPECT_EQ(test::errorOf(setup), "sum 49: must be 4 to 48 bits");
    setup = {};
    setup.pipelines = 0;
    EXPECT_EQ(test::errorOf(setup), "pipelines 0: must be at least 1");
}
