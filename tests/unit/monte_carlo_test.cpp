/// The reference itself is proven here, against closed forms and the integral-equation slab. Statistical comparisons
/// ask for 4 standard errors: with hundreds of them, 3 would fail by chance.
#include "support/monte_carlo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "raysweep/core/parallel.h"
#include "support/closed_forms.h"
#include "support/phase_function.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

McScene uniformScene(int nx, int ny, int nz, double h, double extinction, double albedo) {
    McScene scene;
    scene.nx = nx;
    scene.ny = ny;
    scene.nz = nz;
    scene.h = h;
    scene.extinction.assign(std::size_t(nx) * ny * nz, extinction);
    scene.albedo = {albedo};
    return scene;
}

/// An infinite slab across z in `layers` layers of one periodic voxel, of physical thickness 2.
McScene slabScene(double opticalThickness, double albedo, int layers) {
    McScene scene = uniformScene(1, 1, layers, 2.0 / layers, 0.5 * opticalThickness, albedo);
    scene.periodicX = scene.periodicY = true;
    return scene;
}

McSun beam(double cosine) {
    return {Vec3(std::sqrt(0.5 * (1 - cosine * cosine)), -std::sqrt(0.5 * (1 - cosine * cosine)), cosine), 1};
}

McSky skyThrough(int face) {
    McSky sky;
    sky.faces.fill(false);
    sky.faces[face] = true;
    return sky;
}

/// Optical depths per voxel spread evenly on a logarithmic scale over three decades.
McScene randomScene(int n, double h, double thickest) {
    McScene scene = uniformScene(n, n, n, h, 0, 1);
    std::mt19937 random(7);
    for (double& sigmaT : scene.extinction)
        sigmaT = thickest / h * std::pow(10.0, -3.0 * double(random()) / 4294967296.0);
    return scene;
}

/// Departures of the source radiance from `expected` over several seeds: their squares in units of the standard error
/// (1 if the errors are honest and nothing is biased; 63/61 with errors from 64 batches), and the mean.
struct Departure {
    double chiSquared = 0, mean = 0;
};
Departure departure(const McScene& scene, double expected, std::uint64_t histories, int seeds) {
    Departure result;
    for (int seed = 0; seed < seeds; ++seed) {
        const McResult run = monteCarlo(scene, histories, 1000 + seed);
        const double weight = 1.0 / (double(seeds) * double(run.sourceRadiance.size()));
        for (std::size_t n = 0; n < run.sourceRadiance.size(); ++n) {
            const double d = run.sourceRadiance[n] - expected;
            result.mean += weight * d / expected;
            result.chiSquared += weight * d * d / (run.sourceRadianceError[n] * run.sourceRadianceError[n]);
        }
    }
    return result;
}

/// Solid angle of a rectangle with one corner below the eye: sides a, b, distance d.
double cornerSolidAngle(double a, double b, double d) {
    return std::atan(a * b / (d * std::sqrt(a * a + b * b + d * d)));
}

}  // namespace

// The bound 0.003 keeps the comparison sharp should the standard error grow.
TEST(MonteCarlo, SlabUnderDiffuseLightAgreesWithTheTable) {
    for (const SlabReference& row : kDiffuseSlabs) {
        McScene scene = slabScene(row.opticalThickness, row.albedo, 8);
        scene.sky = skyThrough(4);
        const McResult result = monteCarlo(scene, 300000, 1);
        const double flux = result.injected.value;
        EXPECT_NEAR(flux, kPi * 0.25 * 0.25, 1e-12);  // pi times the area of the voxel's face
        const double sigmaR = result.escapedPerFace[4].error / flux, sigmaT = result.escapedPerFace[5].error / flux;
        EXPECT_NEAR(result.escapedPerFace[4].value / flux, row.reflectance,
                    std::min(0.003, 4 * sigmaR + kDiffuseSlabTolerance))
            << row.opticalThickness << " " << row.albedo;
        EXPECT_NEAR(result.escapedPerFace[5].value / flux, row.transmittance,
                    std::min(0.003, 4 * sigmaT + kDiffuseSlabTolerance))
            << row.opticalThickness << " " << row.albedo;
    }
}

TEST(MonteCarlo, SlabUnderABeamAgreesWithDisort) {
    for (const SlabReference& row : kBeamSlabs) {
        McScene scene = slabScene(row.opticalThickness, row.albedo, 8);
        scene.sun = beam(kBeamCosine);
        const McResult result = monteCarlo(scene, 300000, 2);
        const double flux = result.injected.value;
        const double scattered = result.escapedPerFace[5].value - result.escapedUncollidedPerFace[5].value;
        EXPECT_NEAR(flux, kBeamCosine * 0.25 * 0.25, 1e-12);
        EXPECT_NEAR(result.escapedPerFace[4].value / flux, row.reflectance, 0.003)
            << row.opticalThickness << " " << row.albedo;
        EXPECT_NEAR(scattered / flux, row.transmittance, 0.003) << row.opticalThickness << " " << row.albedo;
        EXPECT_NEAR(result.escapedUncollidedPerFace[5].value / flux, std::exp(-row.opticalThickness / kBeamCosine),
                    0.001);
    }
}

// The slab solver's layer means are good to 1e-4, a fraction of the standard errors here.
TEST(MonteCarlo, SourceRadianceInASlabFollowsTheIntegralEquation) {
    const int layers = 16;
    for (const bool diffuse : {true, false}) {
        const SlabSolution slab = solveSlab(4, 0.9, diffuse ? SlabLight::Diffuse : SlabLight::Beam, 0.5);
        McScene scene = slabScene(4, 0.9, layers);
        if (diffuse) scene.sky = skyThrough(4);
        if (!diffuse) scene.sun = beam(0.5);
        const McResult result = monteCarlo(scene, 1000000, 3);
        for (int k = 0; k < layers; ++k) {
            const double expected = meanSourceRadiance(slab, 4.0 * k / layers, 4.0 * (k + 1) / layers);
            EXPECT_NEAR(result.sourceRadiance[k], expected, 4 * result.sourceRadianceError[k] + 1e-4 * expected) << k;
            EXPECT_LT(result.sourceRadianceError[k] / expected, 0.005);
            EXPECT_DOUBLE_EQ(result.collided[k], scene.extinction[k] * result.fluence[k]);
        }
    }
}

// Voxels are correlated along flights: measured, chi squared scatters by 0.25 from seed to seed, 0.06 over 16 seeds.
TEST(MonteCarlo, WhiteFurnaceIsEverywhereOne) {
    McScene scene = randomScene(12, 0.3, 5);
    scene.sky = McSky{};
    const Departure d = departure(scene, 1, 100000, 16);
    EXPECT_NEAR(d.chiSquared, 1.03, 0.2);
    EXPECT_NEAR(d.mean, 0, 0.002);
    EXPECT_EQ(monteCarlo(scene, 1000, 4).absorbed.value, 0);
}

// Kirchhoff: a medium that emits what it would absorb of radiance B, under a sky of B, is B everywhere.
TEST(MonteCarlo, EmittingFurnaceIsInEquilibrium) {
    McScene scene = randomScene(8, 2.0, 3);
    std::mt19937 random(8);
    scene.albedo.assign(scene.extinction.size(), 0);
    scene.emission.assign(scene.extinction.size(), 0);
    for (std::size_t n = 0; n < scene.emission.size(); ++n) {
        scene.albedo[n] = double(random()) / 4294967296.0;
        scene.emission[n] = 4 * kPi * scene.extinction[n] * (1 - scene.albedo[n]) * 2.5;
    }
    scene.sky = McSky{2.5};
    const McResult result = monteCarlo(scene, 1000000, 5);
    // What the sky sends in comes out again, and what is emitted is absorbed.
    const double sky = kPi * 2.5 * 6 * 16 * 16;
    EXPECT_NEAR(result.escaped.value / sky, 1, 4 * result.escaped.error / sky);
    const Departure d = departure(scene, 2.5, 100000, 16);
    EXPECT_NEAR(d.chiSquared, 1.03, 0.2);
    EXPECT_NEAR(d.mean, 0, 0.002);
}

TEST(MonteCarlo, EnergyAddsUpWithEveryLightAtOnce) {
    McScene scene = randomScene(8, 0.5, 8);
    scene.albedo.assign(scene.extinction.size(), 0.97);
    scene.albedo[100] = 0;
    scene.albedo[101] = 1;
    scene.extinction[200] = 0;
    scene.emission.assign(scene.extinction.size(), 0);
    scene.emission[200] = 3;  // an emitting voxel without extinction
    scene.origin = Vec3(-1, 2, 3);
    scene.sun = McSun{Vec3(1, -2, -0.5), 2};
    scene.sky = McSky{0.1};
    scene.pointLights = {{Vec3(0, 4, 5), 10}, {Vec3(-5, 2, 9), 100}};
    const McResult result = monteCarlo(scene, 200000, 6);
    double perFace = 0;
    for (const McTotal& face : result.escapedPerFace) perFace += face.value;
    EXPECT_NEAR((result.absorbed.value + result.escaped.value) / result.injected.value, 1, 1e-9);
    EXPECT_NEAR(perFace / result.escaped.value, 1, 1e-9);
    // The absorbed power as the fluence tells it, another estimator of the same number.
    double absorbed = 0;
    for (std::size_t n = 0; n < result.collided.size(); ++n)
        absorbed += (1 - scene.albedo[n]) * result.collided[n] * 0.125;
    EXPECT_NEAR(absorbed / result.absorbed.value, 1, 0.01);
}

TEST(MonteCarlo, BeamObeysBeerLambertAlongAllAxes) {
    const double h = 0.25;
    for (int face = 0; face < 6; ++face) {
        McScene scene = uniformScene(4, 4, 4, h, 0, 0);
        const int axis = face / 2;
        const std::size_t stride = axis == 0 ? 16 : axis == 1 ? 4 : 1;
        for (int n = 0; n < 64; ++n) scene.extinction[n] = 0.5 + 0.03 * n;
        Vec3 direction(0, 0, 0);
        direction[axis] = face % 2 ? -3 : 3;
        scene.sun = McSun{direction, 2};
        const McResult result = monteCarlo(scene, 300000, 7);
        EXPECT_NEAR(result.injected.value, 2, 1e-12);
        for (std::size_t n = 0; n < 64; ++n) {
            const int depth = int(n / stride % 4);
            double before = 0;  // optical depth up to the voxel
            for (int d = face % 2 ? depth + 1 : 0; d < (face % 2 ? 4 : depth); ++d)
                before += h * scene.extinction[n + stride * std::size_t(d) - stride * std::size_t(depth)];
            const double tau = h * scene.extinction[n], expected = 2 * std::exp(-before) * -std::expm1(-tau) / tau;
            EXPECT_NEAR(result.fluence[n], expected, 4.5 * result.fluenceError[n]) << "face " << face << " voxel " << n;
            EXPECT_LT(result.fluenceError[n] / expected, 0.05);
        }
    }
}

TEST(MonteCarlo, ObliqueBeamObeysBeerLambert) {
    McScene scene = slabScene(1.5, 0, 5);
    scene.sun = beam(0.3);
    const McResult result = monteCarlo(scene, 300000, 8);
    EXPECT_NEAR(result.escaped.value / result.injected.value, std::exp(-1.5 / 0.3),
                4 * result.escaped.error / result.injected.value);
    EXPECT_EQ(result.escaped.value, result.escapedUncollidedPerFace[5].value);
}

TEST(MonteCarlo, PointLightInVacuumSendsAllItsPowerOut) {
    McScene scene = uniformScene(9, 9, 9, 0.2, 0, 1);
    scene.origin = Vec3(1, 1, 1);
    scene.pointLights = {{Vec3(1.9, 1.9, 1.9), 5}};
    const McResult result = monteCarlo(scene, 300000, 9);
    EXPECT_NEAR(result.escaped.value, 5, 1e-9);
    for (const McTotal& face : result.escapedPerFace) EXPECT_NEAR(face.value, 5.0 / 6, 0.002);
    // Inverse square: at 4 voxels a voxel's mean of 1/r^2 differs from that of its centre by 1/3 of (h/2)^2/r^4: 0.5 %.
    const std::size_t right = (8 * 9 + 4) * 9 + 4, up = (4 * 9 + 4) * 9 + 8;
    EXPECT_NEAR(result.fluence[right] * 4 * kPi * 0.64 / 5, 1, 0.01);
    EXPECT_NEAR(result.fluence[up] * 4 * kPi * 0.64 / 5, 1, 0.01);
}

TEST(MonteCarlo, PointLightOutsideSendsInItsSolidAngle) {
    McScene scene = uniformScene(4, 6, 8, 0.5, 0, 1);  // 2 x 3 x 4 world units
    const Vec3 light(1.5, -1, 5);                      // sees the faces y low (1.5 from x low) and z high
    scene.pointLights = {{light, 4 * kPi}};
    const McResult result = monteCarlo(scene, 300000, 10);
    const auto strip = [](double x0, double x1, double near, double far, double d) {
        return cornerSolidAngle(x0, far, d) + cornerSolidAngle(x1, far, d) - cornerSolidAngle(x0, near, d) -
               cornerSolidAngle(x1, near, d);
    };
    EXPECT_NEAR(result.injected.value, strip(1.5, 0.5, 1, 5, 1) + strip(1.5, 0.5, 1, 4, 1), 1e-9);
    // Along the sight line to a voxel the fluence is 1/r^2 for this power.
    const std::size_t voxel = (2 * 6 + 3) * 8 + 2;  // centre (1.25, 1.75, 1.25)
    const double r2 = 0.25 * 0.25 + 2.75 * 2.75 + 3.75 * 3.75;
    EXPECT_NEAR(result.fluence[voxel] * r2, 1, 4 * result.fluenceError[voxel] * r2 + 0.005);
}

TEST(MonteCarlo, PointLightInAnAbsorberFallsOffExponentially) {
    McScene scene = uniformScene(11, 11, 11, 0.1, 3, 0);
    scene.pointLights = {{Vec3(0.55, 0.55, 0.55), 1}};
    const McResult result = monteCarlo(scene, 1000000, 11);
    const Quadrature rule = gaussLegendre(6);
    for (const Index3& voxel : {Index3(8, 5, 5), Index3(5, 2, 5), Index3(7, 7, 3), Index3(2, 8, 10)}) {
        double expected = 0;  // mean over the voxel of exp(-sigma r) / (4 pi r^2)
        for (int n = 0; n < 216; ++n) {
            const int a = n / 36, b = n / 6 % 6, c = n % 6;
            const Vec3 p(rule.points[a] + voxel.x - 5.5, rule.points[b] + voxel.y - 5.5,
                         rule.points[c] + voxel.z - 5.5);
            const double r = 0.1 * p.length();
            expected += rule.weights[a] * rule.weights[b] * rule.weights[c] * std::exp(-3 * r) / (4 * kPi * r * r);
        }
        const std::size_t n = (std::size_t(voxel.x) * 11 + voxel.y) * 11 + voxel.z;
        EXPECT_NEAR(result.fluence[n], expected, 4 * result.fluenceError[n]);
        EXPECT_LT(result.fluenceError[n] / expected, 0.05);
    }
}

// Turning the scene from x to z (i,j,k) -> (j,k,i) and the light with it turns the answer.
TEST(MonteCarlo, TurnedSceneGivesTheTurnedAnswer) {
    McScene scene = randomScene(8, 1, 2), turned = scene;
    scene.albedo = turned.albedo = {0.8};
    for (int n = 0; n < 512; ++n) turned.extinction[(n / 8 % 8 * 8 + n % 8) * 8 + n / 64] = scene.extinction[n];
    scene.sun = McSun{Vec3(1, 0.3, -0.2), 1};
    turned.sun = McSun{Vec3(0.3, -0.2, 1), 1};
    double sum = 0;
    for (int seed = 0; seed < 16; ++seed) {
        const McResult a = monteCarlo(scene, 50000, 2 * seed), b = monteCarlo(turned, 50000, 2 * seed + 1);
        for (int n = 0; n < 512; ++n) {
            const int m = (n / 8 % 8 * 8 + n % 8) * 8 + n / 64;
            sum += std::pow(a.fluence[n] - b.fluence[m], 2) /
                   (std::pow(a.fluenceError[n], 2) + std::pow(b.fluenceError[m], 2));
        }
    }
    EXPECT_NEAR(sum / (16 * 512), 1.03, 0.2);
}

TEST(MonteCarlo, HasTheSameBitsForAnyNumberOfThreads) {
    McScene scene = randomScene(6, 1, 2);
    scene.albedo = {0.9};
    scene.sky = McSky{};
    const auto run = [&](int threads, std::uint64_t seed) {
        ThreadLimit limit(threads);
        return monteCarlo(scene, 20000, seed);
    };
    const McResult one = run(1, 14), two = run(2, 14), other = run(2, 15);
    EXPECT_EQ(one.fluence, two.fluence);
    EXPECT_EQ(one.fluenceError, two.fluenceError);
    EXPECT_EQ(one.absorbed.value, two.absorbed.value);
    EXPECT_NE(one.fluence, other.fluence);
}

// Henyey and Greenstein: the mean of the n-th Legendre polynomial of the cosine is g^n.
TEST(MonteCarlo, ScatteringAnglesHaveTheMomentsOfThePhaseFunction) {
    constexpr int kCount = 1 << 20;
    for (const double g : {-0.6, 0.0, 0.3, 0.85, 0.99}) {
        double mean = 0, second = 0, third = 0;
        for (int n = 0; n < kCount; ++n) {
            const double c = henyeyGreensteinCosine(g, (n + 0.5) / kCount);
            mean += c / kCount;
            second += (1.5 * c * c - 0.5) / kCount;
            third += (2.5 * c * c * c - 1.5 * c) / kCount;
        }
        // A midpoint rule over the cumulative distribution.
        EXPECT_NEAR(mean, g, 1e-6) << g;
        EXPECT_NEAR(second, g * g, 1e-6) << g;
        EXPECT_NEAR(third, g * g * g, 1e-6) << g;
    }
}

TEST(MonteCarlo, DeflectionTurnsByItsAngleEvenlyAround) {
    for (const Vec3& from : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(0.6, 0, -0.8), Vec3(-0.48, 0.6, 0.64)}) {
        Vec3 sum(0);
        for (int n = 0; n < 8; ++n) {
            double d[3] = {from.x, from.y, from.z};
            deflect(0.3, 2 * kPi * n / 8, d);
            const Vec3 to(d[0], d[1], d[2]);
            EXPECT_NEAR(to.length(), 1, 1e-12);
            EXPECT_NEAR(to.dot(from), 0.3, 1e-12);
            sum += to;
        }
        EXPECT_LT((sum - from * (8 * 0.3)).length(), 1e-12);
    }
}

// Slab of optical thickness 2, albedo 0.9, g 0.75, beam at normal incidence: van de Hulst, Multiple Light Scattering,
// 1980, table 35, as quoted with MCML by Wang, Jacques and Zheng 1995, table 1.
TEST(MonteCarlo, ForwardScatteringSlabAgreesWithTheTable) {
    McScene scene = slabScene(2, 0.9, 8);
    scene.g = 0.75;
    scene.sun = beam(1);
    const McResult result = monteCarlo(scene, 1000000, 12);
    const double flux = result.injected.value;
    const McTotal &back = result.escapedPerFace[4], &through = result.escapedPerFace[5];
    EXPECT_NEAR(back.value / flux, 0.09739, 4 * back.error / flux);
    EXPECT_NEAR(through.value / flux, 0.66096, 4 * through.error / flux);
    EXPECT_LT(back.error / flux, 0.001);
    EXPECT_LT(through.error / flux, 0.001);
}

TEST(MonteCarlo, RefusesScenesItCannotFollow) {
    const McScene good = uniformScene(2, 2, 2, 1, 1, 0.5);
    EXPECT_THROW(monteCarlo(good, 10, 1), std::invalid_argument);  // no light
    McScene bad = good;
    bad.sky = McSky{};
    bad.extinction[3] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(monteCarlo(bad, 10, 1), std::invalid_argument);
    bad.extinction.pop_back();
    EXPECT_THROW(monteCarlo(bad, 10, 1), std::invalid_argument);
    bad = good;
    bad.g = 1;
    bad.sky = McSky{};
    EXPECT_THROW(monteCarlo(bad, 10, 1), std::invalid_argument);
    bad = good;
    bad.albedo = {1.5};
    bad.sky = McSky{};
    EXPECT_THROW(monteCarlo(bad, 10, 1), std::invalid_argument);
    bad = good;
    bad.periodicX = true;
    bad.pointLights = {{Vec3(1, 1, 5), 1}};
    EXPECT_THROW(monteCarlo(bad, 10, 1), std::invalid_argument);
}
