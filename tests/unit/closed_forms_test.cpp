#include "support/closed_forms.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/core/types.h"
#include "support/blocks.h"

using namespace raysweep;
using namespace raysweep::test;

TEST(ClosedForms, ExponentialIntegralsAgreeWithAbramowitzAndStegun) {
    EXPECT_NEAR(exponentialIntegral(1, 0.01), 4.037929576538114, 1e-13);
    EXPECT_NEAR(exponentialIntegral(1, 0.5), 0.5597735947761608, 1e-14);
    EXPECT_NEAR(exponentialIntegral(1, 1.0), 0.2193839343955203, 1e-14);
    EXPECT_NEAR(exponentialIntegral(1, 1.0 + 1e-9), 0.2193839343955203 - 1e-9 * std::exp(-1.0), 1e-14);
    EXPECT_NEAR(exponentialIntegral(1, 2.0), 0.0489005107080611, 1e-14);
    EXPECT_NEAR(exponentialIntegral(1, 10.0), 4.156968929685324e-6, 1e-18);
    EXPECT_NEAR(exponentialIntegral(2, 0.5), 0.3266438623245530, 1e-14);
    EXPECT_NEAR(exponentialIntegral(3, 0.5), 0.2216043642751785, 1e-14);
    EXPECT_EQ(exponentialIntegral(3, 0.0), 0.5);
}

TEST(ClosedForms, GaussLegendreIntegratesPolynomialsExactly) {
    const Quadrature rule = gaussLegendre(8);
    for (int power = 0; power < 16; ++power) {
        double sum = 0;
        for (std::size_t i = 0; i < rule.points.size(); ++i) sum += rule.weights[i] * std::pow(rule.points[i], power);
        EXPECT_NEAR(sum, 1.0 / (power + 1), 1e-14) << "power " << power;
    }
}

TEST(ClosedForms, EscapeProbabilityHasItsLimitsAndItsDirectAverage) {
    EXPECT_NEAR(escapeProbability(0), 1.0, 1e-12);  // the faces of a cube cover the sphere
    // Thick voxel: p = <1/l> / tau, and <max|omega_i|> = 6/(4 pi) int int l^-4 over a face; compare two optical depths.
    EXPECT_NEAR(escapeProbability(100) * 100, escapeProbability(1e4) * 1e4, 1e-9);
    // The mean over a plain even grid of directions (z, azimuth), a different parametrisation; its own error is 1e-6.
    const int n = 1000;
    double mean = 0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const double z = (i + 0.5) / n, r = std::sqrt(1 - z * z), a = 0.5 * kPi * (j + 0.5) / n;
            const double tau = 1.7 / std::max(z, r * std::max(std::cos(a), std::sin(a)));
            mean += -std::expm1(-tau) / tau / (double(n) * n);
        }
    }
    EXPECT_NEAR(escapeProbability(1.7), mean, 2e-6);
}

TEST(ClosedForms, SlabSolverAgreesWithTheDiffuseTable) {
    for (const SlabReference& row : kDiffuseSlabs) {
        const SlabSolution slab = solveSlab(row.opticalThickness, row.albedo, SlabLight::Diffuse);
        const double total = slab.transmittance + slab.uncollidedTransmittance;
        EXPECT_NEAR(slab.reflectance, row.reflectance, kDiffuseSlabTolerance)
            << row.opticalThickness << " " << row.albedo;
        EXPECT_NEAR(total, row.transmittance, kDiffuseSlabTolerance) << row.opticalThickness << " " << row.albedo;
        EXPECT_TRUE(row.albedo < 1 || std::abs(slab.reflectance + total - 1) < 1e-9) << row.opticalThickness;
    }
}

TEST(ClosedForms, SlabSolverAgreesWithDisort) {
    for (const SlabReference& row : kBeamSlabs) {
        const SlabSolution slab = solveSlab(row.opticalThickness, row.albedo, SlabLight::Beam, kBeamCosine);
        EXPECT_NEAR(slab.reflectance, row.reflectance, kBeamSlabTolerance) << row.opticalThickness << " " << row.albedo;
        EXPECT_NEAR(slab.transmittance, row.transmittance, kBeamSlabTolerance)
            << row.opticalThickness << " " << row.albedo;
    }
}

// The H function is printed to 5e-5; an albedo of 1 reflects everything only when infinitely thick and is left out.
TEST(ClosedForms, ThickSlabReflectsAsChandrasekharsHalfSpace) {
    for (const ChandrasekharH& h : kChandrasekharH) {
        if (h.albedo == 1) continue;
        const double thickness = h.albedo < 0.95 ? 25 : 60;  // transmits less than 1e-5
        const SlabSolution slab = solveSlab(thickness, h.albedo, SlabLight::Beam, h.cosine);
        EXPECT_NEAR(slab.reflectance, 1 - std::sqrt(1 - h.albedo) * h.value, 6e-5) << h.albedo << " " << h.cosine;
    }
}

// The error falls with the square of the layer count, so half the layers differ by three times the error of all.
TEST(ClosedForms, SlabSolverConvergesToItsStatedAccuracy) {
    const SlabSolution coarse = solveSlab(5, 0.9, SlabLight::Beam, 0.5, 200),
                       fine = solveSlab(5, 0.9, SlabLight::Beam, 0.5);
    EXPECT_NEAR(coarse.reflectance, fine.reflectance, 1e-6);
    EXPECT_NEAR(coarse.transmittance, fine.transmittance, 1e-6);
    EXPECT_NEAR(meanSourceRadiance(coarse, 0, 0.25) / meanSourceRadiance(fine, 0, 0.25), 1, 2e-4);
    EXPECT_NEAR(meanSourceRadiance(coarse, 2, 3) / meanSourceRadiance(fine, 2, 3), 1, 2e-4);
}

// What is absorbed inside is what neither comes back nor goes through.
TEST(ClosedForms, SlabProfileAbsorbsWhatTheFluxesMiss) {
    const double albedo = 0.9, thickness = 4;
    const SlabSolution slab = solveSlab(thickness, albedo, SlabLight::Diffuse);
    const double fluence = 4 * kPi * meanSourceRadiance(slab, 0, thickness) / albedo;
    const double absorbed = (1 - albedo) * fluence * thickness / kPi;
    EXPECT_NEAR(absorbed + slab.reflectance + slab.transmittance + slab.uncollidedTransmittance, 1, 1e-5);
}

TEST(Blocks, AverageIsWeightedAndLeavesEmptyBlocksOut) {
    const Index3 size(6, 4, 4);  // the second block along x is cut to two voxels
    std::vector<double> values(96, 3.0), weights(96, 1.0);
    values[0] = 3 + 64;  // of weight 1 among 64
    values[64] = -100;   // first voxel of the second block, without weight
    weights[64] = 0;
    const std::vector<double> averages = blockAverages(values, weights, size);
    ASSERT_EQ(averages.size(), 2u);
    EXPECT_DOUBLE_EQ(averages[0], 4);
    EXPECT_DOUBLE_EQ(averages[1], 3);
    for (std::size_t n = 64; n < 96; ++n) weights[n] = 0;
    EXPECT_EQ(blockAverages(values, weights, size).size(), 1u);
    EXPECT_NEAR(relativeRms({1.1, 2.2}, {1, 2}), 0.1, 1e-15);
}
