#include "raysweep/reconstruct/pose_refine.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/camera/pose_motion.h"
#include "raysweep/core/parallel.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/photo_views.h"

using namespace raysweep;

namespace {

/// A lump with colours that go up and down, in 16 voxels of 1/8.
PhotoLevel lump() {
    PhotoLevel level;
    level.grid = {Index3(16), Vec3(0.1, 0, -0.1), Vec3(0.125)};
    std::vector<MaskedBrick> bricks;
    for (int n = 0; n < 8; ++n) {
        bricks.push_back({Index3(n & 4 ? 8 : 0, n & 2 ? 8 : 0, n & 1 ? 8 : 0), {}});
        bricks.back().mask.fill(~std::uint64_t(0));
    }
    level.layout = compositeLayout(level.grid.dims, bricks);
    level.voxels.assign(level.layout.voxelCount(), {});
    for (int x = 1; x < 15; ++x)
        for (int y = 1; y < 15; ++y)
            for (int z = 1; z < 15; ++z) {
                const Vec3 at = Vec3(x - 8, (y - 7) * 1.3, z - 7.5) / 6;
                CompositeVoxel& voxel = level.voxels[level.layout.voxel({x, y, z})];
                voxel.extinction = float(std::max(0.0, 1 - at.dot(at)));
                voxel.red = float(0.3 + 0.25 * std::sin(5 * at.x + 2 * at.z));
                voxel.green = float(0.3 + 0.25 * std::cos(4 * at.y - at.x));
                voxel.blue = float(0.3 + 0.25 * std::sin(4 * at.z + 1));
            }
    return level;
}

/// What the level looks like from there.
Photograph seenFrom(const PhotoLevel& level, const Vec3& position, int size, Camera::Projection projection) {
    Camera camera;
    camera.projection = projection;
    camera.eye = position;
    camera.fov = 35;
    camera.orthoWidth = 2.5;
    camera.width = camera.height = size;
    Photograph photograph{"lump", photoCamera(camera), Image(size, size, 4)};
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            Ray ray = pixelRay(photograph.camera, x + 0.5, y + 0.5);
            ray.origin = (ray.origin - level.grid.voxel(0, 0, 0)) / level.grid.edge();
            const CompositeRay line = compositeRay(level.layout, ray, 1);
            RayColor seen;
            composite(level.layout, level.voxels.data(), &line, 1, &seen);
            float* pixel = photograph.matte.at(x, y);
            pixel[0] = seen.red;
            pixel[1] = seen.green;
            pixel[2] = seen.blue;
            pixel[3] = 1 - seen.transmittance;
        }
    return photograph;
}

constexpr int kSize = 14;
constexpr auto kPerspective = Camera::Projection::Perspective, kOrthographic = Camera::Projection::Orthographic;

std::vector<PhotoCamera> camerasOf(const std::vector<Photograph>& photographs) {
    std::vector<PhotoCamera> cameras;
    for (const Photograph& photograph : photographs) cameras.push_back(photograph.camera);
    return cameras;
}

std::optional<std::vector<PhotoCamera>> refined(const PhotoLevel& level, const std::vector<Photograph>& photographs) {
    return refinedPoses(level, photographs, camerasOf(photographs), {}, 1);
}

}  // namespace

// Pictures of the volume itself: the least residual is 0, at the true pose. A view that is 2 degrees off and moved by a
// voxel, and one turned by 5 degrees about the object come back to within .0011 of the way; the others stay.
TEST(PoseRefine, CamerasComeBack) {
    const PhotoLevel level = lump();
    const std::vector<Photograph> truth = {seenFrom(level, Vec3(3.5, 0.5, 1), kSize, kPerspective),
                                           seenFrom(level, Vec3(-1, 2.5, 2.5), kSize, kOrthographic),
                                           seenFrom(level, Vec3(0.3, -3, -1), kSize, kPerspective),
                                           seenFrom(level, Vec3(-3, -1, -1), kSize, kPerspective)};
    const double degrees = kPi / 180;
    const PhotoCamera wrong[2] = {
        moved(truth[0].camera, {Vec3(0, 0.8, 0.6) * (2 * degrees), Vec3(0.05, -0.1, 0.05), 0},
              truth[0].camera.position),
        moved(truth[1].camera, {Vec3(0.6, 0, -0.8) * (5 * degrees), Vec3(0), 0}, level.grid.center)};
    for (std::size_t off = 0; off < 2; ++off) {
        std::vector<Photograph> photographs = truth;
        photographs[off].camera = wrong[off];
        const auto cameras = refined(level, photographs);
        ASSERT_TRUE(cameras);
        const double before = motionInPicture(truth[off].camera, wrong[off], level.grid.box());
        EXPECT_GT(before, 0.5);
        for (std::size_t n = 0; n < truth.size(); ++n)
            EXPECT_LT(motionInPicture(truth[n].camera, (*cameras)[n], level.grid.box()),
                      n == off ? 1.25e-3 * before : 1e-3)
                << off << " " << n;
    }
}

// Poses that are right stay, and so do cameras that see nothing of the object, with pictures that show nothing.
TEST(PoseRefine, RightOnesStay) {
    const PhotoLevel level = lump();
    std::vector<Photograph> photographs = {seenFrom(level, Vec3(3.5, 0.5, 1), kSize, kPerspective)};
    photographs.push_back(photographs[0]);
    PhotoCamera& away = photographs[1].camera;
    away = moved(away, {Vec3(0, 0, kPi), Vec3(0), 0}, away.position);
    photographs[1].matte = Image(kSize, kSize, 4);
    EXPECT_FALSE(refined(level, photographs));
}

TEST(PoseRefine, SameBitsForAnyThreads) {
    const PhotoLevel level = lump();
    std::vector<Photograph> photographs = {seenFrom(level, Vec3(3.5, 0.5, 1), kSize, kPerspective)};
    photographs[0].camera = moved(photographs[0].camera, {Vec3(0, 0.03, 0), Vec3(0.1), 0}, Vec3(0));
    std::vector<std::vector<PhotoCamera>> all;
    for (const int threads : {1, 3}) {
        const ThreadLimit limit(threads);
        const auto cameras = refined(level, photographs);
        ASSERT_TRUE(cameras);
        all.push_back(*cameras);
    }
    EXPECT_EQ(all[0][0].position, all[1][0].position);
    EXPECT_EQ(all[0][0].forward, all[1][0].forward);
}
