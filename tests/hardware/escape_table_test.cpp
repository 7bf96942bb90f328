// The emulator's escape probabilities against the library's, which are fitted from other quadratures.
#include "cube4/escape_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/sweep/escape.h"
#include "support/worst.h"

using namespace raysweep;

// The library's quadrature is good to 1e-5. Found: 1.4e-6 for cubes, 6.5e-6 for a sheared voxel.
TEST(Cube4Escape, IsTheLibrarys) {
    const Matrix3 cube(0.3, 0, 0, 0, 0.3, 0, 0, 0, 0.3), sheared(0.3, 0.1, 0, 0, 0.5, 0, 0, 0.2, 0.2);
    for (const Matrix3& shape : {cube, sheared}) {
        const cube4::EscapeTable ours(shape);
        const Escape theirs(shape);
        double worst = 0;
        for (double depth = 1e-4; depth < 1e3; depth *= 1.3) {
            const double extinction = depth / theirs.meanStepLength();
            test::raiseTo(worst, std::abs(ours.probability(extinction) / theirs.probabilityByQuadrature(depth) - 1));
        }
        EXPECT_LE(worst, 7.1e-6);
    }
    EXPECT_EQ(cube4::EscapeTable(cube).probability(0), 1);
}
