// Plane-parallel slabs of infinite width: one column of voxels that repeats sideways, against tables and an integral
// equation. Slabs lie across each of the three axes.
#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/illuminate/illuminate.h"
#include "support/closed_forms.h"
#include "support/volumes.h"
#include "support/worst.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr int kWidth = 8;

struct Slab {
    int axis = 2;
    int layers = 8;
    double opticalThickness = 1;
    float albedo = 1;
    double voxel[3] = {1, 1, 1};  ///< edges of a voxel along the axis and both others
};

struct Fluxes {
    double reflectance = 0, transmittance = 0;  ///< parts of the injected power
    std::vector<double> profile;                ///< mean source radiance of each layer
    double balance = 0;
};

Scene sceneOf(const Slab& slab) {
    Index3 size(kWidth);
    size[slab.axis] = slab.layers;
    auto density = boxVolume(size);
    openvdb::Vec3d edges;
    for (int i = 0; i < 3; ++i) edges[(slab.axis + i) % 3] = slab.voxel[i];
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.preScale(edges);
    density->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    Scene scene;
    scene.medium.density = density;
    scene.medium.extinctionScale = slab.opticalThickness / (slab.layers * slab.voxel[0]);
    scene.medium.albedo = grey(slab.albedo);
    return scene;
}

std::vector<double> profileOf(const openvdb::GridBase& radiosity, const Slab& slab) {
    std::vector<double> profile;
    for (int layer = 0; layer < slab.layers; ++layer) {
        double sum = 0;
        for (int i = 0; i < kWidth * kWidth; ++i) {
            openvdb::Coord at;
            at[std::size_t(slab.axis)] = layer;
            at[std::size_t((slab.axis + 1) % 3)] = i % kWidth;
            at[std::size_t((slab.axis + 2) % 3)] = i / kWidth;
            sum += double(static_cast<const openvdb::FloatGrid&>(radiosity).tree().getValue(at));
        }
        profile.push_back(sum / (kWidth * kWidth));
    }
    return profile;
}

/// Lights the slab through its low face and sorts what escapes while sweeping by the side it leaves through.
Fluxes lightSlab(const Slab& slab, const Scene& scene, IlluminateOptions options) {
    options.tolerance = 0;
    options.periodic = {true, true, true};
    options.periodic[std::size_t(slab.axis)] = false;
    Fluxes fluxes;
    options.afterSweep = [&](const Vec3& direction, const RaySums& totals) {
        (direction[slab.axis] < 0 ? fluxes.reflectance : fluxes.transmittance) += totals.escaped[0];
    };
    const Illumination lit = illuminate(scene, options);
    const double injected = lit.power.injected[0] * lit.sweeps;
    fluxes.reflectance /= injected;
    fluxes.transmittance /= injected;
    fluxes.profile = profileOf(*lit.radiosity, slab);
    if (scene.sky.profile) {
        // For the flux really injected, which is off by what the directions are not even: half a per cent.
        const double nominal = kPi * kWidth * kWidth * slab.voxel[1] * slab.voxel[2];
        for (double& S : fluxes.profile) S *= nominal / lit.power.injected[0];
    }
    fluxes.balance = lit.power.error();
    return fluxes;
}

Fluxes diffuseLight(const Slab& slab, IlluminateOptions options) {
    Scene scene = sceneOf(slab);
    scene.sky.radiance = grey(1);
    scene.sky.profile = [axis = slab.axis](const Vec3& direction) { return grey(direction[axis] > 0 ? 1 : 0); };
    return lightSlab(slab, scene, options);
}

Fluxes beam(const Slab& slab, double cosine, IlluminateOptions options) {
    Scene scene = sceneOf(slab);
    const double sine = std::sqrt(1 - cosine * cosine), azimuth = 0.7;
    Vec3 direction;
    direction[slab.axis] = cosine;
    direction[(slab.axis + 1) % 3] = sine * std::cos(azimuth);
    direction[(slab.axis + 2) % 3] = sine * std::sin(azimuth);
    scene.suns.push_back({direction, grey(1)});
    return lightSlab(slab, scene, options);
}

/// Within 1 %, or 0.005 for what is small: the promise to users, far above the reference's own error. What escapes
/// while sweeping is noisier than the answer, since it has not been averaged over all directions but sorted by them:
/// `noise`.
void expectClose(double measured, double exact, const char* what, const Slab& slab, double noise = 0) {
    EXPECT_LE(std::abs(measured - exact), std::max({0.01 * exact, exact < 0.2 ? 0.005 : 0.0, noise}))
        << what << " of thickness " << slab.opticalThickness << ", albedo " << slab.albedo << ", across axis "
        << slab.axis << ": " << measured << " instead of " << exact;
}

/// After 4096 sweeps R + T is off by up to this much, all of it from directions that are not quite even. That it falls,
/// and the promised 1 % is met, is what ConvergesToTheTable shows with 16 times the sweeps.
constexpr double kUneven = 0.006;

/// Voxels at most an eighth of an optical depth thick: a slab's faces are sharp, and fluxes show how they are resolved.
int layersFor(double opticalThickness) {
    return 8 * std::max(1, int(std::ceil(opticalThickness / 0.125 / 8)));
}

/// Fluxes through both faces that follow from the source radiance of the layers, as a renderer would see them:
/// R = 2 int S(t) E2(t) dt and the same from the other side, for diffuse light of radiance 1.
Fluxes fluxesOf(const std::vector<double>& profile, double opticalThickness) {
    const double depth = opticalThickness / double(profile.size());
    Fluxes fluxes;
    fluxes.transmittance = 2 * exponentialIntegral(3, opticalThickness);
    for (std::size_t i = 0; i < profile.size(); ++i) {
        const double from = double(i) * depth, to = from + depth;
        const auto seen = [&](double near, double far) {
            return 2 * profile[i] * (exponentialIntegral(3, near) - exponentialIntegral(3, far));
        };
        fluxes.reflectance += seen(from, to);
        fluxes.transmittance += seen(std::max(0.0, opticalThickness - to), opticalThickness - from);
    }
    return fluxes;
}

double profileError(const Slab& slab, const Fluxes& fluxes, const SlabSolution& exact) {
    const double depth = slab.opticalThickness / slab.layers;
    double difference = 0, norm = 0;
    for (int i = 0; i < slab.layers; ++i) {
        const double S = meanSourceRadiance(exact, i * depth, (i + 1) * depth);
        difference += (fluxes.profile[std::size_t(i)] - S) * (fluxes.profile[std::size_t(i)] - S);
        norm += S * S;
    }
    return std::sqrt(difference / norm);
}

void expectDiffuseTable(int axis, Interpolation interpolation, int sweeps) {
    IlluminateOptions options;
    options.sweeps = sweeps;
    options.interpolation = interpolation;
    double worst = 0, worstSeen = 0, worstProfile = 0;
    for (const SlabReference& reference : kDiffuseSlabs) {
        const Slab slab{axis, layersFor(reference.opticalThickness), reference.opticalThickness,
                        float(reference.albedo)};
        const Fluxes fluxes = diffuseLight(slab, options);
        const SlabSolution exact = solveSlab(slab.opticalThickness, reference.albedo, SlabLight::Diffuse);
        const double profile = profileError(slab, fluxes, exact);
        std::printf(
            "  axis %d thickness %.1f albedo %.1f: R %.4f (%.4f) T %.4f (%.4f), profile off by %.2f %%, balance %.1e\n",
            axis, slab.opticalThickness, double(slab.albedo), fluxes.reflectance, reference.reflectance,
            fluxes.transmittance, reference.transmittance, 100 * profile, fluxes.balance);
        const Fluxes seen = fluxesOf(fluxes.profile, slab.opticalThickness);
        std::printf("    seen: R %.4f T %.4f\n", seen.reflectance, seen.transmittance);
        expectClose(seen.reflectance, reference.reflectance, "reflectance", slab, kUneven);
        expectClose(seen.transmittance, reference.transmittance, "transmittance", slab, kUneven);
        // Three times the scatter of seeds at 4096 sweeps, 0.0028; it falls with the root of the sweeps.
        expectClose(fluxes.reflectance, reference.reflectance, "escaped reflectance", slab, 0.0085);
        expectClose(fluxes.transmittance, reference.transmittance, "escaped transmittance", slab, 0.0085);
        raiseTo(worstSeen, std::abs(seen.reflectance - reference.reflectance));
        raiseTo(worstSeen, std::abs(seen.transmittance - reference.transmittance));
        EXPECT_LE(profile, 0.01);
        EXPECT_LE(fluxes.balance, 1e-5);
        raiseTo(worst, std::abs(fluxes.reflectance - reference.reflectance));
        raiseTo(worst, std::abs(fluxes.transmittance - reference.transmittance));
        raiseTo(worstProfile, profile);
    }
    std::printf("  worst: escaped %.4f, seen %.4f, profile %.2f %%\n", worst, worstSeen, 100 * worstProfile);
}

}  // namespace

TEST(SlabSlow, DiffuseLightAcrossX) {
    expectDiffuseTable(0, Interpolation::nearest, 4096);
}
TEST(SlabSlow, DiffuseLightAcrossY) {
    expectDiffuseTable(1, Interpolation::nearest, 4096);
}
TEST(SlabSlow, DiffuseLightAcrossZ) {
    expectDiffuseTable(2, Interpolation::nearest, 4096);
}
TEST(SlabSlow, DiffuseLightWithLinearInterpolation) {
    expectDiffuseTable(2, Interpolation::linear, 4096);
}

// With enough sweeps both what is seen and what escapes agree: successive directions are not tied to each other.
TEST(SlabSlow, ConvergesToTheTable) {
    IlluminateOptions options;
    options.sweeps = 65536;
    for (const SlabReference& reference : {kDiffuseSlabs[0], kDiffuseSlabs[7], kDiffuseSlabs[9]}) {
        const Slab slab{2, layersFor(reference.opticalThickness), reference.opticalThickness, float(reference.albedo)};
        const Fluxes fluxes = diffuseLight(slab, options);
        std::printf("  thickness %.1f albedo %.1f: R %.4f (%.4f) T %.4f (%.4f)\n", slab.opticalThickness,
                    double(slab.albedo), fluxes.reflectance, reference.reflectance, fluxes.transmittance,
                    reference.transmittance);
        expectClose(fluxes.reflectance, reference.reflectance, "reflectance", slab);
        expectClose(fluxes.transmittance, reference.transmittance, "transmittance", slab);
        const Fluxes seen = fluxesOf(fluxes.profile, slab.opticalThickness);
        std::printf("    seen: R %.4f T %.4f\n", seen.reflectance, seen.transmittance);
        expectClose(seen.reflectance, reference.reflectance, "seen reflectance", slab);
        expectClose(seen.transmittance, reference.transmittance, "seen transmittance", slab);
    }
}

TEST(SlabSlow, GrazingBeam) {
    IlluminateOptions options;
    for (const SlabReference& reference : kBeamSlabs)
        for (const int axis : {0, 1, 2}) {
            const bool thick = reference.opticalThickness > 1;
            if (thick && axis != 2) continue;
            // A grazing beam is absorbed within 0.1 optical depths of the surface: there voxels must be thin. Where
            // nothing else absorbs, power wanders through the slab for some 1500 sweeps, and there must be many more.
            const bool lasting = thick && reference.albedo == 1;
            options.sweeps = lasting ? 16384 : 2048;
            const Slab slab{axis, lasting ? 128 : (thick ? 480 : 8), reference.opticalThickness,
                            float(reference.albedo)};
            const Fluxes fluxes = beam(slab, kBeamCosine, options);
            std::printf("  axis %d thickness %g albedo %.2f: R %.5f (%.5f) T %.5f (%.5f), balance %.1e\n", axis,
                        slab.opticalThickness, double(slab.albedo), fluxes.reflectance, reference.reflectance,
                        fluxes.transmittance, reference.transmittance, fluxes.balance);
            expectClose(fluxes.reflectance, reference.reflectance, "reflectance", slab);
            expectClose(fluxes.transmittance, reference.transmittance, "diffuse transmittance", slab);
            EXPECT_LE(fluxes.balance, 1e-5);
        }
}

TEST(SlabSlow, NonUniformVoxels) {
    IlluminateOptions options;
    options.sweeps = 4096;
    for (const SlabReference& reference : kDiffuseSlabs) {
        if (reference.opticalThickness != 2) continue;
        for (const double aspect : {0.5, 2.0}) {
            const Slab slab{2, 16, 2, float(reference.albedo), {0.7, 0.7 * aspect, 0.7}};
            const Fluxes fluxes = diffuseLight(slab, options);
            std::printf("  voxel 0.7 x %g x 0.7, albedo %.1f: R %.4f (%.4f) T %.4f (%.4f)\n", 0.7 * aspect,
                        double(slab.albedo), fluxes.reflectance, reference.reflectance, fluxes.transmittance,
                        reference.transmittance);
            const Fluxes seen = fluxesOf(fluxes.profile, slab.opticalThickness);
            std::printf("    seen: R %.4f T %.4f\n", seen.reflectance, seen.transmittance);
            expectClose(seen.reflectance, reference.reflectance, "reflectance", slab, kUneven);
            expectClose(seen.transmittance, reference.transmittance, "transmittance", slab, kUneven);
        }
    }
}
