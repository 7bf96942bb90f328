#include "raysweep/reconstruct/photo_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "raysweep/camera/pose_motion.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/image/image_io.h"
#include "raysweep/reconstruct/photo_hull.h"
#include "raysweep/reconstruct/photo_loss.h"
#include "raysweep/reconstruct/voxel_fit.h"
#include "unit/instruction_sets.h"
#include "unit/reconstruct/ball_pictures.h"
#include "unit/reconstruct/photo_experiment.h"

using namespace raysweep;

namespace {

/// A ball of even extinction and colour: what a ray sees of it follows from the length of its chord.
struct Ball {
    Vec3 center{0.1, -0.05, 0.08};
    double radius = 0.6;
    double extinction = 1.5;  ///< 1/world unit; light comes through, so that the inside is seen as well
    Color color{0.6f, 0.3f, 0.1f};

    double alpha(const Ray& ray) const { return 1 - std::exp(-extinction * test::chordOf(ray, center, radius)); }
};

/// The world's origin is in the middle.
std::vector<Photograph> photographsOf(const Ball& ball, int count, int size) {
    std::vector<Photograph> all;
    Camera camera;
    camera.fov = 40;
    camera.width = camera.height = size;
    for (const Vec3& place : test::placesAround(count)) {
        camera.eye = place;
        all.push_back(test::ballPicture(
            camera, [&](const Ray& ray) { return ball.alpha(ray); }, [&](const Ray&) { return ball.color; }));
    }
    return all;
}

VoxelMask fullMask() {
    VoxelMask mask;
    mask.fill(~std::uint64_t(0));
    return mask;
}

CompositeVoxel randomVoxel(std::mt19937& random, float low, float high) {
    std::uniform_real_distribution<float> uniform(low, high);
    return {uniform(random), uniform(random), uniform(random), uniform(random)};
}

}  // namespace

// E of photo_fit.h (1) in double, from the curve itself, with central differences: the table's slope is that of its
// chords, which differ from the curve's by up to 2 % at its darkest bend and 1e-4 elsewhere; colours here are brighter.
TEST(PhotoLoss, DerivativeLikeDifferences) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0.05f, 0.9f);
    const Backdrops backdrops{0.5f, 0.1f};
    for (int n = 0; n < 100; ++n) {
        float pixel[4] = {0, 0, 0, uniform(random)};
        for (int c = 0; c < 3; ++c) pixel[c] = pixel[3] * uniform(random);
        const PixelTarget target = pixelTarget(pixel);
        double seen[4] = {uniform(random), 0, 0, 0};  // transmittance, red, green, blue
        for (int c = 1; c < 4; ++c) seen[c] = (1 - seen[0]) * uniform(random);
        const auto loss = [&](const double* s) {
            const double alpha = 1 - s[0], alphaError = alpha - pixel[3];
            double sum = 3 * backdrops.variance * alphaError * alphaError;
            for (int c = 0; c < 3; ++c) {
                const auto encode = [](double x) { return 1.055 * std::pow(x, 1 / 2.4) - 0.055; };
                const double error = encode(s[c + 1] / alpha) * alpha - encode(double(pixel[c]) / pixel[3]) * pixel[3] -
                                     backdrops.mean * alphaError;
                sum += error * error;
            }
            return sum;
        };
        const RayColor color{float(seen[0]), float(seen[1]), float(seen[2]), float(seen[3])};
        RayColor derivative;
        EXPECT_NEAR(pixelLoss(target, color, backdrops, derivative), loss(seen), 1e-4);  // the table's error, as below
        double squares = 0;
        for (const float r : pixelResidual(target, color, backdrops)) squares += double(r) * r;
        EXPECT_NEAR(squares, loss(seen), 1e-4);  // the table's error, twice what differs
        for (int i = 0; i < 4; ++i) {
            double more[4], less[4];
            std::copy_n(seen, 4, more);
            std::copy_n(seen, 4, less);
            more[i] += 1e-5;
            less[i] -= 1e-5;
            const double expected = (loss(more) - loss(less)) / 2e-5;
            EXPECT_NEAR((&derivative.transmittance)[i], expected, 2e-3 * std::max(0.1, std::abs(expected)))
                << n << " " << i;
        }
    }
}

TEST(PhotoLoss, NothingWhereTheyAgree) {
    const float pixel[4] = {0.2f, 0.1f, 0.05f, 0.5f};
    RayColor derivative;
    EXPECT_NEAR(pixelLoss(pixelTarget(pixel), {0.5f, 0.2f, 0.1f, 0.05f}, {}, derivative), 0, 1e-12);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR((&derivative.transmittance)[i], 0, 1e-6);
}

// What sees nothing and should has a finite slope: extinction must be able to grow from nothing.
TEST(PhotoLoss, FiniteWhereNothingIsSeen) {
    const float pixel[4] = {0.2f, 0.1f, 0.05f, 0.5f};
    RayColor derivative;
    pixelLoss(pixelTarget(pixel), {1, 0, 0, 0}, {}, derivative);
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(std::isfinite((&derivative.transmittance)[i]));
    EXPECT_GT(derivative.transmittance, 0);
}

// Against Adam as its paper writes it, in double. Three steps; voxels that are not kept, or have no derivative, stay.
TEST(VoxelFit, StepLikeItsPlainTwin) {
    test::forEachInstructionSet([&] {
        std::mt19937 random(2);
        std::vector<CompositeVoxel> voxels(512), gradient(512);
        std::vector<AdamMoments> moments(512);
        std::vector<std::array<double, 12>> twin(512);  // values (roots of colours), means, means of squares
        for (int i = 0; i < 512; ++i) {
            voxels[std::size_t(i)] = randomVoxel(random, 0.2f, 0.8f);
            for (int c = 0; c < 4; ++c) {
                const double value = (&voxels[std::size_t(i)].extinction)[c];
                twin[std::size_t(i)][std::size_t(c)] = c == 0 ? value : std::sqrt(value);
            }
        }
        VoxelMask mask = fullMask();
        mask[3] = 0xff00ff00ff00ff00u;
        VoxelMask solid = mask;
        solid[5] = 0x00ffff00ff00ff00u;
        AdamStep step;
        for (int update = 1; update <= 3; ++update) {
            step.extinctionRate = 0.05f;
            step.colorRate = 0.02f;
            step.correction1 = float(1 / (1 - std::pow(0.9, update)));
            step.correction2 = float(1 / (1 - std::pow(0.99, update)));
            for (int i = 0; i < 512; ++i) {
                gradient[std::size_t(i)] = i % 5 == 0 ? CompositeVoxel{} : randomVoxel(random, -1, 1);
                if (i % 5 == 0 || !isSet(mask, i >> 6, i >> 3 & 7, i & 7)) continue;
                auto& t = twin[std::size_t(i)];
                for (std::size_t c = 0; c < 4; ++c) {
                    const double slope = (&gradient[std::size_t(i)].extinction)[c] * (c == 0 ? 1 : 2 * t[c]);
                    t[4 + c] = 0.9 * t[4 + c] + 0.1 * slope;
                    t[8 + c] = 0.99 * t[8 + c] + 0.01 * slope * slope;
                    t[c] -=
                        (c == 0 ? 0.05 : 0.02) * t[4 + c] * step.correction1 / std::sqrt(t[8 + c] * step.correction2);
                    const bool clear = c == 0 && !isSet(solid, i >> 6, i >> 3 & 7, i & 7);
                    t[c] = std::clamp(t[c], c == 0 ? 0.0 : 0.02, clear ? 0.0 : (c == 0 ? 100.0 : 1.0));
                }
            }
            stepBrick(voxels.data(), gradient.data(), moments.data(), {mask, solid}, step);
        }
        for (int i = 0; i < 512; ++i)
            for (std::size_t c = 0; c < 4; ++c) {
                const double value = twin[std::size_t(i)][c];
                // Roots and squares in float, three times.
                EXPECT_NEAR((&voxels[std::size_t(i)].extinction)[c], c == 0 ? value : value * value, 3e-6)
                    << i << " " << c;
                EXPECT_EQ((&gradient[std::size_t(i)].extinction)[c], 0);
            }
    });
}

// Smoothness adds the derivative of what SmoothWeights says, by central differences over pairs within two bricks.
TEST(VoxelFit, SmoothnessLikeDifferences) {
    const CompositeLayout layout = compositeLayout({16, 8, 8}, {{{0, 0, 0}, fullMask()}, {{8, 0, 0}, fullMask()}});
    std::mt19937 random(3);
    std::vector<CompositeVoxel> voxels(layout.voxelCount());
    for (std::size_t i = 512; i < voxels.size(); ++i) voxels[i] = randomVoxel(random, 0.1f, 0.9f);
    SmoothWeights weights;
    weights.extinction = 0.3f;
    weights.color = 0.7f;
    weights.sparsity = 0.2f;
    const auto value = [&](const std::vector<CompositeVoxel>& v, const Index3& at, int c) {
        const double x = (&v[layout.voxel(at)].extinction)[c];
        return c == 0 ? x : std::sqrt(x);
    };
    const auto around = [&](const std::vector<CompositeVoxel>& v, const Index3& at, int c) {
        const double scale = c == 0 ? weights.extinctionScale : weights.colorScale;
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis)
            for (const int to : {-1, 1}) {
                Index3 next = at;
                next[axis] += to;
                if (next[axis] < 0 || next[axis] >= layout.dims[axis]) continue;
                sum += std::hypot(value(v, at, c) - value(v, next, c), scale);
            }
        sum *= c == 0 ? weights.extinction : weights.color;
        if (c == 0) sum += weights.sparsity * std::log(1 + 2 * std::pow(value(v, at, 0), 2));
        return sum;
    };
    test::forEachInstructionSet([&] {
        std::vector<CompositeVoxel> gradient(voxels.size());
        for (std::size_t b = 1; b < layout.brickCount(); ++b)
            smoothBrick(layout, voxels.data(), b, weights, gradient.data() + b * 512);
        for (int x = 0; x < 16; ++x)
            for (int n = 0; n < 8; ++n)
                for (int c = 0; c < 4; ++c) {
                    const Index3 at(x, (3 * n + x) % 8, n);
                    std::vector<CompositeVoxel> more = voxels, less = voxels;
                    (&more[layout.voxel(at)].extinction)[c] += 1e-3f;
                    (&less[layout.voxel(at)].extinction)[c] -= 1e-3f;
                    const double expected = (around(more, at, c) - around(less, at, c)) / 2e-3;
                    EXPECT_NEAR((&gradient[layout.voxel(at)].extinction)[c], expected,
                                2e-3 * std::max(1.0, std::abs(expected)));
                }
    });
}

// A loss that is linear in colours, before and behind on the way that lowers the total variation.
TEST(VoxelFit, SmoothingHelpsIsADerivative) {
    const CompositeLayout layout = compositeLayout({16, 8, 8}, {{{0, 0, 0}, fullMask()}, {{8, 0, 0}, fullMask()}});
    std::mt19937 random(4);
    std::vector<CompositeVoxel> voxels(layout.voxelCount()), gradient(voxels.size()), rough(voxels.size());
    std::vector<AdamMoments> moments(voxels.size());
    for (std::size_t i = 512; i < voxels.size(); ++i) {
        voxels[i] = randomVoxel(random, 0.1f, 0.9f);
        gradient[i] = randomVoxel(random, -1, 1);
        moments[i].second = randomVoxel(random, 0.5f, 2);
    }
    SmoothWeights color;
    color.color = 1;
    constexpr double kStep = 1e-4;
    double helps = 0, lowered = 0;
    for (std::size_t b = 1; b < layout.brickCount(); ++b) {
        const std::size_t first = b * 512;
        helps += smoothingHelps(layout, voxels.data(), b, &gradient[first], &moments[first]);
        smoothBrick(layout, voxels.data(), b, color, &rough[first]);
        for (std::size_t i = first; i < first + 512; ++i)
            for (int c = 1; c < 4; ++c) {
                const double before = (&voxels[i].extinction)[c], root = std::sqrt(before);
                const double slope = 2 * root * (&rough[i].extinction)[c];
                const double step = kStep * slope / std::sqrt((&moments[i].second.extinction)[c]);
                lowered += (&gradient[i].extinction)[c] * (std::pow(root + step, 2) - std::pow(root - step, 2)) / 2;
            }
    }
    EXPECT_NEAR(helps, lowered / kStep, 1e-5 * std::abs(helps));  // floats
}

// The hull holds all of the ball, and of the corners nothing: twelve cones around a ball hold little more than the
// ball.
TEST(PhotoHull, HoldsTheBall) {
    const Ball ball;
    const std::vector<Photograph> photographs = photographsOf(ball, 12, 64);
    ReconstructionGrid grid;
    grid.dims = Index3(32);
    grid.spacing = Vec3(2.0 / 32);
    const CompositeLayout layout = compositeLayout(grid.dims, photoHull(photographs, grid, 0.001f));
    double inside = 0;
    for (int x = 0; x < 32; ++x)
        for (int y = 0; y < 32; ++y)
            for (int z = 0; z < 32; ++z) {
                const std::size_t i = layout.voxel({x, y, z});
                const bool kept = isSet(layout.masks[i >> 9], int(i >> 6 & 7), int(i >> 3 & 7), int(i & 7));
                const double distance = (grid.voxel(x, y, z) - ball.center).length();
                EXPECT_TRUE(kept || distance > ball.radius + grid.edge()) << distance;
                inside += kept;
            }
    const double volume = 4.0 / 3 * kPi * std::pow(ball.radius / grid.edge(), 3);
    EXPECT_LT(inside, 2 * volume);
}

// What is known of the ball: all of its extinction, and how it is inside. Found are a mass .20 % too small, .61 % too
// much extinction well inside, a colour .35 % too dark, and pixels that differ by 40.0 dB over the last pass, those
// that are left out by 50.2 dB after it; limits are 10 % (or .3 dB, for what instruction sets differ by) above.
TEST(PhotoFit, BallFromTwelveViews) {
    const Ball ball;
    const PhotoReconstruction result = fitPhotographs(photographsOf(ball, 12, 48), test::smallFit());
    EXPECT_EQ(result.termination, PhotoTermination::iterations);
    ASSERT_FALSE(result.history.empty());
    EXPECT_LT(result.history.back().imageError, std::pow(10, -39.7 / 20));
    EXPECT_LT(result.history.back().leftOut, std::pow(10, -49.9 / 20));
    double mass = 0, inside = 0, count = 0, color = 0;
    for (auto voxel = result.density->cbeginValueOn(); voxel; ++voxel) {
        const openvdb::Vec3d at = result.density->indexToWorld(voxel.getCoord());
        mass += *voxel;
        if ((Vec3(at[0], at[1], at[2]) - ball.center).length() > 0.7 * ball.radius) continue;
        inside += *voxel;
        color += result.color->tree().getValue(voxel.getCoord())[0];
        ++count;
    }
    const double expected = ball.extinction * 4.0 / 3 * kPi * std::pow(ball.radius, 3);
    EXPECT_NEAR(mass * std::pow(2.0 / 16, 3), expected, 0.0022 * expected);
    EXPECT_NEAR(inside / count, ball.extinction, 0.0067 * ball.extinction);
    EXPECT_NEAR(color / count, ball.color[0], 0.0039 * ball.color[0]);
}

// Noise of which no picture knows the other's asks for a smoother volume than pictures without.
TEST(PhotoFit, SmoothnessFollowsFromThePictures) {
    std::vector<Photograph> photographs = photographsOf(Ball{}, 12, 32);
    PhotoFitOptions options = test::smallFit();
    options.leftOut = 0.1;
    const double clean = fitPhotographs(photographs, options).smoothness;
    std::mt19937 random(5);
    std::normal_distribution<float> noise(0, 0.1f);
    for (Photograph& photograph : photographs)
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x) {
                float* pixel = photograph.matte.at(x, y);
                for (int c = 0; c < 3; ++c) pixel[c] = std::clamp(pixel[c] + pixel[3] * noise(random), 0.0f, pixel[3]);
            }
    const double noisy = fitPhotographs(photographs, options).smoothness;
    EXPECT_GT(noisy, 3 * clean) << clean;
    options.adaptSmoothness = false;
    EXPECT_EQ(fitPhotographs(photographs, options).smoothness, options.smoothness);
}

// Photographs of the rig, one of them turned by 2 degrees, 1.2 pixels: by grids of 16 and 32 voxels, after few passes,
// it comes back to within .28 pixels, .23 of the way; after more passes and with larger pictures to .06. The others
// stay, but for what reweighting leaves of the common motion.
TEST(PhotoFit, WrongPoseComesBack) {
    test::PhotoExperimentOptions scene;
    scene.views = 12;
    scene.pixels = 24;
    scene.orbit = RigOrbit::sphere;
    scene.projection = Camera::Projection::Perspective;
    const std::vector<Photograph> truth = test::photoExperiment(scene).photographs;
    std::vector<Photograph> photographs = truth;
    PhotoCamera& wrong = photographs[4].camera;
    wrong = moved(wrong, {wrong.down * (2 * kPi / 180), Vec3(0), 0}, wrong.position);
    PhotoFitOptions options = test::smallFit();
    options.levels = 2;
    options.resolution = 32;
    options.passes = 0.1;
    options.coarsePasses = 4;
    options.raysPerUpdate = 512;
    options.refinePoses = true;
    const Box3 box = *options.box;
    const std::vector<RefinedPose> poses = fitPhotographs(photographs, options).poses;
    ASSERT_EQ(poses.size(), truth.size());
    for (std::size_t n = 0; n < truth.size(); ++n) {
        const double before = motionInPicture(truth[n].camera, photographs[n].camera, box);
        EXPECT_LT(motionInPicture(truth[n].camera, poses[n].camera, box), n == 4 ? 0.25 * before : 1e-3) << n;
    }
}

TEST(PhotoFit, SameBitsForAnyThreads) {
    const std::vector<Photograph> photographs = photographsOf(Ball{}, 6, 32);
    PhotoFitOptions options = test::smallFit();
    options.passes = 2;
    options.levels = 2;
    options.resolution = 32;
    std::vector<PhotoReconstruction> results;
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        results.push_back(fitPhotographs(photographs, options));
    }
    for (const PhotoReconstruction& result : results) {
        ASSERT_EQ(result.density->activeVoxelCount(), results[0].density->activeVoxelCount());
        for (auto voxel = result.density->cbeginValueOn(); voxel; ++voxel)
            ASSERT_EQ(*voxel, results[0].density->tree().getValue(voxel.getCoord()));
        EXPECT_EQ(result.history.back().imageError, results[0].history.back().imageError);
    }
}

TEST(PhotoFit, StopsWhenAsked) {
    int calls = 0;
    const PhotoReconstruction result = fitPhotographs(photographsOf(Ball{}, 6, 32), test::smallFit(), nullptr,
                                                      [&](const std::string&, double) { return ++calls < 3; });
    EXPECT_EQ(result.termination, PhotoTermination::interrupted);
    EXPECT_GT(result.density->activeVoxelCount(), 0u);
}

TEST(PhotoFit, RefusesWhatItCannotUse) {
    const std::vector<Photograph> photographs = photographsOf(Ball{}, 3, 16);
    PhotoFitOptions options = test::smallFit();
    options.resolution = 20;
    EXPECT_THROW(fitPhotographs(photographs, options), InvalidArgument);
    EXPECT_THROW(fitPhotographs({}, test::smallFit()), InvalidArgument);
    std::vector<Photograph> opaque = photographs;
    opaque[1].matte = Image(16, 16, 3);
    EXPECT_THROW(fitPhotographs(opaque, test::smallFit()), InvalidArgument);
    std::vector<Photograph> larger = photographs;
    larger[1].matte = Image(32, 16, 4);
    EXPECT_THROW(fitPhotographs(larger, test::smallFit()), InvalidArgument);
    std::vector<Photograph> empty = photographs;
    for (Photograph& photograph : empty) photograph.matte = Image(16, 16, 4);
    EXPECT_THROW(fitPhotographs(empty, test::smallFit()), InvalidArgument);
}
