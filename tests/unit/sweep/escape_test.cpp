#include "raysweep/sweep/escape.h"

#include "support/closed_forms.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace raysweep;

namespace {
Matrix3 scaled(double x, double y, double z) {
    return {x, 0, 0, 0, y, 0, 0, 0, z};
}
}  // namespace

TEST(Escape, OfACubeAgreesWithQuadrature) {
    const Escape escape(scaled(1, 1, 1));
    for (double depth = 1e-4; depth < 1e4; depth *= 1.7) {
        const double exact = test::escapeProbability(depth);
        // 256 quantiles of the step length and a table of 32 nodes per octave leave 1e-5.
        EXPECT_LT(std::abs(escape.probability(depth * escape.meanStepLength()) / exact - 1), 2e-5) << depth;
    }
}

TEST(Escape, FitForKernelsIsGoodForAllShapesOfVoxel) {
    for (const Matrix3& shape : {scaled(1, 1, 1), scaled(1e-6, 1e-6, 1e-6), scaled(1, 1, 4), scaled(0.1, 3, 3),
                                 Matrix3(1, 0, 0, 0.8, 1, 0, 0.3, 0.5, 1)}) {
        const Escape escape(shape);
        // Only the rate of shooting and the effective albedo rest on the fit; 1e-3 is far below the error of a voxel.
        EXPECT_LT(escape.fit().maxRelativeError, 1e-3);
        for (double t = 1e-8; t < 1e8; t *= 3) {
            const double p = escape.fit().numerator(t) / escape.fit().denominator(t);
            EXPECT_LT(std::abs(p / escape.probability(t) - 1), 1e-3) << t;
        }
    }
}

TEST(Escape, OfVeryElongatedVoxelsStillFits) {
    EXPECT_LT(Escape(scaled(1, 10, 100)).fit().maxRelativeError, 0.01);
}
