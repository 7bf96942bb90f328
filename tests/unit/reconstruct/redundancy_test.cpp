#include "raysweep/reconstruct/redundancy.h"

#include "raysweep/core/types.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace raysweep;

namespace {

std::vector<double> evenAngles(int count, double arc) {
    std::vector<double> angles;
    for (int n = 0; n < count; ++n) angles.push_back(0.3 + arc * n / count);
    return angles;
}

/// The weights of all rays along a line, by the part of the turn that their views stand for: 1 if each line counts as
/// one. Rays lie between the lines of a view; the sum over a small range of directions stands for one line.
double weightOfLines(const Redundancy& weights, BeamShape beam, const std::vector<double>& angles, double direction,
                     double q) {
    constexpr double kRange = 0.2;
    double sum = 0;
    for (std::size_t n = 0; n < angles.size(); ++n)
        for (const double side : {1.0, -1.0}) {
            const double turned = beam == BeamShape::cone ? side * q : 0;
            const double line = angles[n] + turned - (side > 0 ? 0 : kPi);
            const double away = std::remainder(line - direction, 2 * kPi);
            if (std::abs(away) < 0.5 * kRange) sum += weights.scan().weights[n] * weights.weight(n, side * q);
        }
    return sum / kRange;
}

void expectOne(BeamShape beam, const std::vector<double>& angles, const std::vector<DetectorReach>& reaches,
               double furthest, double tolerance) {
    const Redundancy weights(beam, angles, reaches);
    for (double direction = 0.05; direction < 2 * kPi; direction += 0.31)
        for (double q = 0.01; q < furthest; q += 0.0173) {
            EXPECT_NEAR(weightOfLines(weights, beam, angles, direction, q), 1, tolerance) << direction << " " << q;
            EXPECT_EQ(weights.missed(q), 0) << q;
        }
}

}  // namespace

// 2000 views stand for 0.2 radians by 64 of them or one more or less: 1.6 %.
TEST(Redundancy, EachLineCountsAsOne) {
    constexpr int kViews = 2000;
    const DetectorReach centred{-0.2, 0.2}, aside{-0.05, 0.2}, otherSide{-0.2, 0.05};
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        const std::vector<double> turn = evenAngles(kViews, 2 * kPi);
        for (const DetectorReach& reach : {centred, aside, otherSide})
            expectOne(beam, turn, std::vector<DetectorReach>(kViews, reach), 0.19, 0.018);
        expectOne(beam, evenAngles(kViews, 2.3 * kPi), std::vector<DetectorReach>(kViews, aside), 0.19, 0.03);
        expectOne(beam, evenAngles(kViews, kPi + 0.5), std::vector<DetectorReach>(kViews, centred), 0.19, 0.03);
        std::vector<DetectorReach> sides;
        for (int n = 0; n < kViews; ++n) sides.push_back(n % 2 ? aside : otherSide);
        expectOne(beam, turn, sides, 0.19, 0.018);
    }
}

// A detector that is moved aside between exposures from one angle: weights are finite, however many there are, and no
// line is missing that one of them measures.
TEST(Redundancy, EachLineCountsAsOneOnTilesSideBySide) {
    constexpr int kAngles = 700;
    const std::vector<DetectorReach> three{{-0.2, -0.05}, {-0.08, 0.08}, {0.05, 0.2}};
    std::vector<DetectorReach> nine;
    for (int i = 0; i < 9; ++i) nine.push_back({-0.2 + 0.04 * i, -0.12 + 0.04 * i});
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone})
        for (const auto& tiles : {three, nine}) {
            std::vector<double> angles;
            std::vector<DetectorReach> reaches;
            for (const double angle : evenAngles(kAngles, 2 * kPi))
                for (const DetectorReach& tile : tiles) {
                    angles.push_back(angle);
                    reaches.push_back(tile);
                }
            // 700 angles stand for 0.2 radians by 22 of them or one more or less: 4.5 %.
            expectOne(beam, angles, reaches, 0.19, 0.046);
            const Redundancy weights(beam, angles, reaches);
            for (std::size_t n = 0; n < tiles.size(); ++n)
                for (double q = -0.21; q < 0.21; q += 0.003) {
                    const double weight = weights.weight(n, q);
                    EXPECT_TRUE(weight >= 0 && weight < 1e3) << n << " " << q << " " << weight;
                }
        }
}

// A ray at the very edge of the detector is too little for the mean to know of; it was infinite, or NaN.
TEST(Redundancy, WeightsAreFiniteUpToTheEdge) {
    const Redundancy weights(BeamShape::cone, evenAngles(360, 2 * kPi), std::vector<DetectorReach>(360, {-0.05, 0.2}));
    for (double away = 1e-3; away > 1e-320; away *= 0.3)
        for (const double q : {0.2 - away, -0.05 + away}) {
            const double weight = weights.weight(7, q);
            EXPECT_TRUE(weight >= 0 && weight <= 2) << q << " " << weight;
        }
}

TEST(Redundancy, SymmetricFullTurnsWeighOneHalfAndShortScansOneWhereNothingIsMeasuredTwice) {
    const std::vector<double> turn = evenAngles(360, 2 * kPi), shortScan = evenAngles(220, 220 * kPi / 180);
    const Redundancy full(BeamShape::cone, turn, std::vector<DetectorReach>(360, {-0.2, 0.2}));
    const Redundancy half(BeamShape::cone, shortScan, std::vector<DetectorReach>(220, {-0.2, 0.2}));
    for (const double q : {-0.19, -0.05, 0.0, 0.1, 0.199}) {
        EXPECT_NEAR(full.weight(77, q), 0.5, 1e-12);
        EXPECT_NEAR(half.weight(110, q), 1, 1e-12);
    }
}

TEST(Redundancy, TellsWhatNoRayRunsAlong) {
    const std::vector<double> turn = evenAngles(360, 2 * kPi), part = evenAngles(240, 240 * kPi / 180);
    const Redundancy hole(BeamShape::cone, turn, std::vector<DetectorReach>(360, {0.05, 0.2}));
    EXPECT_EQ(hole.missed(0.01), 1);
    EXPECT_EQ(hole.missed(0.1), 0);
    EXPECT_EQ(hole.cut(0.01), 1);
    EXPECT_EQ(hole.cut(0.1), 0);
    // What no view looks along is missed, but not cut off.
    const Redundancy few(BeamShape::parallel, evenAngles(60, kPi / 3), std::vector<DetectorReach>(60, {-0.2, 0.2}));
    EXPECT_GT(few.missed(0.1), 0.6);
    EXPECT_EQ(few.cut(0.1), 0);
    EXPECT_NEAR(few.cut(0.21), 1.0 / 3, 0.012) << "of all directions";
    const Redundancy aside(BeamShape::parallel, part, std::vector<DetectorReach>(240, {-0.05, 0.2}));
    EXPECT_EQ(aside.missed(0.02), 0);
    EXPECT_NEAR(aside.missed(0.15), 1.0 / 3, 0.006) << "a third of the turn, in steps of 2 degrees";
}
