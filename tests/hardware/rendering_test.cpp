// Pictures by the emulator against those of the library's renderer.
#include "cube4/rendering.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "raysweep/render/render.h"
#include "support/worst.h"

using namespace raysweep;

namespace {

const Index3 kSize(16, 24, 16);
constexpr double kVoxel = 0.5;

/// A soft random medium; its grids and their dense twin.
struct Lit {
    openvdb::FloatGrid::Ptr density, radiosity;
    cube4::LitVolume dense;

    Lit() {
        initializeGrids();
        const auto transform = openvdb::math::Transform::createLinearTransform(kVoxel);
        density = openvdb::FloatGrid::create(0.0f);
        radiosity = openvdb::FloatGrid::create(0.0f);
        std::mt19937 random(5);
        std::uniform_real_distribution<float> uniform(0, 1);
        for (const auto& grid : {density, radiosity}) {
            grid->setTransform(transform);
            auto accessor = grid->getAccessor();
            for (int x = 0; x < kSize.x; ++x)
                for (int y = 0; y < kSize.y; ++y)
                    for (int z = 0; z < kSize.z; ++z) accessor.setValueOn({x, y, z}, uniform(random));
        }
        dense.box = cube4::boxAround(*density, 1 << 20);
        dense.extinction = cube4::denseField(*density, dense.box);
        dense.radiosity = {cube4::denseField(*radiosity, dense.box)};
    }
};

/// Along an axis, a pixel for each voxel and more around, the first of them `shift` voxels beside one's middle.
Camera cameraAlong(int axis, double way, const Imath::V2d& shift, double distance) {
    const Vec3 middle = Vec3(kSize.x - 1, kSize.y - 1, kSize.z - 1) * (0.5 * kVoxel);
    Camera camera;
    camera.projection = Camera::Projection::Orthographic;
    Vec3 forward(0);
    forward[axis] = way;
    camera.up = Vec3(0);
    camera.up[(axis + 1) % 3] = 1;
    camera.width = camera.height = 28;
    camera.orthoWidth = 28 * kVoxel;
    const Vec3 beside = forward.cross(camera.up) * shift.x * kVoxel + camera.up * shift.y * kVoxel;
    camera.target = middle + beside;
    camera.eye = camera.target - forward * distance;
    return camera;
}

cube4::ParallelView viewOf(const Camera& camera) {
    const CameraFrame frame = cameraFrame(camera);
    cube4::ParallelView view;
    view.direction = frame.forward;
    view.origin = pixelRay(frame, 0.5, 0.5).origin;
    view.column = pixelRay(frame, 1.5, 0.5).origin - view.origin;
    view.row = pixelRay(frame, 0.5, 1.5).origin - view.origin;
    view.width = camera.width;
    view.height = camera.height;
    return view;
}

struct Difference {
    double color = 0, alpha = 0, largest = 0;
};

Difference differenceOf(const Image& a, const Image& b) {
    Difference difference;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x) {
            test::raiseTo(difference.color, std::abs(double(a.at(x, y)[0]) - double(b.at(x, y)[0])));
            test::raiseTo(difference.alpha, std::abs(double(a.at(x, y)[3]) - double(b.at(x, y)[3])));
            test::raiseTo(difference.largest, double(b.at(x, y)[0]));
        }
    return difference;
}

}  // namespace

// Asked: 1e-3. Found: 3.9e-7 of the largest colour, 4.8e-7 of opacity.
TEST(Cube4Rendering, IsTheLibrarysWithTheSameSamples) {
    const Lit lit;
    const RenderVolume volume({lit.density, 1, lit.radiosity});
    for (const bool lambert : {false, true})
        for (int axis = 0; axis < 3; ++axis)
            for (const double way : {-1.0, 1.0})
                for (const double depth : {0.0, 0.3}) {
                    SCOPED_TRACE(testing::Message()
                                 << "axis " << axis << " way " << way << " depth " << depth << " lambert " << lambert);
                    // Samples of the library are in the middle of steps that begin at the eye's plane.
                    const double slices = 0.5 * (kSize[axis] - 1) + 6;
                    const Camera camera = cameraAlong(axis, way, {0.2, 0.35}, (slices + 0.5 - depth) * kVoxel);
                    RenderOptions options;
                    options.step = 1;
                    options.lambert = lambert;
                    options.background = grey(lambert ? 0 : 0.4f);
                    options.minTransmittance = 0;
                    const Image theirs = render(volume, camera, options).image;
                    cube4::RenderSetup setup;
                    setup.pipelines = 4;
                    setup.depth = depth;
                    setup.lambert = lambert;
                    setup.background = double(options.background.x);
                    const cube4::Rendering ours = cube4::renderView(lit.dense, viewOf(camera), setup);
                    const Difference difference = differenceOf(ours.image, theirs);
                    EXPECT_GT(difference.largest, lambert ? 0.2 : 0.4);
                    EXPECT_LE(difference.color / difference.largest, 4.3e-7);
                    EXPECT_LE(difference.alpha, 5.2e-7);
                }
}
