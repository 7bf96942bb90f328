// What shines by itself, in pictures: the integral of q T / (4 pi) along each ray, whatever the smoke.
#include "raysweep/render/render.h"

#include "raysweep/core/directions.h"
#include "raysweep/render/transmittance.h"
#include "support/worst.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Interpolation.h>

#include <cmath>
#include <functional>
#include <random>

using namespace raysweep;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;
using openvdb::math::Transform;

namespace {

constexpr int kEdge = 24;

using Value = std::function<double(const Coord&)>;

FloatGrid::Ptr gridOf(const Value& value, int edge = kEdge) {
    const auto grid = FloatGrid::create();
    auto accessor = grid->getAccessor();
    for (const Coord& at : CoordBBox(Coord(0), Coord(edge - 1)))
        if (const double v = value(at); v > 0) accessor.setValue(at, float(v));
    return grid;
}

/// Uniform in [0,1), one for each voxel.
double randomAt(const Coord& at) {
    std::mt19937 random(unsigned(at.x()) * 73856093u ^ unsigned(at.y()) * 19349663u ^ unsigned(at.z()) * 83492791u);
    return std::uniform_real_distribution<double>(0, 1)(random);
}

double smokeNoise(const Coord& at) {
    return std::pow(10, -6 * randomAt(at));
}

RenderInput inputOf(const FloatGrid::Ptr& density, double extinction, const openvdb::GridBase::Ptr& emission) {
    return {density, extinction, FloatGrid::create(0.0f), emission};
}

/// A parallel view of a cube of `edge` world units at `middle`, from `towards` it.
Camera viewOf(const Vec3& middle, const Vec3& from, double width, int pixels) {
    Camera camera;
    camera.projection = Camera::Projection::Orthographic;
    camera.eye = middle + from.normalized() * (4 * kEdge);
    camera.target = middle;
    camera.up = std::abs(from.normalized().z) < 0.9 ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
    camera.orthoWidth = width;
    camera.width = camera.height = pixels;
    return camera;
}

/// The integral along a ray by steps of a fiftieth of a voxel, in doubles.
double exact(const RenderInput& input, const Ray& ray, double length, int channel = 0) {
    constexpr double kStep = 0.02;
    const auto at = [&](const openvdb::GridBase& grid, const Vec3& p, int c) {
        const Vec3d index = grid.worldToIndex(Vec3d(p.x, p.y, p.z));
        if (grid.isType<FloatGrid>())
            return double(openvdb::tools::BoxSampler::sample(
                static_cast<const FloatGrid&>(grid).getConstUnsafeAccessor(), index));
        return double(
            openvdb::tools::BoxSampler::sample(static_cast<const Vec3SGrid&>(grid).getConstUnsafeAccessor(), index)[c]);
    };
    double sum = 0, depth = 0;
    for (double t = 0.5 * kStep; t < length; t += kStep) {
        const Vec3 p = ray.origin + ray.direction * t;
        const double step = at(*input.density, p, 0) * input.extinctionScale * kStep;
        sum += at(*input.emission, p, channel) * std::exp(-depth - 0.5 * step) * kStep;
        depth += step;
    }
    return sum / (4 * kPi);
}

/// Largest relative difference of pixels to the exact integrals; of those that see at least a hundredth of the most.
double worstPixel(const RenderInput& input, const Camera& camera, double step = RenderOptions().step) {
    RenderOptions options;
    options.step = step;
    const Image image = render(input, camera, options).image;
    std::vector<double> expected;
    const double length = 8 * kEdge;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            expected.push_back(exact(input, pixelRay(photoCamera(camera), x + 0.5, y + 0.5), length));
    const double most = *std::max_element(expected.begin(), expected.end());
    double worst = 0;
    for (std::size_t i = 0; i < expected.size(); ++i)
        if (expected[i] > 0.01 * most) test::raiseTo(worst, std::abs(double(image.pixels[4 * i]) / expected[i] - 1));
    EXPECT_GT(most, 0);
    return worst;
}

const Vec3 kMiddle(0.5 * (kEdge - 1));
const Vec3 kViews[] = {{0, 0, 1}, {-1, 0, 0}, {0.3, 1, 0.2}, {1, 1, 1}, {-0.7, 0.1, -0.4}};

}  // namespace

// The specimens: fire of 1 W/unit^3 in smoke so thin that it hides nothing. Each pixel shows the column of fire, 24
// voxels of it. Interpolated edges are ramps, which samples an even number to a voxel add up exactly: floats are left.
TEST(Fire, InThinSmokeIsSeenAsTheColumnOfItThatThereIs) {
    const FloatGrid::Ptr fire = gridOf([](const Coord&) { return 1; });
    const Value hole = [](const Coord& at) { return at == Coord(12) ? 1e-6 : 1; };
    const Value steps = [](const Coord& at) { return at.x() < 12 ? 1e-6 : 1; };
    double worst = 0;
    for (const Value& smoke : {Value([](const Coord&) { return 1; }), hole, Value(smokeNoise), steps})
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 from(0);
            from[axis] = 1;
            const Image image = render(inputOf(gridOf(smoke), 1e-7, fire), viewOf(kMiddle, from, kEdge - 2, 32)).image;
            for (std::size_t i = 0; i < image.pixels.size(); i += 4)
                test::raiseTo(worst, std::abs(double(image.pixels[i]) / (kEdge / (4 * kPi)) - 1));
        }
    std::printf("  worst pixel off by %.2g\n", worst);
    EXPECT_LE(worst, 3e-6);  // smoke hides 24e-7 of it
}

// Against the integral in small steps: smoke over six decades, sharp edges, fire where the smoke is not, and thick
// smoke before and in the fire, from all sides.
TEST(Fire, IsTheIntegralOfEmissionAndTransmittanceAlongEachRay) {
    const Value even = [](const Coord&) { return 1; };
    const Value against = [](const Coord& at) { return 1 - smokeNoise(at); };
    const Value ball = [](const Coord& at) { return (Vec3(at.x(), at.y(), at.z()) - kMiddle).length() < 8 ? 3 : 0; };
    const Value halves = [](const Coord& at) { return at.y() < 12 ? 1 : 0; };
    const Value otherHalf = [](const Coord& at) { return at.y() < 12 ? 0 : 1; };
    struct Case {
        const char* name;
        Value smoke, fire;
        double extinction;
    };
    const Case cases[] = {{"noise", smokeNoise, even, 1},

                          {"opposed", smokeNoise, against, 1},
                          {"a ball in thick smoke", even, ball, 0.3},
                          {"smoke within fire", ball, even, 0.1},
                          {"side by side", halves, otherHalf, 1},
                          {"one behind the other", halves, halves, 1}};
    for (const Case& c : cases) {
        double worst = 0;
        for (const Vec3& from : kViews)
            test::raiseTo(worst, worstPixel(inputOf(gridOf(c.smoke), c.extinction, gridOf(c.fire)),
                                            viewOf(kMiddle, from, kEdge, 12)));
        std::printf("  %s: worst pixel off by %.2g\n", c.name, worst);
        EXPECT_LE(worst, 0.01) << c.name;
    }
}

// Its own voxels, whatever those of the smoke: finer, coarser, moved, of unequal edges, turned, sheared; coloured, too.
TEST(Fire, IsSampledOnVoxelsOfItsOwn) {
    const FloatGrid::Ptr smoke = gridOf(smokeNoise);
    for (int kind = 0; kind < 5; ++kind) {
        const double edge = kind == 0 ? 0.2 : kind == 1 ? 4 : 1;
        const auto transform = Transform::createLinearTransform(edge);
        if (kind == 2) transform->preScale(Vec3d(0.3, 2, 1));
        if (kind == 3) transform->postRotate(0.6, openvdb::math::Y_AXIS);
        if (kind == 4) transform->postShear(0.4, openvdb::math::X_AXIS, openvdb::math::Z_AXIS);
        const int count = kind == 0 ? 50 : kind == 1 ? 5 : 16;
        const auto fire = gridOf([](const Coord& at) { return 0.2 + randomAt(at); }, count);
        transform->postTranslate(Vec3d(3.3, 2.1, 4.7));
        fire->setTransform(transform);
        const Vec3d inside = fire->indexToWorld(Vec3d(0.5 * count));
        double worst = 0;
        for (const Vec3& from : kViews)
            test::raiseTo(worst, worstPixel(inputOf(smoke, 0.5, fire),
                                            viewOf(Vec3(inside.x(), inside.y(), inside.z()), from, 8, 8)));
        std::printf("  transform %d: worst pixel off by %.2g\n", kind, worst);
        EXPECT_LE(worst, 0.01) << kind;
    }
}

TEST(Fire, HasColoursAndNoOpacity) {
    const auto fire = Vec3SGrid::create();
    fire->denseFill({Coord(0), Coord(kEdge - 1)}, Vec3s(3, 2, 0.5f));
    const auto nothing = FloatGrid::create();
    const Image image = render(inputOf(nothing, 1, fire), viewOf(kMiddle, {0, 0, 1}, 8, 8)).image;
    const double column = kEdge / (4 * kPi);
    for (std::size_t i = 0; i < image.pixels.size(); i += 4) {
        EXPECT_NEAR(image.pixels[i], 3 * column, 1e-5 * column);
        EXPECT_NEAR(image.pixels[i + 1], 2 * column, 1e-5 * column);
        EXPECT_NEAR(image.pixels[i + 2], 0.5 * column, 1e-5 * column);
        EXPECT_EQ(image.pixels[i + 3], 0);
    }
}

// Tiles are seen as their voxels are, and what is inactive is none.
TEST(Fire, IsWhatIsActive) {
    const auto tile = FloatGrid::create(5.0f);  // a background that means nothing
    tile->tree().addTile(2, Coord(0), 1.0f, true);
    const auto voxels = FloatGrid::create();
    voxels->denseFill({Coord(0), Coord(127)}, 1.0f);
    const auto smoke = gridOf(smokeNoise);
    const Camera camera = viewOf(Vec3(64), {0.3, 1, 0.2}, 250, 24);
    const Image a = render(inputOf(smoke, 1, tile), camera).image, b = render(inputOf(smoke, 1, voxels), camera).image;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) ASSERT_EQ(a.pixels[i], b.pixels[i]);
}

// Ten thousand times brighter than what hides it: rays must not end early.
TEST(Fire, ShinesThroughThickSmoke) {
    const auto smoke = gridOf([](const Coord& at) { return at.z() >= 12 ? 1 : 0; });
    const auto fire = gridOf([](const Coord& at) { return at.z() < 11 ? 1 : 0; });
    const Image image = render(inputOf(smoke, 1, fire), viewOf(kMiddle, {0, 0, 1}, 8, 4)).image;
    EXPECT_NEAR(double(image.pixels[0]) / (11 / (4 * kPi) * std::exp(-12)), 1, 1e-3);
}

TEST(Fire, OfNothingIsNotSeen) {
    const auto smoke = gridOf(smokeNoise);
    const Camera camera = viewOf(kMiddle, {0.3, 1, 0.2}, 30, 16);
    RenderInput input{smoke, 1, FloatGrid::create(1.0f), nullptr};
    const Image without = render(input, camera).image;
    input.emission = gridOf([](const Coord&) { return 0; });
    EXPECT_EQ(render(input, camera).image.pixels, without.pixels);
    const auto bad = gridOf([](const Coord&) { return 1; });
    bad->tree().setValueOn(Coord(3), -1.0f);
    input.emission = bad;
    EXPECT_THROW(RenderVolume{input}, InvalidArgument);
}

// Two steps with a gap: T falls in the first and in the second, and nowhere else.
TEST(TransmittanceAlongRay, IsIntegratedWhereItIsConstantAndWhereItFalls) {
    TransmittanceAlongRay seen;
    const double depth = 0.7;
    seen.add(2, 3, 1, 1 - std::exp(-depth));
    seen.add(5, 5.5, std::exp(-depth), 1 - std::exp(-2.0));
    EXPECT_NEAR(seen.integral(0, 1), 1, 1e-12);
    EXPECT_NEAR(seen.integral(1, 2.5), 1 + (1 - std::exp(-0.35)) / 0.7, 1e-12);
    EXPECT_NEAR(seen.integral(2.5, 5), (std::exp(-0.35) - std::exp(-0.7)) / 0.7 + 2 * std::exp(-0.7), 1e-12);
    EXPECT_NEAR(seen.integral(5, 7), std::exp(-0.7) * (1 - std::exp(-2.0)) / 4 + 1.5 * std::exp(-2.7), 1e-12);
    seen.endInTheDark();
    EXPECT_EQ(seen.integral(8, 9), 0);
}

// A float's opacity is 1 from a depth of 17 on.
TEST(TransmittanceAlongRay, NothingComesThroughAStepOfOpacityOne) {
    TransmittanceAlongRay seen;
    seen.add(2, 3, 1, 1);
    EXPECT_NEAR(seen.integral(1, 2), 1, 1e-12);
    EXPECT_NEAR(seen.integral(2, 3), 0, 1.0 / 700 + 1e-12);  // of the depth that stands for it
    EXPECT_EQ(seen.integral(3, 4), 0);
}
