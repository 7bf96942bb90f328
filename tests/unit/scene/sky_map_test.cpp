#include "raysweep/scene/sky_map.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/painted_map.h"
#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

SkyMapOptions withSuns(int suns) {
    SkyMapOptions options;
    options.suns = suns;
    return options;
}

/// Radiance that light travelling in `direction` has.
Vec3 radianceAlong(const SkyMapLight& light, const Vec3& direction) {
    const Color factor = light.sky.profile(direction);
    return Vec3(light.sky.radiance.x * factor.x, light.sky.radiance.y * factor.y, light.sky.radiance.z * factor.z);
}

/// Integral over the sphere of the sky, which is constant in cells of a `rows`th of the half turn, and of all suns.
Vec3 integralOf(const SkyMapLight& light, int rows) {
    Vec3 sum(0);
    for (const Sun& sun : light.suns) sum += Vec3(sun.irradiance.x, sun.irradiance.y, sun.irradiance.z);
    const Image cells(2 * rows, rows, 1);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < 2 * rows; ++x)
            sum += radianceAlong(light, -towardsPixel((x + 0.5) / (2 * rows), (y + 0.5) / rows)) *
                   pixelSolidAngle(cells, y);
    return sum;
}

void expectEnergyKept(const Image& map, const SkyMapLight& light, int rows = 32) {
    const Vec3 exact = raysweep::test::integralOf(map), found = integralOf(light, rows);
    // Radiance and its factors are kept as floats.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / exact[c], 1, 2e-7) << c;
}

/// Values that repeat nowhere, and here and there one that is a thousand times as bright.
Image unevenMap(int width, int height) {
    Image map(width, height, 3);
    for (std::size_t i = 0; i < map.pixels.size(); ++i) {
        map.pixels[i] = float(std::fmod(0.618034 * double(i), 1.0));
        if (i % 997 < 3) map.pixels[i] *= 1000;
    }
    return map;
}

std::string complaintAbout(const Image& map, const SkyMapOptions& options = {}) {
    try {
        lightFromSkyMap(map, options);
    } catch (const InvalidArgument& e) {
        return e.what();
    }
    return "no error";
}

}  // namespace

TEST(SkyMap, LiesAsSaid) {
    // Towards the picture's middle, a quarter of its width to the left, and its top.
    const Vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    const struct {
        int up;
        Vec3 middle, left, top;
    } cases[] = {{2, x, y, z}, {1, z, x, y}, {0, y, z, x}};
    for (const auto& c : cases) {
        const auto colour = [](const Vec3& towards) {
            return Color(inDisc(towards, {1, 0, 0}, 0.2) ? 1 : 0, inDisc(towards, {0, 1, 0}, 0.2) ? 1 : 0,
                         inDisc(towards, {0, 0, 1}, 0.2) ? 1 : 0);
        };
        SkyMapOptions options = withSuns(0);
        options.up = c.up;
        const SkyMapLight light = lightFromSkyMap(paintedMap(64, 32, colour), options);
        EXPECT_EQ(radianceAlong(light, -c.middle), x) << c.up;  // red
        EXPECT_EQ(radianceAlong(light, -c.left), y) << c.up;
        EXPECT_EQ(radianceAlong(light, -c.top), z) << c.up;
        for (const Vec3& opposite : {c.middle, c.left, c.top}) EXPECT_EQ(radianceAlong(light, opposite), Vec3(0));
        // A quarter turn, seen from above against the clock, brings the middle to the left.
        options.rotate = 90;
        EXPECT_EQ(radianceAlong(lightFromSkyMap(paintedMap(64, 32, colour), options), -c.left), x) << c.up;
    }
}

// Read off pictures that Blender 3.4.1 (Cycles) made of a map whose colour is its own coordinates.
TEST(SkyMap, LiesAsInBlender) {
    Image map(64, 32, 3);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x) {
            map.at(x, y)[0] = float((x + 0.5) / 64);
            map.at(x, y)[1] = float((y + 0.5) / 32);
        }
    const struct {
        Vec3 towards;
        double u, v;
    } seen[] = {{{1, 0, .1}, .501, .467},
                {{0, 1, .1}, .251, .467},
                {{-1, -.3, .1}, .955, .468},
                {{0, -1, .1}, .751, .467},
                {{1, 0, -.5}, .501, .646}};
    const SkyMapLight light = lightFromSkyMap(map, withSuns(0));
    for (const auto& s : seen) {
        const Vec3 found = radianceAlong(light, -s.towards.normalized());
        // Blender interpolates, here a direction has the colour of its pixel: half a pixel, and a little as the
        // pictures had 8 bits.
        EXPECT_NEAR(found.x, s.u, 0.5 / 64 + 0.003);
        EXPECT_NEAR(found.y, s.v, 0.5 / 32 + 0.003);
    }
}

TEST(SkyMap, KeepsAllPower) {
    for (const int height : {2, 3, 32, 33, 100, 300})
        for (const int more : {-1, 0, 1})
            for (const int suns : {0, 3, 16}) {
                if (height == 2 && more < 0) continue;
                SCOPED_TRACE(testing::Message() << height << " rows, " << more << " column more, " << suns << " suns");
                const Image map = unevenMap(2 * height + more, height);
                SkyMapOptions options = withSuns(suns);
                const SkyMapLight light = lightFromSkyMap(map, options);
                EXPECT_LE(int(light.suns.size()), suns);
                EXPECT_TRUE(light.sky.colouredProfile);
                const Vec3 exact = raysweep::test::integralOf(map);
                if (more == 0 || height > 32) expectEnergyKept(map, light, std::min(height, 32));
                EXPECT_GE(light.sunShare, 0);
                EXPECT_LE(light.sunShare, 1);
                Vec3 inSuns(0);
                for (const Sun& sun : light.suns) inSuns += Vec3(sun.irradiance.x, sun.irradiance.y, sun.irradiance.z);
                EXPECT_NEAR(light.sunShare, (inSuns.x + inSuns.y + inSuns.z) / (exact.x + exact.y + exact.z), 1e-6);
            }
}

TEST(SkyMap, ScaleMultipliesEverything) {
    const Image map = unevenMap(200, 100);
    SkyMapOptions options;
    const SkyMapLight one = lightFromSkyMap(map, options);
    options.scale = 2;
    const SkyMapLight two = lightFromSkyMap(map, options);
    EXPECT_EQ(integralOf(two, 32), integralOf(one, 32) * 2.0);
    EXPECT_EQ(two.sunShare, one.sunShare);
}

TEST(SkyMap, AConstantMapIsAConstantSky) {
    for (const int height : {2, 31, 200}) {
        const SkyMapLight light =
            lightFromSkyMap(paintedMap(2 * height, height, [](const Vec3&) { return Color(0.3f, 0.3f, 0.3f); }));
        EXPECT_TRUE(light.suns.empty());
        EXPECT_EQ(light.sunShare, 0);
        EXPECT_FALSE(light.sky.colouredProfile);
        EXPECT_EQ(light.sky.radiance, grey(0.3f));
        for (int y = 0; y < 50; ++y)
            for (int x = 0; x < 50; ++x) EXPECT_EQ(light.sky.profile(towardsPixel(x / 49.0, y / 49.0)), grey(1));
    }
}

TEST(SkyMap, ASmallDiscIsASun) {
    const double radius = 0.01, radiance = 5000, background = 0.1;
    for (const Vec3& centre : {Vec3(0.6, 0.64, 0.48), Vec3(-1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0.01, -1).normalized()}) {
        const auto colour = [&](const Vec3& towards) {
            return inDisc(towards, centre, radius) ? Color(float(radiance), float(radiance), float(radiance) / 2)
                                                   : grey(float(background));
        };
        const Image map = paintedMap(2048, 1024, colour);
        const SkyMapLight light = lightFromSkyMap(map);
        ASSERT_EQ(light.suns.size(), 1u);
        const Sun& sun = light.suns.front();
        EXPECT_NEAR(sun.direction.length(), 1, 1e-12);
        // A third of a pixel: the painted disc's pixels are in or out.
        EXPECT_LT((sun.direction + centre).length(), 1e-3);
        const Vec3 all = raysweep::test::integralOf(map);
        const double mean = (all.x + all.y + all.z) / 3 / (4 * kPi);
        // Solid angle of the painted disc, from what it adds to the integral; what is above four times the mean is the
        // sun's.
        const double solidAngle = (all.x - 4 * kPi * background) / (radiance - background);
        EXPECT_NEAR(solidAngle / (2 * kPi * (1 - std::cos(radius))), 1, 0.2);
        const double discMean = radiance * 2.5 / 3, excess = (discMean - 4 * mean) / discMean;
        EXPECT_NEAR(double(sun.irradiance.x) / (radiance * solidAngle * excess), 1, 1e-5);
        EXPECT_NEAR(double(sun.irradiance.z) / double(sun.irradiance.x), 0.5, 1e-6);
        EXPECT_NEAR(light.sunShare, discMean * solidAngle * excess / (mean * 4 * kPi), 1e-6);
        expectEnergyKept(map, light);
        // What is left is the background, and a disc of four times the mean.
        EXPECT_NEAR(radianceAlong(light, centre).x, background, 1e-6);
        EXPECT_LE(maxComponent(light.sky.radiance), 4 * mean * 1.2 + 1e-6);
    }
}

TEST(SkyMap, SeveralSunsAreToldApart) {
    const Vec3 lamps[] = {Vec3(1, 0, 0), Vec3(-1, 0.02, 0).normalized(), Vec3(0, 0, 1), Vec3(0.1, 0, 1).normalized(),
                          Vec3(-1, -2, -3).normalized()};
    const auto colour = [&](const Vec3& towards) {
        for (int i = 0; i < 5; ++i)
            if (inDisc(towards, lamps[i], 0.008)) return grey(float(1000 * (i + 1)));
        return grey(0.2f);
    };
    const Image map = paintedMap(1600, 800, colour);
    const SkyMapLight light = lightFromSkyMap(map);
    ASSERT_EQ(light.suns.size(), 5u);
    for (int i = 0; i < 5; ++i) {
        int near = 0;
        for (const Sun& sun : light.suns)
            if ((sun.direction + lamps[i]).length() < 1e-3) {
                ++near;
                const double exact = 1000 * (i + 1) * 2 * kPi * (1 - std::cos(0.008));
                EXPECT_NEAR(double(sun.irradiance.x) / exact, 1, 0.1) << i;  // edges, as above, of smaller discs
            }
        EXPECT_EQ(near, 1) << i;
    }
    expectEnergyKept(map, light);
    // With fewer suns than lamps no sun stands between two that are far apart.
    const SkyMapLight fewer = lightFromSkyMap(map, withSuns(3));
    EXPECT_LE(fewer.suns.size(), 3u);
    for (const Sun& sun : fewer.suns) {
        double nearest = 4;
        for (const Vec3& lamp : lamps) nearest = std::min(nearest, (sun.direction + lamp).length());
        EXPECT_LT(nearest, 0.1);
    }
    expectEnergyKept(map, fewer);
}

TEST(SkyMap, LargeBrightPartsAreLeftToTheSweeps) {
    const auto half = [](const Vec3& towards) { return grey(towards.z > 0 ? 1 : 0); };
    EXPECT_TRUE(lightFromSkyMap(paintedMap(256, 128, half)).suns.empty());
    const auto large = [](const Vec3& towards) { return grey(inDisc(towards, {0, 1, 0}, 0.45) ? 10 : 0); };
    const Image map = paintedMap(512, 256, large);
    EXPECT_LT(lightFromSkyMap(map).sunShare, 0.1);
    expectEnergyKept(map, lightFromSkyMap(map));
    // Stars everywhere are no 16 suns.
    const Image stars = unevenMap(512, 256);
    EXPECT_LT(lightFromSkyMap(stars).sunShare, 0.05);
}

TEST(SkyMap, TurnsWithItsRotation) {
    const Image map = unevenMap(512, 256);
    for (int up = 0; up < 3; ++up) {
        SkyMapOptions options = withSuns(64);
        options.up = up;
        options.rotate = -270;
        const SkyMapLight turned = lightFromSkyMap(map, options);
        options.rotate = 0;
        const SkyMapLight light = lightFromSkyMap(map, options);
        ASSERT_EQ(turned.suns.size(), light.suns.size());
        for (std::size_t i = 0; i < light.suns.size(); ++i) {
            EXPECT_LT((turned.suns[i].direction - quarterTurn(light.suns[i].direction, up)).length(), 1e-12);
            EXPECT_EQ(turned.suns[i].irradiance, light.suns[i].irradiance);
        }
        for (int n = 0; n < 500; ++n) {
            const Vec3 direction = towardsPixel(std::fmod(0.618034 * n, 1.0), (n + 0.3) / 500);
            EXPECT_EQ(turned.sky.profile(quarterTurn(direction, up)), light.sky.profile(direction));
        }
    }
    // By any angle: a part of the width.
    SkyMapOptions options = withSuns(0);
    options.rotate = 360.0 / 64 * 5;
    const SkyMapLight turned = lightFromSkyMap(map, options), light = lightFromSkyMap(map, withSuns(0));
    for (int x = 0; x < 64; ++x)
        EXPECT_EQ(turned.sky.profile(-towardsPixel((x + 0.5) / 64, 0.4)),
                  light.sky.profile(-towardsPixel((x + 5.5) / 64, 0.4)));
}

TEST(SkyMap, TakesGreyAndColourWithOrWithoutAlpha) {
    for (const int channels : {1, 2, 3, 4}) {
        Image map(8, 4, channels);
        for (std::size_t i = 0; i < map.pixels.size(); ++i) map.pixels[i] = 0.5f;
        if (channels % 2 == 0)
            for (std::size_t i = 0; i < map.pixels.size(); i += std::size_t(channels))
                map.pixels[i + std::size_t(channels) - 1] = 0.1f;
        const SkyMapLight light = lightFromSkyMap(map);
        EXPECT_EQ(light.sky.radiance, grey(0.5f)) << channels;
        EXPECT_FALSE(light.sky.colouredProfile);
        if (channels < 3) continue;
        map.at(3, 2)[1] = 0.6f;
        EXPECT_TRUE(lightFromSkyMap(map).sky.colouredProfile);
    }
    const SkyMapLight black = lightFromSkyMap(Image(8, 4, 3));
    EXPECT_EQ(black.sky.radiance, grey(0));
    EXPECT_EQ(black.sunShare, 0);
    EXPECT_TRUE(black.suns.empty());
}

TEST(SkyMap, RefusesWhatIsNoSkyMap) {
    EXPECT_NE(complaintAbout(Image(64, 64, 3)).find("64 x 64"), std::string::npos);
    EXPECT_NE(complaintAbout(Image(66, 32, 3)).find("twice as wide as high"), std::string::npos);
    EXPECT_EQ(complaintAbout(Image(65, 32, 3)), "no error");
    EXPECT_NE(complaintAbout(Image(2, 1, 3)).find("at least 4 x 2"), std::string::npos);
    EXPECT_NE(complaintAbout(Image()).find("at least 4 x 2"), std::string::npos);
    for (const float bad : {-1e-6f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        Image map(64, 32, 3);
        map.at(5, 7)[1] = bad;
        EXPECT_NE(complaintAbout(map).find("column 5, row 7"), std::string::npos) << complaintAbout(map);
    }
    SkyMapOptions options;
    options.up = 3;
    EXPECT_NE(complaintAbout(Image(8, 4, 1), options).find("up 3: must be 0, 1 or 2"), std::string::npos);
    options = withSuns(-1);
    EXPECT_NE(complaintAbout(Image(8, 4, 1), options).find("suns -1: must be in"), std::string::npos);
    options = {};
    options.rotate = std::numeric_limits<double>::infinity();
    EXPECT_NE(complaintAbout(Image(8, 4, 1), options).find("rotate"), std::string::npos);
    options = {};
    options.scale = -1;
    EXPECT_NE(complaintAbout(Image(8, 4, 1), options).find("scale"), std::string::npos);
}
