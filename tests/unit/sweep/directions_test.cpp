#include "raysweep/sweep/directions.h"

#include "raysweep/sweep/axis.h"
#include "support/worst.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

using namespace raysweep;

namespace {

/// Largest entry of <d d^T> - I/3 and of <d>.
double unevenness(const std::vector<Vec3>& directions) {
    double worst = 0;
    for (int a = 0; a < 3; ++a) {
        double first = 0;
        for (const Vec3& d : directions) first += d[a] / double(directions.size());
        test::raiseTo(worst, std::abs(first));
        for (int b = 0; b < 3; ++b) {
            double second = a == b ? -1.0 / 3 : 0;
            for (const Vec3& d : directions) second += d[a] * d[b] / double(directions.size());
            test::raiseTo(worst, std::abs(second));
        }
    }
    return worst;
}

std::vector<Vec3> draw(DirectionSet set, int batch, std::uint64_t seed, int count) {
    DirectionSequence sequence({set, batch, seed});
    std::vector<Vec3> directions;
    for (int i = 0; i < count; ++i) directions.push_back(sequence.nextGroup(1).front());
    return directions;
}

}  // namespace

TEST(Directions, FibonacciPointsAreEvenlySpread) {
    for (const int count : {32, 256, 4096}) {
        const std::vector<Vec3> points = sphericalFibonacci(count);
        ASSERT_EQ(points.size(), std::size_t(count));
        for (const Vec3& p : points) EXPECT_LE(std::abs(p.length() - 1), 1e-14);
        // Moments of random points would be off by about 1/sqrt(count); these are far better.
        EXPECT_LE(unevenness(points), 0.5 / count);
        // No two are closer than half of what the densest packing allows.
        double closest = 2;
        for (int i = 0; i < std::min(count, 256); ++i)
            for (int j = 0; j < count; ++j)
                if (i != j) closest = std::min(closest, (points[std::size_t(i)] - points[std::size_t(j)]).length());
        EXPECT_GE(closest, 0.5 * std::sqrt(8 * kPi / (std::sqrt(3.0) * count)));
    }
}

TEST(Directions, EachBatchIsAnEvenSetAsLargeAsAllBefore) {
    const std::vector<Vec3> all = draw(DirectionSet::fibonacci, 32, 5, 4096);
    for (std::size_t begin = 0, size = 32; begin < all.size(); begin += size, size = begin) {
        const std::vector<Vec3> part(all.begin() + std::ptrdiff_t(begin), all.begin() + std::ptrdiff_t(begin + size));
        EXPECT_LE(unevenness(part), 1.0 / double(size)) << "batch from " << begin;  // random ones: 1 / sqrt(size)
    }
}

TEST(Directions, ConsecutiveOnesAreIndependent) {
    constexpr int kCount = 100000;
    for (const DirectionSet set : {DirectionSet::fibonacci, DirectionSet::random}) {
        const std::vector<Vec3> all = draw(set, 32, 3, kCount);
        double dot = 0, square = 0;
        for (int i = 1; i < kCount; ++i) {
            const double c = all[std::size_t(i)].dot(all[std::size_t(i) - 1]);
            dot += c / kCount;
            square += c * c / kCount;
        }
        // Drawing without replacement from a balanced batch of 32 makes the mean -1/31; noise is 0.002.
        EXPECT_LE(std::abs(dot), 1.0 / 31 + 0.008) << int(set);
        EXPECT_LE(std::abs(square - 1.0 / 3), 0.02) << int(set);
    }
}

TEST(Directions, RotationsAreOrthonormalAndUniform) {
    std::mt19937_64 random(1);
    Vec3 mean(0);
    constexpr int kCount = 20000;
    for (int i = 0; i < kCount; ++i) {
        const Matrix3 r = randomRotation(random);
        const Matrix3 product = r * r.transposed();
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) ASSERT_LE(std::abs(product[a][b] - (a == b)), 1e-12);
        ASSERT_LE(std::abs(r.determinant() - 1), 1e-12);
        mean += Vec3(0, 0, 1) * r / kCount;
    }
    EXPECT_LE(mean.length(), 4 / std::sqrt(double(kCount)));
}

TEST(Directions, AreTheSameForTheSameSeed) {
    for (const DirectionSet set : {DirectionSet::fibonacci, DirectionSet::random, DirectionSet::lowDiscrepancy}) {
        const std::vector<Vec3> a = draw(set, 32, 9, 100), b = draw(set, 32, 9, 100), c = draw(set, 32, 10, 100);
        EXPECT_TRUE(a == b);
        EXPECT_EQ(a == c, set == DirectionSet::lowDiscrepancy);  // which has no seed
    }
}

TEST(Directions, BatchesOfOneWork) {
    EXPECT_LE(unevenness(draw(DirectionSet::fibonacci, 1, 1, 40000)), 0.02);
}

// The fewer groups, the fewer times a volume is read; and what lies in one class is spread over its groups.
TEST(Directions, ABatchMakesAsFewGroupsAsItCanAllOfAboutOneSize) {
    constexpr int kMost = 8;
    DirectionSequence sequence({DirectionSet::fibonacci, 48, 5, kMost}, directionClass);
    for (const int batch : {48, 48, 96, 192}) {
        std::vector<std::size_t> sizes[kDirectionClasses];
        std::vector<Vec3> all;
        do {
            const std::vector<Vec3> group = sequence.nextGroup(kMost);
            for (const Vec3& direction : group) EXPECT_EQ(directionClass(direction), directionClass(group[0]));
            sizes[directionClass(group[0])].push_back(group.size());
            all.insert(all.end(), group.begin(), group.end());
        } while (sequence.left() > 0);
        ASSERT_EQ(all.size(), std::size_t(batch));
        EXPECT_LE(unevenness(all), 1.0 / batch);
        for (const std::vector<std::size_t>& of : sizes) {
            ASSERT_FALSE(of.empty());
            const std::size_t members = std::accumulate(of.begin(), of.end(), std::size_t(0));
            EXPECT_EQ(of.size(), (members + kMost - 1) / kMost);
            EXPECT_LE(*std::max_element(of.begin(), of.end()), *std::min_element(of.begin(), of.end()) + 1);
        }
    }
}
