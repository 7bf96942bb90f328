// Light on meshes, as they are imported, lit and baked.
#include "raysweep/render/bake.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "raysweep/illuminate/illuminate.h"
#include "raysweep/mesh/mesh_volume.h"
#include "raysweep/volume/classify.h"
#include "support/meshes.h"
#include "support/worst.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

/// Colours of the corners of `eyes`, a mesh within the volume that `mesh` makes, in sunlight, in parts of what a face
/// straight to the sun shows of it.
std::vector<double> sunlit(const TriangleMesh& mesh, double voxel, double reflectance, const Vec3& sun,
                           const TriangleMesh& eyes) {
    constexpr double kIrradiance = 3;
    MeshVolumeOptions options;
    options.voxelSize = voxel;
    TransferFunction ramp;
    ramp.points = {{0, 0, grey(1)}, {1, 0.99, grey(1)}};
    Scene scene;
    scene.medium.density = classify(*meshToVolume(mesh, options).density, ramp).extinction;
    scene.medium.solid = true;
    scene.medium.albedo = grey(float(reflectance));
    scene.suns.push_back({sun, grey(float(kIrradiance))});
    const Illumination lit = illuminate(scene, {});
    const BakedMesh baked = bakeRadiosity({scene.medium.density, 1, lit.radiosity}, eyes);
    EXPECT_EQ(baked.corners.turned + baked.corners.missed, 0u);
    std::vector<double> parts;
    for (const Color& color : baked.mesh.colors) parts.push_back(double(color.x) / (reflectance * kIrradiance / kPi));
    return parts;
}

}  // namespace

TEST(BakePhysics, SunlitSphereFollowsLambert) {
    const TriangleMesh mesh = sphereMesh(Vec3(0), 1, 5);
    const Vec3 sun = Vec3(0.5, 0.6, -0.7).normalized();
    const std::vector<double> colors = sunlit(mesh, 1 / 32., 0.8, sun, mesh);
    double squares = 0, sum = 0;
    std::vector<double> errors;
    for (std::size_t i = 0; i < colors.size(); ++i) {
        const double error = colors[i] - std::max(0.0, -sun.dot(mesh.positions[i].normalized()));
        errors.push_back(std::abs(error));
        squares += error * error, sum += error;
    }
    std::sort(errors.begin(), errors.end());
    const auto within = [&](double share) { return errors[std::size_t(share * double(errors.size() - 1))]; };
    const double rms = std::sqrt(squares / double(colors.size())), mean = sum / double(colors.size());
    std::printf("rms %.4f mean %.4f p90 %.4f p95 %.4f p99 %.4f max %.4f\n", rms, mean, within(0.9), within(0.95),
                within(0.99), errors.back());
    // Found: 0.0032, 0.0098 in the worst hundredth, half a voxel of which is the eye's way into the surface.
    EXPECT_LT(rms, 0.0035);
    EXPECT_LT(within(0.99), 0.0105);
    EXPECT_LT(std::abs(mean), 0.001);
}

namespace {

/// What throws a shadow on a floor whose top is at kFloor, and where it ends there: at these places of a line.
struct Shadow {
    TriangleMesh caster;
    Vec3 from, along;  ///< world; the line, horizontal and of unit length
    double near, far;  ///< on the line
};

constexpr double kFloor = 4;

Vec3 sunAt(double elevation, double azimuth) {
    const double up = elevation * kPi / 180, around = azimuth * kPi / 180;
    return {std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), -std::sin(up)};
}

/// Of a block, or a sheet, from `bottom` to 16: of its lower edge at x = 16 and its upper one at 32.
Shadow shadowOfBlock(double bottom, const Vec3& sun) {
    const double x = -sun.x / sun.z, y = -sun.y / sun.z;
    const double middle = 64 + 0.5 * (bottom + 16 - 2 * kFloor) * y;
    return {boxMesh(Vec3(16, 24, bottom), Vec3(32, 104, 16)), Vec3(0, middle, kFloor), Vec3(1, 0, 0),
            16 + (bottom - kFloor) * x, 32 + (16 - kFloor) * x};
}

/// How far from the middle of a sphere of voxels, whose edge is one voxel soft, half of a ray's light goes by it: a
/// ray that grazes it stays in that edge for some voxels.
double silhouetteOf(double radius) {
    constexpr double kStep = 1 / 64.;
    for (double b = radius - 2;; b += kStep) {
        double depth = 0;
        for (double s = 0.5 * kStep; s < radius; s += kStep) {
            const double filled = std::clamp(0.5 - (std::hypot(b, s) - radius), 0.0, 1.0);
            depth -= 2 * kStep * std::log1p(-0.99 * filled);
        }
        if (depth < std::log(2.0)) return b;
    }
}

/// Of a sphere whose middle is 12 above the floor: an ellipse as long as its width over the sine.
Shadow shadowOfSphere(const Vec3& sun) {
    const double radius = 8, height = 12;
    const Vec3 middle(24, 64, kFloor + height);
    const Vec3 along = Vec3(sun.x, sun.y, 0).normalized();
    const double half = -silhouetteOf(radius) / sun.z;
    return {sphereMesh(middle, radius, 4), middle - sun * (height / sun.z), along, -half, half};
}

/// Places on the line where it is half as light as in full sun, less where they should be, voxels.
std::pair<double, double> errorsOf(const Shadow& shadow, const Vec3& sun) {
    constexpr double kSpacing = 1 / 16., kBeyond = 10;
    const Vec3 end = shadow.from + shadow.along * (shadow.far + kBeyond);
    TriangleMesh mesh =
        boxMesh(Vec3(-60, 0, 0), Vec3(std::ceil(end.x) + 4, std::ceil(std::max(124.0, end.y + 4)), kFloor));
    append(mesh, shadow.caster);
    TriangleMesh line;
    for (double at = shadow.near - kBeyond; at < shadow.far + kBeyond; at += kSpacing) {
        line.positions.push_back(shadow.from + shadow.along * at);
        line.positions.push_back(shadow.from + shadow.along * at + Vec3(0, 0, 1).cross(shadow.along));
        const auto i = std::uint32_t(line.positions.size());
        if (i > 2) line.triangles.push_back({i - 4, i - 2, i - 3});
    }
    // So dark that next to nothing is scattered.
    const std::vector<double> colors = sunlit(mesh, 1, 0.02, sun, line);
    const double half = -sun.z / 2;
    std::size_t first = 0, last = colors.size() - 2;
    while (first + 2 < colors.size() && colors[first] > half) first += 2;
    while (last > 1 && colors[last] > half) last -= 2;
    const auto place = [&](std::size_t i, double steps) { return -kBeyond + kSpacing * (double(i / 2) + steps); };
    return {place(first, -0.5), place(last, 0.5) + shadow.near - shadow.far};
}

}  // namespace

// The far end is that of a convex edge against whose normal a low sun shines, or of a sphere's other side. What is left
// are half a voxel across the rays at a solid's edges, by their bilinear weights, and that a floor's light is found in
// the middles of its voxels, half a voxel below: both add up at the near end.
TEST(BakePhysics, ShadowsEndWhereTheyShould) {
    double worstNear[2] = {0, 0}, worstFar[2] = {0, 0};  // of suns below 30 degrees, and of others
    double worstStraight[2] = {0, 0};  // far ends under straight edges: of suns from 30 degrees on, from 50 on
    for (const double elevation : {10., 20., 30., 40., 60., 80.})
        for (const double azimuth : {0., 20., 45.}) {
            const Vec3 sun = sunAt(elevation, azimuth);
            const std::pair<const char*, Shadow> shadows[] = {
                {"block", shadowOfBlock(12, sun)}, {"sheet", shadowOfBlock(14, sun)}, {"sphere", shadowOfSphere(sun)}};
            for (const auto& [name, shadow] : shadows) {
                const auto [near, far] = errorsOf(shadow, sun);
                std::printf("  %2.0f degrees high, azimuth %2.0f: %s %+.2f %+.2f\n", elevation, azimuth, name, near,
                            far);
                raiseTo(worstNear[elevation >= 30], std::abs(near));
                raiseTo(worstFar[elevation >= 30], std::abs(far));
                if (elevation >= 30 && name != std::string("sphere"))
                    raiseTo(worstStraight[elevation >= 50], std::abs(far));
            }
        }
    std::printf("  worst %.2f %.2f, low suns %.2f %.2f\n", worstNear[1], worstFar[1], worstNear[0], worstFar[0]);
    // As found, and a tenth more. Where surfaces did not take from rays that leave: 1.66, 1.29 and 1.68, 1.24.
    EXPECT_LT(worstFar[0], 0.97);
    EXPECT_LT(worstFar[1], 0.86);
    EXPECT_LT(worstNear[0], 1.68);
    EXPECT_LT(worstNear[1], 1.2);
    EXPECT_LT(worstStraight[0], 0.32);  // found: 0.29
    EXPECT_LT(worstStraight[1], 0.06);  // found: 0.05
}
