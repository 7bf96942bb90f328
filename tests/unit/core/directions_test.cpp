#include "raysweep/core/finite.h"

#include <gtest/gtest.h>

#include <limits>

using namespace raysweep;

// The square of a component need not be a number. 4 roundings of the result at most.
TEST(UnitVector, HasLength1WhateverTheLengthWas) {
    const Vec3 expected = Vec3(3, -4, 12) / 13;
    for (const double length : {1.0, 1e-300, 1e-200, 1e-160, 1e-100, 1e100, 1e160, 1e300}) {
        const Vec3 unit = unitVector(Vec3(3, -4, 12) * length);
        for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(unit[axis], expected[axis], 4 * 2.2e-16) << length;
    }
}

TEST(UnitVector, DirectionsAreFiniteAndNotZero) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    EXPECT_TRUE(isDirection(Vec3(0, 1e-320, 0)));
    EXPECT_FALSE(isDirection(Vec3(0)));
    EXPECT_FALSE(isDirection(Vec3(1, kInfinity, 0)));
    EXPECT_FALSE(isDirection(Vec3(std::numeric_limits<double>::quiet_NaN(), 1, 0)));
}
