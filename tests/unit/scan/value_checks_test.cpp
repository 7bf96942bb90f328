// What values look like: broken pixels, counts that are given for line integrals, where a detector ends.
#include "raysweep/scan/value_checks.h"

#include "raysweep/scan/count_type.h"

#include <random>

#include "unit/scan/ct_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

Projections body() {
    return sinogram(lopsidedBody(), 256, 127.5, anglesFrom(0, 4, 45));
}

/// Counts of a beam of `bright`, with the noise of so many photons.
Projections countsOf(const Projections& integrals, double bright, double noise = 0) {
    Projections counts = integrals;
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0, noise);
    for (float& value : counts.values) value = float(std::round(bright * std::exp(-double(value)) + normal(random)));
    return counts;
}

}  // namespace

TEST(Implausible, OnlyWhatNoScanHasIsLeftOut) {
    for (const float hot : {1e30f, -1e30f, 3e38f, 1e7f}) {
        Projections projections = body();
        projections.view(7)[90] = hot;
        EXPECT_EQ(markImplausible(projections), 1u) << hot;
        EXPECT_TRUE(std::isnan(projections.view(7)[90])) << hot;
    }
    Projections plain = body();
    EXPECT_EQ(markImplausible(plain), 0u);
    for (float& value : plain.values) value *= 1e6f;  // in whatever unit
    EXPECT_EQ(markImplausible(plain), 0u);
    Projections bead(100, 100, 3);  // nothing but one pixel in 10,000, without noise
    for (int n = 0; n < 3; ++n) bead.view(n)[5050] = 2000;
    EXPECT_EQ(markImplausible(bead), 0u);
    Projections all(8, 1, 2);
    all.values.assign(16, 3e38f);
    EXPECT_EQ(markImplausible(all), 16u) << "beyond any scan";
}

TEST(Doubts, CountsAndTransmissionsAreBrightBesideTheObject) {
    EXPECT_TRUE(doubtsAbout(body()).empty());
    for (const double bright : {1.0, 4000.0}) {
        Projections counts = body();
        for (float& value : counts.values) value = float(bright * std::exp(-double(value)));
        const std::vector<std::string> doubts = doubtsAbout(counts);
        ASSERT_EQ(doubts.size(), 1u) << bright;
        EXPECT_TRUE(doubtsAbout(counts, true).empty()) << "they are not taken for what they are";
        EXPECT_NE(doubts[0].find(bright > 2 ? "as counts are" : "as transmissions are"), std::string::npos)
            << doubts[0];
    }
    // An object that is wider than the detector, and noise around nothing, are line integrals.
    EXPECT_TRUE(doubtsAbout(sinogram({{0, 0, 90, 0.01}}, 100, 49.5, anglesFrom(0, 4, 45))).empty());
    Projections noise = body();
    std::mt19937 random(3);
    std::normal_distribution<float> normal(0, 0.3f);
    for (float& value : noise.values) value += normal(random);
    EXPECT_TRUE(doubtsAbout(noise).empty()) << doubtsAbout(noise)[0];
}

TEST(Doubts, NegativeLineIntegralsBeyondTheNoiseAreSaid) {
    Projections projections = body();
    for (float& value : projections.values) value -= 0.3f;  // more was counted with the object than without
    const std::vector<std::string> doubts = doubtsAbout(projections);
    ASSERT_EQ(doubts.size(), 1u);
    EXPECT_NE(doubts[0].find("% of the line integrals are below"), std::string::npos) << doubts[0];
    EXPECT_EQ(doubtsAbout(projections, true), doubts);
}

TEST(FlatFromSides, IsWhatIsCountedBesideTheObject) {
    Projections counts = countsOf(body(), 30000, 170);
    const std::vector<float> flat = flatFromSides(counts);
    ASSERT_EQ(flat.size(), 256u);
    // 10 columns in 45 views: 170 / sqrt(450) = 8, three times that.
    EXPECT_NEAR(flat[0], 30000, 24);
    EXPECT_EQ(flat[0], flat[255]);
    expectError<InvalidArgument>(
        [] {
            flatFromSides(sinogram({{0, 0, 90, 0.01}}, 100, 49.5, anglesFrom(0, 4, 45)));
        },
        "flat: what is counted without object cannot be estimated");
}

TEST(ExposureLimit, IsWhereNumbersEnd) {
    Projections counts = countsOf(body(), 5000);
    const std::vector<float> flat(256, 5000);
    EXPECT_FALSE(exposureLimit(counts, SampleType::uint16, flat));
    Projections clipped = counts;
    for (float& value : clipped.values) value = std::min(value, 4095.0f);
    EXPECT_EQ(exposureLimit(clipped, SampleType::uint16, flat).value_or(0), 4095) << "of 12 bits";
    EXPECT_FALSE(exposureLimit(clipped, SampleType::float32, flat));
    EXPECT_FALSE(exposureLimit(clipped, SampleType::uint16, std::vector<float>(256, 4095))) << "the beam itself";
    counts.values[100] = 65535;
    EXPECT_EQ(exposureLimit(counts, SampleType::uint16, flat).value_or(0), 65535);
    counts.values[100] = 16383;
    EXPECT_FALSE(exposureLimit(counts, SampleType::uint16, flat)) << "a single one may be as large by chance";
}

TEST(CountType, CountsThatATypeCouldNotHoldAreKnown) {
    std::vector<float> counts = {100, -25436, 32767, -1};
    addWrapped(counts.data(), counts.size(), SampleType::int16);
    EXPECT_EQ(counts, (std::vector<float>{100, 40100, 32767, 65535}));
    addWrapped(counts.data(), counts.size(), SampleType::uint16);
    EXPECT_EQ(counts[0], 100);
    expectError<InvalidArgument>([] { requireCounts(-25436, SampleType::int16, "'x.h5'"); },
                                 "'x.h5': counts are as low as -25436, as those are that were stored as int16");
    EXPECT_NO_THROW(requireCounts(-300, SampleType::int16, ""));  // a camera that subtracts its dark frames
    EXPECT_NO_THROW(requireCounts(-25436, SampleType::int32, ""));
    EXPECT_NO_THROW(requireCounts(-25436, SampleType::float32, ""));
}
