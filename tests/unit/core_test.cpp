#include "raysweep/core/parallel.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace raysweep;

TEST(OrderedSum, HasTheSameBitsForAnyNumberOfThreads) {
    const auto term = [](std::size_t i) { return std::sin(0.1 * double(i)) * std::pow(10.0, double(i % 17)); };
    double one = 0, two = 0;
    {
        ThreadLimit limit(1);
        one = orderedSum(100000, term);
    }
    {
        ThreadLimit limit(2);
        two = orderedSum(100000, term);
    }
    EXPECT_EQ(one, two);
}

TEST(OrderedSum, OfNothingIsZero) {
    EXPECT_EQ(orderedSum(0, [](std::size_t) { return 1.0; }), 0.0);
}
