// Voxels that are not cubes: stretched, rotated and sheared.
#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/illuminate/illuminate.h"
#include "support/blocks.h"
#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

openvdb::math::Transform::Ptr linear(const Matrix3& m) {
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) matrix(row, column) = m[row][column];
    return openvdb::math::Transform::createLinearTransform(matrix);
}

Matrix3 rotation(double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    const Matrix3 aboutZ(c, s, 0, -s, c, 0, 0, 0, 1), aboutX(1, 0, 0, 0, c, s, 0, -s, c);
    return aboutZ * aboutX;
}

IlluminateOptions fixedSweeps(int sweeps) {
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = sweeps;
    return options;
}

double softBall(const Vec3& p) {
    const double t = (p.length() - 0.6) / 0.4;
    return t <= 0 ? 1 : (t >= 1 ? 0 : 1 - t);
}

/// A soft ball of radius 1 sampled on voxels of the given transform.
openvdb::FloatGrid::Ptr ballOn(const Matrix3& worldFromIndex) {
    auto grid = openvdb::FloatGrid::create();
    grid->setTransform(linear(worldFromIndex));
    const Matrix3 indexFromWorld = worldFromIndex.inverse();
    int reach[3];
    for (int axis = 0; axis < 3; ++axis)  // of the unit ball's image along an index axis
        reach[axis] = 1 + int(Vec3(indexFromWorld[0][axis], indexFromWorld[1][axis], indexFromWorld[2][axis]).length());
    for (int i = -reach[0]; i <= reach[0]; ++i)
        for (int j = -reach[1]; j <= reach[1]; ++j)
            for (int k = -reach[2]; k <= reach[2]; ++k) {
                const double density = softBall(Vec3(i, j, k) * worldFromIndex);
                if (density > 0) grid->tree().setValue({i, j, k}, float(density));
            }
    return grid;
}

constexpr double kCubic = 1.0 / 24;

Illumination lightBall(const Matrix3& worldFromIndex) {
    Scene scene;
    scene.medium.density = ballOn(worldFromIndex);
    scene.medium.extinctionScale = 3;
    scene.suns.push_back({Vec3(0.3, -1, 0.2), grey(1)});
    scene.sky.radiance = grey(0.1f);
    scene.points.push_back({Vec3(0.2, 0.3, -0.2), grey(1)});
    return illuminate(scene, fixedSweeps(256));
}

/// Mean radiosity, weighted by density, in 4^3 boxes of world space over the ball.
std::vector<double> boxAverages(const openvdb::GridBase& radiosity, const Matrix3& worldFromIndex) {
    std::vector<double> sum(64, 0.0), weight(64, 0.0);
    const auto ball = ballOn(worldFromIndex);
    for (auto on = ball->cbeginValueOn(); on; ++on) {
        const openvdb::Vec3d p = ball->indexToWorld(on.getCoord());
        const auto cell = [](double x) { return std::min(3, std::max(0, int((x + 1) * 2))); };
        const auto at = std::size_t(cell(p.x()) * 16 + cell(p.y()) * 4 + cell(p.z()));
        sum[at] +=
            double(*on) * double(static_cast<const openvdb::FloatGrid&>(radiosity).tree().getValue(on.getCoord()));
        weight[at] += double(*on);
    }
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = weight[i] > 0 ? sum[i] / weight[i] : 0;
    return sum;
}

const Matrix3 kCubes(kCubic, 0, 0, 0, kCubic, 0, 0, 0, kCubic);

}  // namespace

TEST(Transform, FurnaceHoldsForAnyShapeOfVoxel) {
    const struct {
        const char* name;
        Matrix3 shape;
    } shapes[] = {{"stretched", Matrix3(1, 0, 0, 0, 2, 0, 0, 0, 0.5)},
                  {"rotated", rotation(0.6)},
                  {"mirrored", Matrix3(1, 0, 0, 0, -1, 0, 0, 0, 1)},
                  {"sheared", Matrix3(1, 0, 0, 0.8, 1, 0, 0.3, 0.5, 1)}};
    for (const auto& shape : shapes) {
        auto density = noiseBall(8, 1e-3, 3);
        density->setTransform(linear(shape.shape));
        Scene scene;
        scene.medium.density = density;
        scene.medium.albedo = grey(1);
        scene.sky.radiance = grey(1);
        const Illumination lit = illuminate(scene, fixedSweeps(1024));
        const Departure now = fromOne(*lit.radiosity, *density);
        std::printf("  %s: mean %.6f rms %.5f balance %.1e\n", shape.name, now.mean, now.rms, lit.power.error());
        // Longer voxels leave fewer distinct rays through each: twice the noise of cubes.
        EXPECT_LE(std::abs(now.mean - 1), 1e-3) << shape.name;
        EXPECT_LE(now.rms, 0.01) << shape.name;
        EXPECT_LE(lit.power.error(), 1e-5);
    }
}

TEST(TransformSlow, OtherVoxelsGiveTheLightOfCubes) {
    const std::vector<double> reference = boxAverages(*lightBall(kCubes).radiosity, kCubes);
    const struct {
        const char* name;
        Matrix3 shape;
    } shapes[] = {{"stretched", Matrix3(1.5, 0, 0, 0, 1, 0, 0, 0, 0.7) * kCubes},
                  {"rotated", rotation(0.6) * kCubes},
                  {"mirrored", Matrix3(1, 0, 0, 0, -1, 0, 0, 0, 1) * kCubes},
                  {"sheared", Matrix3(1, 0, 0, 0.5, 1, 0, 0.2, 0.3, 1) * kCubes}};
    for (const auto& shape : shapes) {
        const Illumination lit = lightBall(shape.shape);
        const double difference = relativeRms(boxAverages(*lit.radiosity, shape.shape), reference);
        std::printf("  %s: %.2f %%, balance %.1e\n", shape.name, 100 * difference, lit.power.error());
        // Both sample the same ball at other places, and see other parts of it in the boxes at its border.
        EXPECT_LE(difference, 0.02) << shape.name;
        EXPECT_LE(lit.power.error(), 1e-5);
    }
}
