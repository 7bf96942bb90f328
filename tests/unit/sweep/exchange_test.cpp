// The vectorised exchange against its formulas, written down once more voxel by voxel in doubles.
#include "raysweep/sweep/exchange.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "raysweep/bricks/brick_map.h"
#include "raysweep/core/error.h"
#include "raysweep/sweep/directions.h"
#include "raysweep/sweep/sweep.h"
#include "support/instruction_sets.h"

using namespace raysweep;
using raysweep::test::forEachInstructionSet;

namespace {

/// Fields of a small random volume. `unshot` and `deposit` are what a sweep changes.
struct Volume {
    explicit Volume(int channelCount, const Periodic& periodic = {})
        : channels(channelCount), sweepVolume(makeLayout(), periodic), escape(Matrix3()) {
        std::mt19937_64 random(11);
        const std::size_t bricks = sweepVolume.layout.brickCount();
        const auto fill = [&](BrickField& field, double low, double high) {
            field = BrickField(bricks);
            for (std::size_t b = 0; b < bricks; ++b)
                for (int i = 0; i < kBrickVoxels; ++i)
                    field.brick(b)[i] = float(low * std::pow(high / low, uniform01(random)));
        };
        fill(tau, 1e-4, 20);
        for (std::size_t b = 0; b < bricks; ++b) tau.brick(b)[17] = 0;
        // Some voxels are surfaces, in some bricks.
        for (std::size_t b = 0; b < bricks; b += 2) {
            PackedNormal* const normals = addSurfaceBrick(surfaces, bricks, b);
            for (int i = 0; i < kBrickVoxels; ++i)
                if (uniform01(random) < 0.3) normals[i] = packNormal(sphericalFibonacci(64)[std::size_t(i) % 64]);
        }
        furnace = BrickField(surfaces.bricks.size());
        for (int c = 0; c < channels; ++c) {
            fill(albedo[c], 0.1, 1);
            fill(source[c], 1e-3, 0.1);
            fill(unshot[c], 0.01, 1);
            fill(deposit[c], 0.1, 1);
            fresh[c] = BrickField(bricks);
        }
    }

    static BrickLayout makeLayout() {
        BrickLayout layout;  // with a hole, and in more than one quadrant
        layout.origins = {{-8, 0, 0}, {-8, 8, 8}, {0, 0, 0}, {0, 0, 8}, {0, 8, 0}, {8, -8, 0}};
        layout.low = Index3(-8, -8, 0);
        layout.high = Index3(16, 16, 16);
        return layout;
    }

    ExchangeFields fields() {
        ExchangeFields views;
        views.channels = channels;
        views.surfaces = &surfaces;
        views.furnace = viewOf(furnace);
        views.tau = viewOf(tau);
        for (int c = 0; c < channels; ++c) {
            views.albedo[c] = viewOf(albedo[c]);
            views.source[c] = viewOf(source[c]);
            views.unshot[c] = viewOf(unshot[c]);
            views.deposit[c] = viewOf(deposit[c]);
            views.fresh[c] = viewOf(fresh[c]);
        }
        return views;
    }

    int channels;
    SweepVolume sweepVolume;
    Escape escape;
    Surfaces surfaces;
    BrickField furnace;
    BrickField tau, albedo[3], source[3], unshot[3], deposit[3], fresh[3];
};

/// A beam and what it shares with the others of its sweep.
struct PlainBeam : ExchangeConstants {
    PlainBeam(const ExchangeConstants& constants, const Beam& ofBeam) : ExchangeConstants(constants), beam(ofBeam) {}
    const Beam& beam;
};

double cosineOf(const PlainBeam& plain, PackedNormal normal) {
    return unpackNormal(normal).dot(plain.beam.front.direction);
}

/// What the formulas say about one voxel.
struct VoxelTerms {
    double opacity, shot, g;
};

VoxelTerms termsOf(const PlainBeam& plain, PackedNormal normal, double tau, double albedo) {
    const double along = tau * double(plain.beam.stepScale), opacity = -std::expm1(-along);
    if (normal != 0) {
        const double cosine = cosineOf(plain, normal);
        const bool paper = plain.model == ExchangeModel::paper;
        const double shot = paper ? double(plain.zeta) : std::min(double(plain.mostShot), 4 * double(plain.zeta));
        if (cosine > 0) return {0, shot * std::min(1.0, cosine), albedo};
        return {opacity * (paper ? std::min(1.0, -cosine) : 1), 0, albedo};
    }
    if (plain.model == ExchangeModel::paper) return {opacity, double(plain.zeta), albedo};
    const double p = plain.escape.probability(tau);
    const double ratio = along > 0 ? opacity / along : 1;
    return {opacity, std::min(double(plain.mostShot), double(plain.zeta) * ratio / p), effectiveAlbedo(albedo, p)};
}

/// The local furnace in doubles, by its definition in exchange.h.
struct PlainFurnace {
    struct Ray {
        double f = 0;
        int last = -1000000;  ///< slice in which it was in a solid
        double taken = 0, inside = 0;
    };
    std::map<std::pair<int, int>, Ray> rays;
    std::vector<double> sum;  ///< over the surfaces' bricks

    /// What a voxel takes of a ray that meets it with `weight` in slice k.
    void meet(const PlainBeam& plain, const std::pair<int, int>& at, int k, PackedNormal normal, double tau,
              double opacity, double weight, double& total) {
        Ray& ray = rays[at];
        if (ray.last < k - kSurfaceGap) ray.f = double(plain.beam.furnaceRay);
        const bool leaving = normal != 0 && tau > 0 && cosineOf(plain, normal) > double(kLeavingCosine);
        const bool inside = !leaving && ((normal != 0 && tau > 0) || tau >= double(plain.solidTau));
        const double in = inside ? weight * opacity * ray.f : 0;
        total += in;
        ray.taken += in;
        ray.inside += weight * (inside ? 1 : leaving ? -1 : 0);
    }
    void endSlice(int k) {
        for (auto& [at, ray] : rays) {
            ray.f = std::max(0.0, ray.f - ray.taken);
            if (ray.inside != 0) ray.last = ray.inside > 0 ? k : -1000000;
            ray.taken = ray.inside = 0;
        }
    }
};

/// A sweep in doubles, of one channel: slices in the order of travel, rays in a map. `nearest` has one footprint of
/// weight 1.
struct PlainSweep {
    const Volume& volume;
    const PlainBeam& plain;
    int channel;
    bool linear;
    const RayFront& front = plain.beam.front;
    std::map<std::pair<int, int>, double> rays = {};
    std::vector<double> unshot = {}, deposit = {};
    double escaped = 0;
    PlainFurnace furnace = {};

    void run() {
        const BrickLayout& layout = volume.sweepVolume.layout;
        const BrickMap map(layout);
        unshot.assign(layout.brickCount() * kBrickVoxels, 0.0);
        deposit = unshot;
        furnace.sum.assign(volume.surfaces.bricks.size() * kBrickVoxels, 0.0);
        for (std::size_t b = 0; b < layout.brickCount(); ++b)
            for (std::size_t i = 0; i < kBrickVoxels; ++i) {
                unshot[b * kBrickVoxels + i] = double(volume.unshot[channel].brick(b)[i]);
                deposit[b * kBrickVoxels + i] = double(volume.deposit[channel].brick(b)[i]);
            }
        const RayRange rows = rayExtent(front, front.row);
        for (int r = rows.begin; r < rows.end; ++r) {
            const RayRange columns = raysThatEnter(front, r);
            for (int c = columns.begin; c < columns.end; ++c) rays[{r, c}] = double(plain.beam.entering[channel]);
        }
        for (int k = 0; k < front.slices; ++k) sliceThrough(layout, map, k);
        for (const auto& [at, ray] : rays) escaped += ray;
    }

    void sliceThrough(const BrickLayout& layout, const BrickMap& map, int k) {
        const double fu = linear ? front.column.position(k) - front.column.shift(k) : 0;
        const double fv = linear ? front.row.position(k) - front.row.shift(k) : 0;
        std::map<std::pair<int, int>, double> change;
        Index3 voxel;
        voxel[front.axis.major] = front.ascending ? front.firstSlice + k : front.firstSlice - k;
        for (int v = layout.low[front.axis.row]; v < layout.high[front.axis.row]; ++v)
            for (int u = layout.low[front.axis.column]; u < layout.high[front.axis.column]; ++u) {
                voxel[front.axis.row] = v;
                voxel[front.axis.column] = u;
                const std::uint32_t b = map.find(voxel);
                if (b == kNoBrick) continue;
                const std::size_t i = offsetInBrick(voxel);
                const PackedNormal* const normals = volume.surfaces.normals(b);
                const VoxelTerms terms = termsOf(plain, normals ? normals[i] : 0, double(volume.tau.brick(b)[i]),
                                                 double(volume.albedo[channel].brick(b)[i]));
                double& U = unshot[b * kBrickVoxels + i];
                const double out = U * terms.shot;
                double in = 0;
                for (int dv = 0; dv <= front.reach; ++dv)
                    for (int du = 0; du <= front.reach; ++du) {
                        const double weight = (dv ? fv : 1 - fv) * (du ? fu : 1 - fu);
                        const std::pair<int, int> ray{v - front.row.shift(k) - dv, u - front.column.shift(k) - du};
                        const double taken = weight * terms.opacity * rays[ray];
                        in += taken;
                        if (normals)
                            furnace.meet(plain, ray, k, normals[i], double(volume.tau.brick(b)[i]), terms.opacity,
                                         weight, furnace.sum[volume.surfaces.slots[b] * std::size_t(kBrickVoxels) + i]);
                        change[ray] += weight * out - taken;
                    }
                deposit[b * kBrickVoxels + i] += in;
                U += terms.g * in - out + double(volume.source[channel].brick(b)[i]);
            }
        for (const auto& [ray, delta] : change) rays[ray] += delta;
        furnace.endSlice(k);
    }
};

/// A beam along `direction`, with powers of its own.
Beam makeBeam(const Volume& volume, const Vec3& direction, Interpolation interpolation, int number) {
    Beam beam;
    beam.front = parallelFront(volume.sweepVolume.layout, direction, interpolation == Interpolation::linear ? 1 : 0,
                               0.31, 0.77, {});
    beam.stepScale = float(beam.front.stepLength / volume.escape.meanStepLength());
    for (int c = 0; c < volume.channels; ++c) beam.entering[c] = 0.5f + 0.25f * float(c) + 0.1f * float(number);
    beam.furnaceRay = 0.7f;
    return beam;
}

/// Largest difference of a field from what it was before with the `changes` of all beams.
double worstOf(const BrickField& field, const BrickField& before, const std::vector<std::vector<double>>& after) {
    double worst = 0;
    for (std::size_t i = 0; i < after[0].size(); ++i) {
        const double old = double(before.brick(0)[i]);
        double expected = old;
        for (const std::vector<double>& ofBeam : after) expected += ofBeam[i] - old;
        worst = std::max(worst, std::abs(double(field.brick(0)[i]) - expected));
    }
    return worst;
}

/// All beams read the volume as it was: the plain sweeps are made one by one on a copy of it, and their changes added.
void expectSameAsPlain(const std::vector<Vec3>& directions, Interpolation interpolation, ExchangeModel model,
                       int channels) {
    Volume volume(channels);
    const Volume before(channels);
    const bool linear = interpolation == Interpolation::linear;
    ExchangeConstants constants;
    constants.model = model;
    constants.escape = volume.escape.fit();
    constants.zeta = 0.9f / float(directions.size());
    constants.mostShot = 1 / float(directions.size());
    constants.solidTau = 2;
    std::vector<Beam> beams;
    for (const Vec3& direction : directions)
        beams.push_back(makeBeam(volume, direction, interpolation, int(beams.size())));
    const ExchangeFields fields = volume.fields();
    const std::vector<RaySums> sums = sweep(volume.sweepVolume, beams, interpolation, fields, constants);
    if (linear) settle(volume.sweepVolume, beams, fields, constants);

    // About 50 float operations on a ray's way, on values of order 1.
    constexpr double kRounding = 1e-5;
    std::ostringstream what;
    what << "direction " << directions[0] << ", beams " << beams.size() << " interpolation " << int(interpolation)
         << " model " << int(model) << " channels " << channels;
    for (int c = 0; c < channels; ++c) {
        std::vector<std::vector<double>> unshot, deposit, furnace;
        for (std::size_t i = 0; i < beams.size(); ++i) {
            const PlainBeam plainBeam(constants, beams[i]);
            PlainSweep plain{before, plainBeam, c, linear};
            plain.run();
            unshot.push_back(plain.unshot);
            deposit.push_back(plain.deposit);
            furnace.push_back(plain.furnace.sum);
            EXPECT_LE(std::abs(sums[i].escaped[c] / plain.escaped - 1), kRounding) << what.str();
        }
        EXPECT_LE(worstOf(volume.unshot[c], before.unshot[c], unshot), kRounding) << what.str();
        EXPECT_LE(worstOf(volume.deposit[c], before.deposit[c], deposit), kRounding) << what.str();
        EXPECT_GT(*std::max_element(furnace[0].begin(), furnace[0].end()), 0.1);
        EXPECT_LE(worstOf(volume.furnace, before.furnace, furnace), kRounding) << what.str();
    }
}

}  // namespace

TEST(Exchange, AgreesWithItsFormulasAlongAllAxes) {
    for (int major = 0; major < 3; ++major)
        for (int signs = 0; signs < 8; ++signs) {
            Vec3 direction;
            direction[major] = signs & 1 ? 1 : -1;
            direction[(major + 1) % 3] = signs & 2 ? 0.6 : -0.3;
            direction[(major + 2) % 3] = signs & 4 ? 0.9 : -0.45;
            for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear})
                for (const ExchangeModel model : {ExchangeModel::consistent, ExchangeModel::paper})
                    for (const int channels : {1, 3}) expectSameAsPlain({direction}, interpolation, model, channels);
        }
}

// Every kernel of every instruction set that the machine has: `nearest`, `linear` and what settles it, both models, one
// wavelength and three, bricks with and without surfaces, turned (z) and not.
TEST(Exchange, AgreesWithItsFormulasOnAllInstructionSets) {
    forEachInstructionSet([] {
        for (const Vec3& direction : {Vec3(1, -0.3, 0.45), Vec3(0.6, -1, 0.9), Vec3(-0.3, 0.9, 1)})
            for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear})
                for (const ExchangeModel model : {ExchangeModel::consistent, ExchangeModel::paper})
                    for (const int channels : {1, 3}) expectSameAsPlain({direction}, interpolation, model, channels);
    });
}

// Where a volume repeats, bricks hang over the lattice's end and kernels take part of their lanes: the same by all.
TEST(Exchange, InPeriodicVolumesIsTheSameOnAllInstructionSets) {
    const Periodic periodic{true, true, true};
    for (const Vec3& direction : {Vec3(1, -0.3, 0.45), Vec3(-0.3, 0.9, 1)})
        for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear}) {
            std::vector<std::vector<float>> first;
            forEachInstructionSet([&] {
                Volume volume(1, periodic);
                ExchangeConstants constants;
                constants.escape = volume.escape.fit();
                constants.solidTau = 2;
                Beam beam = makeBeam(volume, direction, interpolation, 0);
                beam.front = parallelFront(volume.sweepVolume.layout, direction, interpolation == Interpolation::linear,
                                           0.31, 0.77, periodic);
                const ExchangeFields fields = volume.fields();
                sweep(volume.sweepVolume, {beam}, interpolation, fields, constants);
                if (interpolation == Interpolation::linear) settle(volume.sweepVolume, {beam}, fields, constants);
                const std::vector<const BrickField*> now = {&volume.unshot[0], &volume.deposit[0], &volume.furnace};
                if (first.empty()) {
                    for (const BrickField* field : now)
                        first.emplace_back(field->brick(0), field->brick(0) + field->brickCount() * kBrickVoxels);
                    return;
                }
                for (std::size_t f = 0; f < now.size(); ++f)
                    for (std::size_t i = 0; i < first[f].size(); ++i)
                        ASSERT_LE(std::abs(now[f]->brick(0)[i] - first[f][i]), 1e-5f)
                            << "field " << f << " voxel " << i;
            });
        }
}

TEST(Exchange, OfSeveralBeamsIsThatOfEachInTheSameVolume) {
    for (int major = 0; major < 3; ++major)
        for (const double way : {1.0, -1.0}) {
            std::vector<Vec3> directions;
            for (const double slope : {0.13, 0.47, 0.86}) {
                Vec3 direction;
                direction[major] = way;
                direction[(major + 1) % 3] = slope * way;
                direction[(major + 2) % 3] = -0.83 * slope;
                directions.push_back(direction);
            }
            for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear})
                for (const int channels : {1, 3})
                    expectSameAsPlain(directions, interpolation, ExchangeModel::consistent, channels);
        }
}

TEST(Exchange, BeamsThatGoDifferentWaysAreRefused) {
    Volume volume(1);
    std::vector<Beam> beams;
    for (const Vec3& direction : {Vec3(1, 0.5, 0.2), Vec3(1, -0.5, 0.2)})
        beams.push_back(makeBeam(volume, direction, Interpolation::nearest, 0));
    EXPECT_THROW(sweep(volume.sweepVolume, beams, Interpolation::nearest, volume.fields(), {}), InvalidArgument);
}

TEST(Exchange, EffectiveAlbedoIsThatOfItsFormulaOnAllInstructionSets) {
    const EscapeFit fit = Escape(Matrix3()).fit();
    alignas(64) float tau[kBrickVoxels], albedo[kBrickVoxels], g[kBrickVoxels];
    for (int i = 0; i < kBrickVoxels; ++i)
        tau[i] = std::min(kThickest, std::pow(10.0f, float(i) * 16 / kBrickVoxels - 9));
    forEachInstructionSet([&] {
        std::fill_n(albedo, kBrickVoxels, 1.0f);
        for (const ExchangeModel model : {ExchangeModel::consistent, ExchangeModel::paper}) {
            effectiveAlbedos(model, fit, nullptr, tau, albedo, g);
            for (int i = 0; i < kBrickVoxels; ++i) EXPECT_EQ(g[i], 1) << "optical depth " << tau[i];
        }
        std::fill_n(albedo, kBrickVoxels, 0.7f);
        effectiveAlbedos(ExchangeModel::consistent, fit, nullptr, tau, albedo, g);
        for (int i = 0; i < kBrickVoxels; ++i) {
            const double p = fit.probability(double(tau[i]));
            EXPECT_LE(std::abs(double(g[i]) / effectiveAlbedo(double(albedo[i]), p) - 1), 1e-6) << tau[i];
        }
    });
}
