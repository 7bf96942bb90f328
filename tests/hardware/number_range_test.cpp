// What words of fixed width have to keep to.
#include <gtest/gtest.h>

#include <algorithm>

#include "cube4/illumination.h"

using namespace raysweep;
using namespace raysweep::cube4;

// Directions that go together shoot parts whose codes add up to more than 1 (24 times 171/4096), or powers that do once
// they are rounded (two halves of an odd one). A word without a sign would then hold nearly its largest power.
TEST(Cube4NumberRange, VoxelsShootNoMoreThanTheyHave) {
    for (const Rounding rounding : {Rounding::truncate, Rounding::nearest, Rounding::stochastic})
        for (const int beams : {2, 6, 24, 32}) {
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
