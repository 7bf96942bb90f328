// What words of fixed width have to keep to.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "cube4/illumination.h"
#include "cube4/reconstruction.h"

using namespace raysweep;
using namespace raysweep::cube4;

// Directions that go together shoot parts whose codes add up to more than 1 (24 times 171/4096), or powers that do once
// they are rounded (two halves of an odd one). A word without a sign would then hold nearly its largest power.
TEST(Cube4NumberRange, VoxelsShootNoMoreThanTheyHave) {
    for (const Rounding rounding : {Rounding::truncate, Rounding::nearest, Rounding::stochastic})
        for (const int beams : {2, 24}) {
            SCOPED_TRACE(testing::Message() << "rounding " << int(rounding) << ", " << beams << " directions");
            DenseMedium medium;
            medium.box.high = Index3(3);
            medium.box.worldFromIndex.makeIdentity();
            medium.extinction.assign(27, 0.5f);
            medium.albedo.assign(27, 0.0f);
            medium.unshot.assign(27, 1.0f);
            IlluminationSetup setup;
            setup.pipelines = 2;
            setup.zeta = setup.mostShot = 1.0 / beams;
            setup.format.emplace().rounding = rounding;
            setup.format->scalar = 8;
            Illumination machine(medium, setup);
            std::vector<SweepFront> fronts;
            for (int i = 0; i < beams; ++i) fronts.push_back({Vec3(0.3 * i / beams, 0.2, i % 2 ? -1 : 1), 0.5, 0.5, 0});
            double escaped = 0;
            for (int group = 0; group < 3; ++group) {
                for (const FrontPower& power : machine.sweep(fronts, false)) escaped += power.escaped;
                const DenseField unshot = machine.unshot();
                EXPECT_GE(*std::min_element(unshot.begin(), unshot.end()), 0.0f);
            }
            // Drawn apart, what a voxel takes and what a ray loses are equal on average only.
            if (rounding == Rounding::stochastic) continue;
            double held = escaped;
            for (const float power : machine.unshot()) held += double(power);
            for (const float power : machine.deposit()) held += double(power);
            EXPECT_NEAR(held, 27, 1e-5);  // fields are floats
        }
}

// λ is counted in units of voxels per unit of rays. Where rays have 16 bits more it would be nothing with 16 fraction
// bits.
TEST(Cube4NumberRange, RelaxationIsWhatItIsWhateverTheWidths) {
    DenseBox box;
    box.high = Index3(6);
    box.worldFromIndex.makeIdentity();
    MeasuredView view;
    view.rays.origin = Vec3(-1, -1, -5);
    view.rays.column = Vec3(1, 0, 0);
    view.rays.row = Vec3(0, 1, 0);
    view.width = view.height = 9;
    view.values.assign(81, 3.0f);
    ReconstructionSetup setup;
    setup.pipelines = 2;
    setup.upper = 1;
    setup.saturation = std::numeric_limits<double>::infinity();
    const auto meanAfterUpdates = [&] {
        Reconstruction machine(box, Vec3(0), setup);
        for (int n = 0; n < 5; ++n) machine.update(view, 0.02);
        double sum = 0;
        for (const float value : machine.volume()) sum += double(value);
        return sum / double(box.voxels());
    };
    const double exact = meanAfterUpdates();
    EXPECT_GT(exact, 0.04);
    setup.format.emplace().rounding = Rounding::stochastic;
    setup.format->scalar = 8;
    for (const int energy : {8, 12, 16, 20, 24, 31}) {
        SCOPED_TRACE(energy);
        setup.format->energy = energy;
        // 216 voxels, each a random half unit of 1/255 off in each of 5 updates: 3e-4. Four times that.
        EXPECT_NEAR(meanAfterUpdates(), exact, 1.2e-3);
    }
}
