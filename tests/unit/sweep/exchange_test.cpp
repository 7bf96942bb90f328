// The vectorised exchange against its formulas, written down once more voxel by voxel in doubles (plain_exchange.h).
#include "raysweep/sweep/exchange.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <sstream>

#include "plain_exchange.h"
#include "raysweep/core/error.h"
#include "raysweep/sweep/sweep.h"
#include "support/worst.h"
#include "unit/instruction_sets.h"

using namespace raysweep;
using test::ExchangeCase;
using test::ExchangeVolume;
using test::PlainChange;
using test::PlainField;

namespace {

// Each value has gone through some dozen operations on floats of order 1, which are off by up to 6e-8 each. Found, over
// all cases with AVX-512, AVX2, SSE4 and without vectors: 3.7e-8, 5.6e-7, 8.1e-7 and 3.4e-7.
constexpr double kEscapedError = 4e-8;  ///< of itself: the errors of hundreds of rays cancel
constexpr double kUnshotError = 6.1e-7;
constexpr double kDepositError = 8.8e-7;
constexpr double kFurnaceError = 3.7e-7;
constexpr double kSetsDiffer = 5.2e-7;  ///< found 4.8e-7

/// A beam along `direction`, with powers of its own.
Beam makeBeam(const ExchangeVolume& volume, const Vec3& direction, int reach, int number) {
    Beam beam;
    beam.front = parallelFront(volume.sweepVolume.layout, direction, reach, {0.31, 0.77}, volume.sweepVolume.periodic);
    beam.stepScale = float(beam.front.stepLength / volume.escape.meanStepLength());
    for (int c = 0; c < volume.channels; ++c) beam.entering[c] = 0.5f + 0.25f * float(c) + 0.1f * float(number);
    beam.furnaceRay = 0.7f;
    return beam;
}

/// Along axis `major`, forwards (1) or backwards (-1), with these slopes along the other two.
Vec3 directionAlong(int major, double way, double slope1, double slope2) {
    Vec3 direction;
    direction[major] = way;
    direction[(major + 1) % 3] = slope1;
    direction[(major + 2) % 3] = slope2;
    return direction;
}

/// Largest difference of a field from what it was before with the changes of all beams.
double worstOf(const BrickField& field, const BrickField& before, const std::vector<const PlainField*>& changes) {
    double worst = 0;
    for (std::size_t i = 0; i < changes[0]->size(); ++i) {
        double expected = double(before.brick(0)[i]);
        for (const PlainField* const change : changes) expected += (*change)[i];
        test::raiseTo(worst, std::abs(double(field.brick(0)[i]) - expected));
    }
    return worst;
}

std::ostream& operator<<(std::ostream& out, const ExchangeCase& of) {
    return out << "interpolation " << int(of.interpolation) << " model " << int(of.model) << " channels " << of.channels
               << " surfaces " << of.surfaces << " thickest " << of.thickest << " periodic " << of.periodic[0]
               << of.periodic[1] << of.periodic[2] << " direct " << of.direct;
}

ExchangeConstants constantsOf(const ExchangeCase& of, const ExchangeVolume& volume, std::size_t beams) {
    ExchangeConstants constants;
    constants.model = of.model;
    constants.escape = volume.escape.fit();
    constants.zeta = 0.9f / float(beams);
    constants.mostShot = 1 / float(beams);
    constants.direct = of.direct;
    return constants;
}

/// As kernels do it.
std::vector<RaySums> sweepAndSettle(const ExchangeCase& of, const std::vector<Beam>& beams,
                                    const ExchangeConstants& constants, ExchangeVolume& volume) {
    const ExchangeFields fields = volume.fields();
    const std::vector<RaySums> sums = sweep(volume.sweepVolume, beams, of.interpolation, fields, constants);
    if (of.interpolation == Interpolation::linear) settle(volume.sweepVolume, beams, fields, constants);
    return sums;
}

/// Sweeps as kernels do, and compares. All beams read the volume as it was: `plain` are the changes of each alone.
void expectPlain(const ExchangeCase& of, const ExchangeVolume& before, ExchangeVolume& volume,
                 const std::vector<Beam>& beams, const ExchangeConstants& constants,
                 const std::vector<PlainChange>& plain) {
    volume.restore(before);
    const std::vector<RaySums> sums = sweepAndSettle(of, beams, constants, volume);
    const auto ofAll = [&](const auto& member) {
        std::vector<const PlainField*> changes;
        for (const PlainChange& change : plain) changes.push_back(&member(change));
        return changes;
    };
    for (int c = 0; c < of.channels; ++c) {
        for (std::size_t i = 0; i < beams.size(); ++i)
            EXPECT_LE(std::abs(sums[i].escaped[c] / plain[i].escaped[c] - 1), kEscapedError);
        EXPECT_LE(worstOf(volume.unshot[c], before.unshot[c],
                          ofAll([c](const PlainChange& change) -> auto& { return change.unshot[c]; })),
                  kUnshotError);
        EXPECT_LE(worstOf(volume.deposit[c], before.deposit[c],
                          ofAll([c](const PlainChange& change) -> auto& { return change.deposit[c]; })),
                  kDepositError);
    }
    if (!of.surfaces) return;
    EXPECT_GT(*std::max_element(plain[0].furnace.begin(), plain[0].furnace.end()), 0.1);
    EXPECT_LE(worstOf(volume.furnace, before.furnace,
                      ofAll([](const PlainChange& change) -> auto& { return change.furnace; })),
              kFurnaceError);
}

/// On all instruction sets.
void expectSameAsPlain(const std::vector<Vec3>& directions, const ExchangeCase& of) {
    const ExchangeVolume before(of);
    ExchangeVolume volume(of);
    const ExchangeConstants constants = constantsOf(of, before, directions.size());
    std::vector<Beam> beams;
    std::vector<PlainChange> plain;
    for (const Vec3& direction : directions) {
        beams.push_back(makeBeam(before, direction, of.reach(), int(beams.size())));
        plain.push_back(test::plainSweep(before, constants, beams.back()));
    }
    std::ostringstream what;
    what << "direction " << directions[0] << ", beams " << beams.size() << " " << of;
    SCOPED_TRACE(what.str());
    test::forEachInstructionSet([&] { expectPlain(of, before, volume, beams, constants, plain); });
}

constexpr Interpolation kInterpolations[] = {Interpolation::nearest, Interpolation::linear};
constexpr ExchangeModel kModels[] = {ExchangeModel::corrected, ExchangeModel::asPrinted};

}  // namespace

TEST(Exchange, AgreesWithItsFormulasAlongAllAxes) {
    for (int major = 0; major < 3; ++major)
        for (int signs = 0; signs < 8; ++signs)
            for (const Interpolation interpolation : kInterpolations)
                for (const ExchangeModel model : kModels)
                    for (const int channels : {1, 3})
                        expectSameAsPlain({directionAlong(major, signs & 1 ? 1 : -1, signs & 2 ? 0.6 : -0.3,
                                                          signs & 4 ? 0.9 : -0.45)},
                                          {interpolation, model, channels});
}

// What surfaces take of rays that leave is all that is different; as printed the algorithm knows of no difference.
TEST(Exchange, OfDirectLightAgreesWithItsFormulas) {
    for (int major = 0; major < 3; ++major)
        for (const double way : {1.0, -1.0})
            for (const Interpolation interpolation : kInterpolations)
                for (const ExchangeModel model : kModels) {
                    ExchangeCase of{interpolation, model};
                    of.direct = true;
                    expectSameAsPlain({directionAlong(major, way, 0.6, -0.45)}, of);
                }
}

// Kernels have a shorter formula where all voxels are thin, and one for bricks without surfaces; in a periodic volume
// bricks hang over the end of the lattice of rays.
TEST(Exchange, AgreesWithItsFormulasInThinAndThickMediaAndPeriodicVolumes) {
    for (int major = 0; major < 3; ++major) {
        Periodic around = {true, true, true};
        around[std::size_t(major)] = false;
        for (const Periodic& periodic : {Periodic{false, false, false}, around})
            for (const bool surfaces : {false, true})
                for (const double thickest : {0.5, 20.0})
                    for (const Interpolation interpolation : kInterpolations)
                        for (const ExchangeModel model : kModels)
                            for (const int channels : {1, 3})
                                expectSameAsPlain({directionAlong(major, 1, 0.6, -0.45)},
                                                  {interpolation, model, channels, surfaces, thickest, periodic});
    }
}

// Along a sweep's axis that repeats, rays go round until a millionth is left; there is no plain twin of that.
TEST(Exchange, InPeriodicVolumesIsTheSameOnAllInstructionSets) {
    for (const Interpolation interpolation : kInterpolations)
        for (const Vec3& direction : {Vec3(1, -0.3, 0.45), Vec3(-0.3, 0.9, 1)}) {
            const ExchangeCase of{interpolation, ExchangeModel::corrected, 1, true, 20, {true, true, true}};
            const ExchangeVolume before(of);
            ExchangeVolume best(of), volume(of);
            const std::vector<Beam> beams{makeBeam(before, direction, of.reach(), 0)};
            const ExchangeConstants constants = constantsOf(of, before, 1);
            sweepAndSettle(of, beams, constants, best);
            const PlainField none(before.sweepVolume.layout.brickCount() * kBrickVoxels, 0.0);
            test::forEachInstructionSet([&] {
                volume.restore(before);
                sweepAndSettle(of, beams, constants, volume);
                EXPECT_LE(worstOf(volume.unshot[0], best.unshot[0], {&none}), kSetsDiffer);
                EXPECT_LE(worstOf(volume.deposit[0], best.deposit[0], {&none}), kSetsDiffer);
                const PlainField noneAtSurfaces(before.furnace.brickCount() * kBrickVoxels, 0.0);
                EXPECT_LE(worstOf(volume.furnace, best.furnace, {&noneAtSurfaces}), kSetsDiffer);
            });
        }
}

/// Some go one way along the columns and some the other, beginning with either.
TEST(Exchange, OfSeveralBeamsIsThatOfEachInTheSameVolume) {
    for (int major = 0; major < 3; ++major)
        for (const double way : {1.0, -1.0}) {
            std::vector<Vec3> directions;
            for (const double slope : {0.13, 0.47, 0.86}) {
                Vec3 direction;
                direction[major] = way;
                direction[sweepAxis(major).row] = slope * way;
                direction[sweepAxis(major).column] = (directions.size() % 2 ? 0.83 : -0.71) * slope * way;
                directions.push_back(direction);
            }
            for (const Interpolation interpolation : kInterpolations)
                for (const int channels : {1, 3})
                    expectSameAsPlain(directions, {interpolation, ExchangeModel::corrected, channels});
        }
}

TEST(Exchange, BeamsThatGoDifferentWaysAreRefused) {
    ExchangeVolume volume({});
    std::vector<Beam> beams;
    for (const Vec3& direction : {Vec3(1, 0.5, 0.2), Vec3(1, -0.5, 0.2)})  // rows are met in different orders
        beams.push_back(makeBeam(volume, direction, 0, 0));
    EXPECT_THROW(sweep(volume.sweepVolume, beams, Interpolation::nearest, volume.fields(), {}), InvalidArgument);
}

TEST(Exchange, EffectiveAlbedoIsThatOfItsFormulaOnAllInstructionSets) {
    const EscapeFit fit = Escape(Matrix3()).fit();
    alignas(64) float tau[kBrickVoxels], conservative[kBrickVoxels], albedo[kBrickVoxels], g[kBrickVoxels];
    std::fill_n(conservative, kBrickVoxels, 1.0f);
    std::fill_n(albedo, kBrickVoxels, 0.7f);
    for (int i = 0; i < kBrickVoxels; ++i)
        tau[i] = std::min(kThickest, std::pow(10.0f, float(i) * 16 / kBrickVoxels - 9));
    test::forEachInstructionSet([&] {
        for (const ExchangeModel model : kModels) {
            effectiveAlbedos({model, fit}, nullptr, tau, conservative, g);
            for (int i = 0; i < kBrickVoxels; ++i) EXPECT_EQ(g[i], 1) << "optical depth " << tau[i];
        }
        effectiveAlbedos({ExchangeModel::corrected, fit}, nullptr, tau, albedo, g);
        for (int i = 0; i < kBrickVoxels; ++i) {
            const double p = fit.probability(double(tau[i]));
            const double expected = double(albedo[i]) * leavingShare(double(albedo[i]), p);
            EXPECT_LE(std::abs(double(g[i]) / expected - 1), 4e-7) << tau[i];  // found 3.7e-7: six roundings
        }
    });
}
