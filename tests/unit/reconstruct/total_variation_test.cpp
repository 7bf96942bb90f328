#include "raysweep/reconstruct/total_variation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "support/worst.h"

using namespace raysweep;

namespace {

const Index3 kDims(9, 11, 20);
constexpr float kStep = 1.0f / 4096;

/// Eq. 6 over all voxels and those behind the last ones, where differences are to 0 outside.
double totalVariation(const ColumnVolume& volume, const Vec3& edges) {
    const auto value = [&](int x, int y, int z) {
        const bool inside = x >= 0 && y >= 0 && z >= 0 && x < kDims.x && y < kDims.y && z < kDims.z;
        return inside ? double(volume.value(x, y, z)) : 0;
    };
    double sum = 0;
    for (int x = 0; x <= kDims.x; ++x)
        for (int y = 0; y <= kDims.y; ++y)
            for (int z = 0; z <= kDims.z; ++z) {
                const double here = value(x, y, z);
                sum += (Vec3(here - value(x - 1, y, z), here - value(x, y - 1, z), here - value(x, y, z - 1)) / edges)
                           .length();
            }
    return sum;
}

}  // namespace

// One step against the derivative of the formula, by differences; relative to the largest. Found: 1.8e-6 to
// 8.9e-6.
TEST(TotalVariation, FallsAlongItsDerivativeWhateverTheShapeOfVoxels) {
    for (const Vec3& edges : {Vec3(1), Vec3(1, 1, 2.5), Vec3(2, 1, 0.7)}) {
        const auto transform = openvdb::math::Transform::createLinearTransform();
        transform->postScale(openvdb::Vec3d(edges.x, edges.y, edges.z));
        const openvdb::CoordBBox box(openvdb::Coord(0), openvdb::Coord(kDims.x - 1, kDims.y - 1, kDims.z - 1));
        const ColumnLattice lattice = columnLattice(box, *transform, 2);
        ColumnVolume volume(lattice), before(lattice), scratch(lattice);
        std::mt19937 random(1);
        std::uniform_int_distribution<int> uniform(4096, 8191);  // of which steps of kStep are exact
        const auto voxel = [](ColumnVolume& of, int x, int y, int z) -> float& {
            return of.column(of.blockOf(x, y), x, y)[z];
        };
        std::vector<openvdb::Coord> voxels;
        for (auto at = box.begin(); at; ++at) voxels.push_back(*at);
        for (const openvdb::Coord& at : voxels) voxel(volume, at.x(), at.y(), at.z()) = float(uniform(random)) * kStep;
        before.copyFrom(volume);
        lowerTotalVariation(volume, scratch, {1.0, 1, -10, 10});

        std::vector<double> derivative, made;
        double square = 0;
        for (const openvdb::Coord& at : voxels) {
            if ((at.x() + at.y() + at.z()) % 7 != 0 && at.x() > 0) continue;  // some of them
            float& value = voxel(before, at.x(), at.y(), at.z());
            const float held = value;
            made.push_back(double(held) - volume.value(at.x(), at.y(), at.z()));
            value = held + kStep;
            double difference = totalVariation(before, edges);
            value = held - kStep;
            difference -= totalVariation(before, edges);
            value = held;
            derivative.push_back(difference);
            square += difference * difference;
        }
        double length = 0, worst = 0;
        for (const double step : made) length += step * step;
        for (std::size_t i = 0; i < made.size(); ++i)
            test::raiseTo(worst, std::abs(made[i] / std::sqrt(length) - derivative[i] / std::sqrt(square)));
        double longest = 0;
        for (const double step : made) longest = std::max(longest, std::abs(step) / std::sqrt(length));
        EXPECT_LT(worst / longest, 9.7e-6) << edges;
    }
}
