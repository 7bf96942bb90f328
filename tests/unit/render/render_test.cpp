#include "raysweep/render/render.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/render/occupancy.h"
#include "support/other_grid.h"
#include "support/worst.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

using namespace raysweep;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3SGrid;

namespace {

/// Rounding of a float sum of some hundred terms of size 1 or less.
constexpr double kFloatTolerance = 1e-5;

FloatGrid::Ptr box(const CoordBBox& bounds, float value) {
    FloatGrid::Ptr grid = FloatGrid::create();
    grid->denseFill(bounds, value);
    return grid;
}

FloatGrid::Ptr filled(const CoordBBox& bounds, const std::function<float(const Coord&)>& value) {
    FloatGrid::Ptr grid = FloatGrid::create();
    auto accessor = grid->getAccessor();
    for (auto ijk = bounds.begin(); ijk != bounds.end(); ++ijk) accessor.setValue(*ijk, value(*ijk));
    return grid;
}

/// Half of the voxels empty, the others over three decades.
FloatGrid::Ptr noise(const CoordBBox& bounds) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(-1, 1);
    FloatGrid::Ptr grid = FloatGrid::create();
    auto accessor = grid->getAccessor();
    for (auto ijk = bounds.begin(); ijk != bounds.end(); ++ijk) {
        const float u = uniform(random);
        if (u > 0) accessor.setValue(*ijk, std::pow(10.f, 3 * u - 2));
    }
    return grid;
}

/// The same source radiance everywhere.
FloatGrid::Ptr everywhere(float value) {
    return FloatGrid::create(value);
}

RenderInput input(FloatGrid::ConstPtr density, double extinctionScale,
                  openvdb::GridBase::ConstPtr radiosity = everywhere(1)) {
    return {density, extinctionScale, radiosity};
}

Camera parallelCamera(const Vec3& eye, const Vec3& target, double width, int pixels) {
    Camera camera;
    camera.projection = Camera::Projection::Orthographic;
    camera.eye = eye;
    camera.target = target;
    camera.up = std::abs((target - eye).normalized().z) < 0.9 ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
    camera.orthoWidth = width;
    camera.width = camera.height = pixels;
    return camera;
}

/// Alpha along one ray.
double alphaAlong(const RenderInput& what, const Vec3& origin, const Vec3& through, const RenderOptions& options = {}) {
    return render(what, parallelCamera(origin, through, 1e-6, 1), options).image.pixels[3];
}

double opticalDepthAlong(const RenderInput& what, const Vec3& origin, const Vec3& through) {
    return -std::log1p(-alphaAlong(what, origin, through));
}

/// Length of the ray inside a box of world corners lo, hi.
double chord(const Ray& ray, const Vec3& lo, const Vec3& hi) {
    double t0 = 0, t1 = 1e30;
    for (int axis = 0; axis < 3; ++axis) {
        double a = (lo[axis] - ray.origin[axis]) / ray.direction[axis];
        double b = (hi[axis] - ray.origin[axis]) / ray.direction[axis];
        if (a > b) std::swap(a, b);
        t0 = std::max(t0, a), t1 = std::min(t1, b);
    }
    return std::max(0.0, t1 - t0);
}

double maxDifference(const Image& a, const Image& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        test::raiseTo(largest, std::abs(double(a.pixels[i]) - b.pixels[i]));
    return largest;
}

/// Largest distance of any colour value from `expected`; NaN if one is.
double worstColour(const Image& image, double expected) {
    double worst = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        if (i % 4 != 3) test::raiseTo(worst, std::abs(image.pixels[i] - expected));
    return worst;
}

Camera threeQuarter(const openvdb::GridBase& grid, int pixels) {
    Camera camera;
    camera.width = camera.height = pixels;
    return framed(camera, worldBounds(grid));
}

}  // namespace

// Voxels 0..9 cover [-0.5, 9.5]; interpolation turns each face into a ramp with the same integral. Samples half a voxel
// apart add such ramps up exactly.
TEST(Render, BoxObeysBeerLambertAlongEveryAxis) {
    const auto density = box({Coord(0), Coord(9)}, 2);
    for (int axis = 0; axis < 3; ++axis)
        for (double side : {-30.0, 40.0}) {
            Vec3 eye(4.3, 5.2, 3.9), target = eye;
            eye[axis] = side;
            target[axis] = 4;
            const Image image = render(input(density, 0.1), parallelCamera(eye, target, 6, 5)).image;
            for (int p = 0; p < 25; ++p)
                for (int c = 0; c < 4; ++c) EXPECT_NEAR(image.pixels[4 * p + c], 1 - std::exp(-2.0), kFloatTolerance);
        }
}

// Rays that stay a voxel away from the edges meet two ramps; the rest is the midpoint rule's error at their kinks, at
// most slope h^2/8 each with h = 0.5, slope 0.15.
TEST(Render, BoxInPerspectiveIsAsDeepAsTheChordIsLong) {
    const auto density = box({Coord(-20, -10, -30), Coord(19, 9, 29)}, 1);
    Camera camera;
    camera.eye = Vec3(13, -60, 17);
    camera.target = Vec3(1, 0, -2);
    camera.fov = 30;
    camera.width = camera.height = 32;
    const Image image = render(input(density, 0.15), camera).image;
    const CameraFrame frame = cameraFrame(camera);
    int tested = 0;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            const Ray ray = pixelRay(frame, x + 0.5, y + 0.5);
            const double in = (-10.5 - ray.origin.y) / ray.direction.y, out = (9.5 - ray.origin.y) / ray.direction.y;
            const Vec3 a = ray.origin + ray.direction * in, b = ray.origin + ray.direction * out;
            if (std::max({std::abs(a.x), std::abs(b.x)}) > 18 || std::max({std::abs(a.z), std::abs(b.z)}) > 28)
                continue;
            const double expected = 1 - std::exp(-0.15 * chord(ray, Vec3(-20.5, -10.5, -30.5), Vec3(19.5, 9.5, 29.5)));
            EXPECT_NEAR(image.at(x, y)[0], expected, 1e-3) << x << " " << y;
            ++tested;
        }
    EXPECT_GT(tested, 300);
}

// A sphere whose edge is soft by one voxel and by interpolation, together a variance v of about 1/4 voxel^2. It
// shortens a chord l at distance d from the middle by v/2 d^2 / (l/2)^3: below 0.03 voxels up to d = 0.7 radius, hence
// 2e-3.
TEST(Render, SphereIsAsDeepAsTheChordIsLong) {
    const double radius = 20, sigma = 0.06;
    const auto density = filled({Coord(-22), Coord(22)}, [&](const Coord& ijk) {
        return float(std::clamp(radius - ijk.asVec3d().length() + 0.5, 0.0, 1.0));
    });
    for (auto projection : {Camera::Projection::Perspective, Camera::Projection::Orthographic}) {
        Camera camera;
        camera.projection = projection;
        camera.eye = Vec3(50, -60, 30);
        camera.fov = 30;
        camera.orthoWidth = 45;
        camera.width = camera.height = 24;
        const Image image = render(input(density, sigma), camera).image;
        const CameraFrame frame = cameraFrame(camera);
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 24; ++x) {
                const Ray ray = pixelRay(frame, x + 0.5, y + 0.5);
                const double distance = ray.origin.cross(ray.direction).length();
                if (distance > 0.7 * radius && distance < radius + 2) continue;
                const double length = 2 * std::sqrt(std::max(0.0, radius * radius - distance * distance));
                EXPECT_NEAR(image.at(x, y)[3], 1 - std::exp(-sigma * length), 2e-3) << x << " " << y;
            }
    }
}

// The volume disappears: weights of all steps and the background add up to 1 whatever the density, the step, the end of
// a ray, and the edge of a radiosity that reaches one voxel further than density.
TEST(Render, FurnaceShowsNothing) {
    const auto density = noise({Coord(0), Coord(19)});
    FloatGrid::Ptr radiosity = box({Coord(-1), Coord(20)}, 1);
    RenderOptions options;
    options.background = grey(1);
    for (double scale : {1e-6, 0.01, 1.0, 1e4, 1e8})
        for (double step : {0.25, 0.5, 1.7}) {
            options.step = step;
            const Image image = render(input(density, scale, radiosity), threeQuarter(*density, 40), options).image;
            EXPECT_LT(worstColour(image, 1), kFloatTolerance) << scale << " " << step;
        }
}

// Second order: a step three times as long errs by nine times as much, and both little.
TEST(Render, StepHardlyMatters) {
    const CoordBBox bounds(Coord(0), Coord(31));
    const auto wave = [](const Coord& p) {
        const auto bump = [](int i) { return std::pow(std::sin(kPi * i / 31.0), 2); };
        return float(bump(p.x()) * bump(p.y()) * bump(p.z()) * (1.2 + std::sin(0.7 * p.x() + 0.4 * p.z())));
    };
    const auto density = filled(bounds, wave);
    const auto radiosity = filled({Coord(-1), Coord(32)}, [](const Coord& p) { return 0.03f * float(p.x() + 1); });
    const auto picture = [&](double step) {
        RenderOptions options;
        options.step = step;
        return render(input(density, 0.3, radiosity), threeQuarter(*density, 48), options).image;
    };
    const Image exact = picture(0.02);
    EXPECT_LT(maxDifference(picture(0.5), exact), 1e-3);
    EXPECT_LT(maxDifference(picture(0.1), exact), 1e-4);
}

TEST(Render, TilesEqualVoxelsBitForBit) {
    FloatGrid::Ptr tiles = FloatGrid::create();
    tiles->sparseFill({Coord(-128, 0, 0), Coord(127, 15, 23)}, 0.02f);       // tiles of 8^3
    tiles->sparseFill({Coord(-128, 128, -128), Coord(-1, 255, -1)}, 0.01f);  // one of 128^3
    ASSERT_GT(tiles->tree().activeTileCount(), 0u);
    FloatGrid::Ptr voxels = tiles->deepCopy();
    voxels->tree().voxelizeActiveTiles();
    ASSERT_EQ(voxels->tree().activeTileCount(), 0u);
    const Camera camera = threeQuarter(*tiles, 64);
    const Image a = render(input(tiles, 1), camera).image, b = render(input(voxels, 1), camera).image;
    EXPECT_EQ(a.pixels, b.pixels);
    EXPECT_GT(*std::max_element(a.pixels.begin(), a.pixels.end()), 0.5f);
}

TEST(Render, HugeTileIsCrossed) {
    FloatGrid::Ptr grid = FloatGrid::create();
    grid->tree().addTile(3, Coord(0), 1, true);
    EXPECT_NEAR(opticalDepthAlong(input(grid, 1e-3), Vec3(2000, -9, 2000), Vec3(2000, 0, 2000)), 4.096, 1e-4);
    EXPECT_NEAR(opticalDepthAlong(input(grid, 1e-3), Vec3(2000, 5000, 2000), Vec3(2000, 0, 2000)), 4.096, 1e-4);
}

// A lone voxel is a hat two voxels wide; rays pass it at 3/4 on either side. None of it may be skipped, wherever the
// voxel lies in its leaf.
TEST(Render, SkippingCutsNothingOffALoneVoxel) {
    for (const Coord& at : {Coord(0), Coord(7), Coord(3, 0, 7), Coord(-8, -1, 128), Coord(-1000000, 999999, 1000000)}) {
        const auto density = box({at, at}, 1);
        const Vec3 middle(at.x(), at.y(), at.z());
        for (int axis = 0; axis < 3; ++axis)
            for (int corner = 0; corner < 4; ++corner)
                for (double direction : {-1.0, 1.0}) {
                    Vec3 ray = middle;
                    ray[(axis + 1) % 3] += corner & 1 ? 0.75 : -0.75;
                    ray[(axis + 2) % 3] += corner & 2 ? 0.75 : -0.75;
                    Vec3 eye = ray;
                    eye[axis] -= 20 * direction;
                    EXPECT_NEAR(opticalDepthAlong(input(density, 1), eye, ray), 1 / 16.0, 1e-6) << at << axis << corner;
                }
    }
}

TEST(Render, SkippingCutsNothingOffATile) {
    FloatGrid::Ptr density = FloatGrid::create();
    density->tree().addTile(1, Coord(8), 1, true);  // voxels 8..15
    for (double edge : {7.25, 15.75})
        EXPECT_NEAR(opticalDepthAlong(input(density, 1), Vec3(edge, -50, edge), Vec3(edge, 0, edge)), 8 / 16.0, 1e-5);
}

// Every pixel against brute force: one occupied box so large that nothing is skipped, samples at the same places.
TEST(Render, SkippingChangesNoBit) {
    const auto density = noise({Coord(-10), Coord(9)});
    FloatGrid::Ptr scattered = FloatGrid::create(), dense = FloatGrid::create();
    dense->denseFill({Coord(-64), Coord(63)}, 1e-30f);  // denser than nothing, too thin for a float to notice
    for (auto value = density->cbeginValueOn(); value; ++value) {
        const Coord spread(6 * value.getCoord().x(), 5 * value.getCoord().y(), 3 * value.getCoord().z());
        scattered->tree().setValue(spread, *value);
        dense->tree().setValue(spread, *value);
    }
    Camera camera = threeQuarter(*scattered, 40);
    EXPECT_LT(maxDifference(render(input(scattered, 1), camera).image, render(input(dense, 1), camera).image), 1e-6);
}

TEST(Render, NonUniformRotatedVoxelsHaveWorldLengths) {
    const auto density = box({Coord(0), Coord(19)}, 1);
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.preScale(openvdb::Vec3d(0.5, 2, 0.1));
    matrix.postRotate(openvdb::math::X_AXIS, 0.4);
    matrix.postRotate(openvdb::math::Z_AXIS, -1.1);
    matrix.postTranslate(openvdb::Vec3d(100, -7, 3));
    density->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    const auto world = [&](double i, double j, double k) {
        const openvdb::Vec3d p = density->indexToWorld(openvdb::Vec3d(i, j, k));
        return Vec3(p.x(), p.y(), p.z());
    };
    const Vec3 middle = world(9.5, 9.5, 9.5);
    const double length[3] = {20 * 0.5, 20 * 2.0, 20 * 0.1};
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 eye = world(axis == 0 ? -90 : 9.5, axis == 1 ? -90 : 9.5, axis == 2 ? -90 : 9.5);
        EXPECT_NEAR(opticalDepthAlong(input(density, 0.05), eye, middle), 0.05 * length[axis], kFloatTolerance) << axis;
    }
    // Slantwise through the two faces k = const; midpoint error as in BoxInPerspective.
    const Vec3 in = world(5, 8, -60), through = world(9.5, 9.5, 9.5);
    const double steps = 20.0 / (9.5 + 60);
    EXPECT_NEAR(opticalDepthAlong(input(density, 0.5), in, through), 0.5 * (through - in).length() * steps, 2e-3);
}

TEST(Render, MirroredTransform) {
    const auto density = box({Coord(0), Coord(9)}, 1);
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.preScale(openvdb::Vec3d(-1, 1, 1));
    density->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    EXPECT_NEAR(opticalDepthAlong(input(density, 0.1), Vec3(-20, 4, 4), Vec3(0, 4, 4)), 1, kFloatTolerance);
}

TEST(Render, EyeInsideSeesOnlyWhatIsAhead) {
    const auto density = box({Coord(-10), Coord(10)}, 1);
    EXPECT_NEAR(opticalDepthAlong(input(density, 0.1), Vec3(0), Vec3(0, 5, 0)), 1.05, kFloatTolerance);
    EXPECT_EQ(alphaAlong(input(density, 0.1), Vec3(0, 30, 0), Vec3(0, 40, 0)), 0);
}

TEST(Render, EyeFarAwayCostsNoDigits) {
    const auto density = box({Coord(0), Coord(9)}, 1);
    EXPECT_NEAR(opticalDepthAlong(input(density, 0.1), Vec3(4.5, -1e8, 4.5), Vec3(4.5, 0, 4.5)), 1, 1e-4);
}

TEST(Render, ThinMediumKeepsItsDigits) {
    const auto density = box({Coord(0), Coord(9)}, 1);
    const double alpha = alphaAlong(input(density, 1e-9), Vec3(4, -20, 4), Vec3(4, 0, 4));
    EXPECT_NEAR(alpha / 1e-8, 1, 1e-6);
}

TEST(Render, HalfTransparentVolumeOverABackground) {
    const auto density = box({Coord(0), Coord(9)}, 1);
    RenderOptions options;
    options.background = Color(0.2f, 0.4f, 8.0f);
    const RenderInput what = input(density, std::log(2.0) / 10, everywhere(3));
    const Image image = render(what, parallelCamera(Vec3(4, -20, 4), Vec3(4, 0, 4), 1, 1), options).image;
    EXPECT_NEAR(image.pixels[0], 0.5 * 3 + 0.5 * 0.2, kFloatTolerance);
    EXPECT_NEAR(image.pixels[1], 0.5 * 3 + 0.5 * 0.4, kFloatTolerance);
    EXPECT_NEAR(image.pixels[2], 0.5 * 3 + 0.5 * 8.0, kFloatTolerance);
    EXPECT_NEAR(image.pixels[3], 0.5, kFloatTolerance);
}

TEST(Render, ColouredRadiosityKeepsItsChannels) {
    const auto density = box({Coord(0), Coord(9)}, 1);
    const Vec3SGrid::Ptr radiosity = Vec3SGrid::create(openvdb::Vec3s(1, 0.5f, 0));
    const Image image =
        render(input(density, 0.1, radiosity), parallelCamera(Vec3(4, -20, 4), Vec3(4, 0, 4), 1, 1)).image;
    const double alpha = 1 - std::exp(-1.0);
    EXPECT_NEAR(image.pixels[0], alpha, kFloatTolerance);
    EXPECT_NEAR(image.pixels[1], 0.5 * alpha, kFloatTolerance);
    EXPECT_EQ(image.pixels[2], 0);
}

// L = integral of S(s) sigma exp(-sigma s) ds for S = s + 200 (s from the entry) is (1 - (1 + tau) exp(-tau)) / sigma +
// 200 alpha. S is linear in space, so a grid four times as coarse and turned holds exactly the same function.
TEST(Render, RadiosityMayHaveAnotherTransform) {
    const auto density = box({Coord(0), Coord(39)}, 1);
    FloatGrid::Ptr coarse = FloatGrid::create();
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.preScale(openvdb::Vec3d(4));
    matrix.postRotate(openvdb::math::Z_AXIS, 0.3);
    coarse->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    auto accessor = coarse->getAccessor();
    const CoordBBox all(Coord(-20), Coord(20));
    for (auto ijk = all.begin(); ijk != all.end(); ++ijk)
        accessor.setValue(*ijk, float(coarse->indexToWorld(*ijk).y() + 200.5));
    const double sigma = 0.05, tau = 40 * sigma;
    RenderOptions options;
    options.step = 0.125;  // the ramps before entry and exit matter in second order
    const Image image =
        render(input(density, sigma, coarse), parallelCamera(Vec3(20, -50, 20), Vec3(20, 0, 20), 8, 3), options).image;
    const double expected = (1 - (1 + tau) * std::exp(-tau)) / sigma;
    for (int p = 0; p < 9; ++p)
        EXPECT_NEAR(image.pixels[4 * p] - 200 * image.pixels[4 * p + 3], expected, 1e-3 * expected);
}

// Density grows along k, so the normal is -k everywhere; voxels twice as long in k than in i test that it is a normal
// of world space. The ray is used up inside the ramp, so L = cos.
TEST(Render, LambertIsTheCosineToTheSurface) {
    const auto density = filled({Coord(-40, -40, 0), Coord(40, 40, 60)}, [](const Coord& p) { return float(p.z()); });
    density->setTransform(openvdb::math::Transform::createLinearTransform(
        openvdb::Mat4d(openvdb::math::scale<openvdb::Mat4d>(openvdb::Vec3d(1, 1, 2)))));
    RenderOptions options;
    options.lambert = true;
    const auto seenFrom = [&](const Vec3& eye, const Vec3& target) {
        return render(input(density, 0.05), parallelCamera(eye, target, 1e-6, 1), options).image.pixels[0];
    };
    for (double angle : {0.0, 30.0, 60.0}) {
        const Vec3 view(std::sin(angle * kPi / 180), 0, std::cos(angle * kPi / 180));
        EXPECT_NEAR(seenFrom(view * -70, Vec3(0)), std::cos(angle * kPi / 180), 2e-3) << angle;
    }
    // From behind only the last slice, where density falls off again, faces the eye; inside it faces away.
    EXPECT_LT(seenFrom(Vec3(0, 0, 300), Vec3(0, 0, 0)), 1);
}

TEST(Render, LambertHasNoEffectWhereThereIsNoSurface) {
    FloatGrid::Ptr density = FloatGrid::create();
    density->sparseFill({Coord(-50), Coord(50)}, 1.0f);
    RenderOptions options;
    options.lambert = true;
    const Image image = render(input(density, 1), parallelCamera(Vec3(0), Vec3(0, 1, 0), 1, 2), options).image;
    EXPECT_LT(worstColour(image, 1), kFloatTolerance);
}

TEST(Render, SamplesAverageOverThePixel) {
    const auto density = noise({Coord(0), Coord(15)});
    Camera camera = threeQuarter(*density, 16);
    RenderOptions options;
    options.samples = 3;
    const Image few = render(input(density, 1), camera, options).image;
    options.samples = 1;
    camera.width = camera.height = 48;
    const Image many = render(input(density, 1), camera, options).image;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            double mean = 0;
            for (int s = 0; s < 9; ++s) mean += many.at(3 * x + s % 3, 3 * y + s / 3)[0] / 9;
            EXPECT_NEAR(few.at(x, y)[0], mean, kFloatTolerance);
        }
}

TEST(Render, SameBitsForAnyNumberOfThreads) {
    const auto density = noise({Coord(0), Coord(30)});
    const auto picture = [&](int threads) {
        ThreadLimit limit(threads);
        return render(input(density, 0.1), threeQuarter(*density, 50)).image.pixels;
    };
    EXPECT_EQ(picture(1), picture(3));
}

TEST(Render, EmptyVolumeShowsTheBackground) {
    RenderOptions options;
    options.background = grey(0.25f);
    const Image image = render(input(FloatGrid::create(), 1), Camera(), options).image;
    EXPECT_EQ(worstColour(image, 0.25), 0);
    EXPECT_EQ(image.pixels[3], 0);
    EXPECT_TRUE(worldBounds(*FloatGrid::create()).isEmpty());
}

TEST(Render, InactiveValuesAreNoMedium) {
    const auto clean = box({Coord(0), Coord(9)}, 1);
    FloatGrid::Ptr dirty = clean->deepCopy();
    dirty->tree().setValueOff(Coord(20, 4, 4), 100);
    const Camera camera = threeQuarter(*box({Coord(0), Coord(21)}, 1), 32);
    EXPECT_EQ(render(input(dirty, 0.1), camera).image.pixels, render(input(clean, 0.1), camera).image.pixels);
    FloatGrid::Ptr background = FloatGrid::create(3);
    background->denseFill({Coord(0), Coord(9)}, 1);
    EXPECT_EQ(render(input(background, 0.1), camera).image.pixels, render(input(clean, 0.1), camera).image.pixels);
    EXPECT_EQ(zeroWhereInactive(clean), clean) << "no copy without need";
}

TEST(Render, OneVolumeServesSeveralPictures) {
    const auto density = noise({Coord(0), Coord(30)});
    const RenderInput what = input(density, 0.1, box({Coord(-1), Coord(31)}, 2));
    const RenderVolume volume(what);
    Camera camera = threeQuarter(*density, 24);
    for (int frame = 0; frame < 3; ++frame) {
        camera = orbit(camera, 2);
        EXPECT_EQ(render(volume, camera).image.pixels, render(what, camera).image.pixels);
    }
}

// A huge tile has no blocks of its own but where radiosity has leaves; both kinds meet in one ray.
TEST(Render, LeavesOfRadiosityInAHugeTile) {
    FloatGrid::Ptr density = FloatGrid::create();
    density->tree().addTile(2, Coord(0), 1, true);  // voxels 0..127
    FloatGrid::Ptr radiosity = FloatGrid::create(1);
    radiosity->denseFill({Coord(40), Coord(80)}, 1);
    RenderOptions options;
    options.background = grey(1);
    const Image image = render(input(density, 0.02, radiosity), threeQuarter(*density, 24), options).image;
    EXPECT_LT(worstColour(image, 1), kFloatTolerance);
    EXPECT_GT(image.at(12, 12)[3], 0.5f);
}

TEST(Render, StopsWhenAskedTo) {
    const auto density = box({Coord(0), Coord(9)}, 1);
    int calls = 0;
    const RenderResult result =
        render(input(density, 1), threeQuarter(*density, 512), {}, [&](const std::string& stage, double fraction) {
            EXPECT_EQ(stage, "render");
            EXPECT_TRUE(fraction >= 0 && fraction < 1);
            return ++calls < 3;
        });
    EXPECT_EQ(calls, 3);
    EXPECT_FALSE(result.complete);
    EXPECT_EQ(result.image.pixels.size(), 512u * 512 * 4);
}

TEST(Render, RefusesBadValuesAndNamesTheVoxel) {
    for (float bad : {-1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        const auto density = box({Coord(0), Coord(9)}, 1);
        density->tree().setValue(Coord(3, 4, 5), bad);
        try {
            render(input(density, 1), Camera());
            FAIL();
        } catch (const InvalidArgument& e) {
            EXPECT_NE(std::string(e.what()).find("(3, 4, 5)"), std::string::npos) << e.what();
        }
    }
    FloatGrid::Ptr tile = FloatGrid::create();
    tile->tree().addTile(2, Coord(0), -1, true);
    EXPECT_THROW(render(input(tile, 1), Camera()), InvalidArgument);
    EXPECT_THROW(render(input(box({Coord(0), Coord(9)}, 1), 1, tile), Camera()), InvalidArgument);
}

TEST(Render, RefusesWhatItCannotRender) {
    const auto density = box({Coord(0), Coord(9)}, 1);
    EXPECT_THROW(render(input(nullptr, 1), Camera()), InvalidArgument);
    EXPECT_THROW(render(input(density, 1, nullptr), Camera()), InvalidArgument);
    EXPECT_THROW(render(input(density, -1), Camera()), InvalidArgument);
    EXPECT_THROW(render(input(density, std::nan("")), Camera()), InvalidArgument);
    EXPECT_THROW(render(input(density, 1, test::otherGrid<openvdb::Int32Grid>()), Camera()), InvalidArgument);
    FloatGrid::Ptr frustum = density->deepCopy();
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(10)), 0.5, 10));
    EXPECT_THROW(render(input(frustum, 1), Camera()), InvalidArgument);
    const auto refuses = [&](const std::function<void(RenderOptions&)>& spoil) {
        RenderOptions options;
        spoil(options);
        EXPECT_THROW(render(input(density, 1), Camera(), options), InvalidArgument);
    };
    for (double step : {0.0, -1.0, 1e-9, 0.0099, 9.0, std::nan("")}) refuses([&](RenderOptions& o) { o.step = step; });
    for (int samples : {0, 65}) refuses([&](RenderOptions& o) { o.samples = samples; });
    refuses([](RenderOptions& o) { o.background.y = -1; });
    refuses([](RenderOptions& o) { o.minTransmittance = 1; });
}
