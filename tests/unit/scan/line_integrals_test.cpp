// Counts become line integrals; pixels that do not measure are found, and filled in only where asked for.
#include "raysweep/scan/line_integrals.h"

#include "raysweep/scan/scan.h"

#include <limits>
#include <random>

#include "unit/scan/ct_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

std::size_t unmeasured(const Projections& projections) {
    std::size_t count = 0;
    for (const float value : projections.values) count += std::isnan(value);
    return count;
}

/// Rows of different discs, with noise of standard deviation `noise`.
Projections severalRows(int rows, const std::vector<double>& angles, double noise) {
    Projections all(256, rows, int(angles.size()));
    std::mt19937 random(3);
    std::normal_distribution<double> normal(0, 1);
    for (int y = 0; y < rows; ++y) {
        std::vector<Disc> discs = lopsidedBody();
        discs[0].radius = 80 - 3 * y;
        const Projections one = sinogram(discs, 256, 127.5, angles);
        for (int n = 0; n < all.views; ++n)
            for (int x = 0; x < 256; ++x) all.view(n)[y * 256 + x] = float(one.view(n)[x] + noise * normal(random));
    }
    return all;
}

void setPixel(Projections& projections, int x, int y, float value) {
    for (int n = 0; n < projections.views; ++n) projections.view(n)[y * projections.width + x] = value;
}

}  // namespace

TEST(LineIntegrals, CountsOfPixelsThatDifferGiveWhatTheyWereMadeFrom) {
    const Projections expected = sinogram(lopsidedBody(), 200, 90, anglesFrom(0, 30, 6));
    std::vector<float> flat(200), dark(200);
    Projections counts = expected;
    for (int x = 0; x < 200; ++x) {
        dark[std::size_t(x)] = 90 + float(x % 7);
        flat[std::size_t(x)] = 20000 + 3000 * std::sin(0.1f * float(x));
        for (int n = 0; n < counts.views; ++n)
            counts.view(n)[x] =
                dark[std::size_t(x)] + (flat[std::size_t(x)] - dark[std::size_t(x)]) * std::exp(-expected.view(n)[x]);
    }
    const LineIntegrals result = lineIntegrals(counts, flat, dark);
    EXPECT_EQ(result.deadPixels, 0u);
    EXPECT_EQ(countRays(result.projections).saturated, 0u);
    for (std::size_t p = 0; p < expected.values.size(); ++p)
        EXPECT_NEAR(result.projections.values[p], expected.values[p], 1.3e-7);  // rounding of floats; found: 1.2e-7
}

TEST(LineIntegrals, TooFewCountsSayAtLeast) {
    Projections counts(5, 1, 1);
    counts.values = {100, 50, -3, 101, 1100};  // dark 100, flat 10100
    LineIntegralOptions options;
    options.minimumTransmission = 1e-3;
    const LineIntegrals result =
        lineIntegrals(counts, std::vector<float>(5, 10100), std::vector<float>(5, 100), options);
    const float floor = result.projections.saturation;
    EXPECT_FLOAT_EQ(floor, float(-std::log(1e-3)));
    EXPECT_EQ(countRays(result.projections).saturated, 4u);
    for (int x = 0; x < 4; ++x) EXPECT_EQ(result.projections.values[std::size_t(x)], floor);
    EXPECT_FLOAT_EQ(result.projections.values[4], float(-std::log(0.1)));
}

TEST(LineIntegrals, BoundsTakeUpNoMemoryWhereThereAreNone) {
    Projections counts(5, 1, 1);
    counts.values = {100, 150, 200, 300, 400};
    const LineIntegrals result = lineIntegrals(counts, std::vector<float>(5, 400), std::vector<float>(5, 0));
    EXPECT_EQ(result.projections.bounds.capacity(), 0u);
}

TEST(LineIntegrals, CountsSayAtLeastOrAtMostWhereTheyEnd) {
    Projections counts(7, 1, 1);
    counts.values = {100, 101, 102, 4000, 4095, 12000, -12000};  // dark 100, flat 1100
    LineIntegralOptions options;
    options.leastCount = 1;
    options.saturatedAbove = 4095;
    const LineIntegrals result =
        lineIntegrals(counts, std::vector<float>(7, 1100), std::vector<float>(7, 100), options);
    const Projections& p = result.projections;
    for (const std::size_t few : {0, 1}) {
        EXPECT_FLOAT_EQ(p.values[few], float(std::log(1000.0))) << "not as much as minimumTransmission would be";
        EXPECT_EQ(p.boundOf(few), RayBound::atLeast);
    }
    EXPECT_EQ(p.boundOf(2), RayBound::none);
    EXPECT_EQ(p.boundOf(3), RayBound::none);
    EXPECT_EQ(p.boundOf(4), RayBound::atMost);
    EXPECT_FLOAT_EQ(p.values[4], float(-std::log(3.995)));
    EXPECT_TRUE(std::isnan(p.values[5]) && std::isnan(p.values[6])) << "ten times the beam, and as much below nothing";
    EXPECT_EQ(result.implausible, 2u);
    const RayCounts rays = countRays(p);
    EXPECT_EQ(rays.saturated, 2u);
    EXPECT_EQ(rays.overexposed, 1u);
    EXPECT_EQ(rays.notMeasured, 2u);
}

TEST(LineIntegrals, DeadPixelsAndBrokenCountsAreNotMeasured) {
    Projections counts(6, 1, 2);
    counts.values.assign(12, 5000);
    counts.values[5] = kNaN;
    const std::vector<float> flat = {10000, 100, 50, 300, kNaN, 10000};
    const LineIntegrals result = lineIntegrals(counts, flat, std::vector<float>(6, 100));
    EXPECT_EQ(result.deadPixels, 4u) << "no gain, negative gain, 2 % of the others' gain, NaN";
    for (int n = 0; n < 2; ++n) {
        EXPECT_FALSE(std::isnan(result.projections.view(n)[0]));
        for (int x = 1; x < 5; ++x) EXPECT_TRUE(std::isnan(result.projections.view(n)[x])) << x;
    }
    EXPECT_TRUE(std::isnan(result.projections.view(0)[5]));
    EXPECT_FALSE(std::isnan(result.projections.view(1)[5]));
}

TEST(LineIntegrals, FramesThatDoNotFitAreRefused) {
    const Projections counts(4, 1, 2);
    const std::vector<float> bright(4, 1000), black(4, 10);
    expectError<InvalidArgument>([&] { lineIntegrals(counts, std::vector<float>(3, 1), black); },
                                 "the flat frame has 3 values, but the detector has 4x1 pixels");
    expectError<InvalidArgument>([&] { lineIntegrals(counts, bright, {}); }, "the dark frame has 0 values");
    expectError<InvalidArgument>([&] { lineIntegrals(counts, black, bright); }, "are the frames swapped?");
    LineIntegralOptions options;
    options.minimumTransmission = 0;
    expectError<InvalidArgument>([&] { lineIntegrals(counts, bright, black, options); }, "minimumTransmission 0");
    options = {};
    options.leastCount = -1;
    expectError<InvalidArgument>([&] { lineIntegrals(counts, bright, black, options); }, "leastCount -1");
    options = {};
    options.maximumTransmission = 1;
    expectError<InvalidArgument>([&] { lineIntegrals(counts, bright, black, options); }, "maximumTransmission 1");
    options = {};
    options.deadGain = 1;
    expectError<InvalidArgument>([&] { lineIntegrals(counts, bright, black, options); }, "deadGain 1");
}

TEST(DeadPixels, StuckAndHotOnesAreFound) {
    for (const double noise : {0.0, 0.02}) {
        Projections projections = severalRows(5, anglesFrom(0, 4, 45), noise);
        setPixel(projections, 120, 2, 0.9f);                                                         // stuck
        for (int n = 0; n < 45; ++n) projections.view(n)[3 * 256 + 150] += 3 + 0.1f * float(n % 3);  // hot
        EXPECT_EQ(markDeadPixels(projections), 2u) << "noise " << noise;
        EXPECT_EQ(unmeasured(projections), 2u * 45);
        EXPECT_TRUE(std::isnan(projections.view(7)[2 * 256 + 120]));
        EXPECT_TRUE(std::isnan(projections.view(7)[3 * 256 + 150]));
        EXPECT_EQ(markDeadPixels(projections), 0u) << "they are not found again";
    }
}

TEST(DeadPixels, HealthyDetectorsHaveNone) {
    for (const double noise : {0.0, 0.02})
        for (const int rows : {1, 4}) {
            Projections projections = severalRows(rows, anglesFrom(0, 4, 45), noise);
            EXPECT_EQ(markDeadPixels(projections), 0u) << "noise " << noise << ", rows " << rows;
        }
    // All views are the same: nothing varies, and that is no sign of death.
    Projections round = sinogram({{0, 0, 50, 0.02}}, 128, 63.5, anglesFrom(0, 4, 45));
    EXPECT_EQ(markDeadPixels(round), 0u);
    Projections few(16, 1, 3);
    setPixel(few, 5, 0, 100);
    EXPECT_EQ(markDeadPixels(few), 0u) << "three views prove nothing";
}

TEST(FillUnmeasured, RowsAreFilledInStraightLines) {
    Projections projections(8, 1, 1);
    projections.values = {kNaN, 2, kNaN, kNaN, 5, 1, kNaN, kNaN};
    EXPECT_EQ(fillUnmeasured(projections), 5u);
    const std::vector<float> expected = {2, 2, 3, 4, 5, 1, 1, 1};
    for (std::size_t x = 0; x < 8; ++x) EXPECT_FLOAT_EQ(projections.values[x], expected[x]) << x;
    EXPECT_EQ(fillUnmeasured(projections), 0u);
}

TEST(FillUnmeasured, EmptyRowsAreLikeTheNearestAndEmptyViewsRefused) {
    Projections projections(2, 4, 2);
    projections.values = {kNaN, kNaN, 1, 2, kNaN, kNaN, kNaN, kNaN, 1, 1, 1, 1, 1, 1, 1, 1};
    EXPECT_EQ(fillUnmeasured(projections), 6u);
    for (int y = 0; y < 4; ++y) {
        EXPECT_EQ(projections.view(0)[2 * y], 1.0f);
        EXPECT_EQ(projections.view(0)[2 * y + 1], 2.0f);
    }
    std::fill_n(projections.view(1), 8, kNaN);
    expectError<InvalidArgument>([&] { fillUnmeasured(projections); }, "nothing was measured in view 1");
}
