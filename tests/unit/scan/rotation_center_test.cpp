// The axis' column is found where it was put, to a tenth of a column.
#include "raysweep/scan/rotation_center.h"

#include "raysweep/scan/data_exchange.h"
#include "raysweep/scan/line_integrals.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include "support/volumes.h"
#include "unit/scan/ct_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

// Reconstructions show no difference below a tenth of a column; limits are a tenth above what is found.

void addNoise(Projections& projections, double sigma) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0, sigma);
    for (float& value : projections.values) value += float(normal(random));
}

}  // namespace

TEST(RotationCenter, LastViewAtHalfATurn) {
    const std::vector<double> angles = anglesFrom(0, 1, 181);
    for (const double axis : {100.3, 127.5, 128.0, 151.77})
        EXPECT_NEAR(findRotationCenter(sinogram(lopsidedBody(), 256, axis, angles), angles).column, axis, 0.0017);
}

TEST(RotationCenter, LastViewOneStepBeforeHalfATurn) {
    // All of it far from the axis, and moving one way in the first view: the last view alone, for the missing one,
    // would be wrong by half a step of it.
    const std::vector<Disc> body = {{70, -5, 20, 0.03}, {60, 12, 6, 0.04}, {75, -20, 5, -0.02}};
    for (const int views : {90, 180, 181, 720}) {
        const std::vector<double> angles = anglesFrom(17, 180.0 / views, views);
        for (const double axis : {100.3, 127.5, 151.77})
            for (const auto& discs : {lopsidedBody(), body})
                EXPECT_NEAR(findRotationCenter(sinogram(discs, 256, axis, angles), angles).column, axis, 0.0234)
                    << views << " views";
    }
}

TEST(RotationCenter, FullTurnsEitherWayInAnyOrder) {
    for (const double step : {1.0, -1.0, 0.7}) {
        std::vector<double> angles = anglesFrom(-50, step, int(360 / std::abs(step)));
        std::shuffle(angles.begin(), angles.end(), std::mt19937(6));
        EXPECT_NEAR(findRotationCenter(sinogram(lopsidedBody(), 256, 120.4, angles), angles).column, 120.4, 0.00214)
            << "step " << step;
    }
}

TEST(RotationCenter, BodyThatSticksOutOfTheView) {
    // 3 times as wide as the detector, with details inside and outside of what all views see.
    std::vector<Disc> body = lopsidedBody();
    for (Disc& disc : body) disc = {3 * disc.x, 3 * disc.y, 3 * disc.radius, disc.mu / 3};
    for (const Disc& disc : {Disc{10, 20, 8, 0.02}, Disc{-30, -12, 5, 0.03}, Disc{25, -40, 11, -0.004}})
        body.push_back(disc);
    for (const double axis : {80.6, 127.5, 170.2})
        for (const int views : {360, 361}) {
            const std::vector<double> angles = anglesFrom(0, 0.5, views);
            EXPECT_NEAR(findRotationCenter(sinogram(body, 256, axis, angles), angles).column, axis, 0.0273)
                << views << " views";
        }
}

TEST(RotationCenter, NoiseAndGapsDoNoHarm) {
    const std::vector<double> angles = anglesFrom(0, 1, 180);
    Projections noisy = sinogram(lopsidedBody(), 256, 118.3, angles);  // up to 2
    addNoise(noisy, 0.03);
    for (const int dead : {40, 119, 200})
        for (int n = 0; n < noisy.views; ++n) noisy.view(n)[dead] = std::numeric_limits<float>::quiet_NaN();
    const RotationCenter center = findRotationCenter(noisy, angles);
    EXPECT_NEAR(center.column, 118.3, 0.0289);
    EXPECT_LT(center.mismatch, 3.87e-4);
}

TEST(RotationCenter, RowsThatWereNotMeasuredAreLeftOut) {
    const std::vector<double> angles = anglesFrom(0, 1, 181);
    const Projections measured = sinogram(lopsidedBody(), 256, 120.4, angles);
    Projections two(256, 2, 181);
    for (int view = 0; view < 181; ++view) {
        std::fill_n(two.view(view), 256, std::numeric_limits<float>::quiet_NaN());
        std::copy_n(measured.view(view), 256, two.view(view) + 256);
    }
    EXPECT_NEAR(findRotationCenter(two, angles).column, 120.4, 7.5e-4);
    for (int view = 0; view < 181; ++view) two.view(view)[300] = two.view(view)[0];
    std::fill(two.view(7), two.view(7) + 512, std::numeric_limits<float>::quiet_NaN());
    EXPECT_THROW(findRotationCenter(two, angles), InvalidArgument);
}

TEST(RotationCenter, NarrowDetectorsWork) {
    const std::vector<double> angles = anglesFrom(0, 2, 91);
    for (const int width : {16, 20})
        EXPECT_NEAR(findRotationCenter(sinogram({{1, 0.5, 3, 0.1}}, width, 0.5 * width, angles), angles).column,
                    0.5 * width, 0.0223);
}

TEST(RotationCenter, WhatCannotBeFoundIsRefused) {
    const std::vector<double> angles = anglesFrom(0, 1, 180), tooFew = anglesFrom(0, 1, 170);
    const Projections body = sinogram(lopsidedBody(), 256, 118.3, angles);
    expectError<InvalidArgument>([&] { findRotationCenter(body, tooFew); }, "170 angles do not fit 180 views");
    expectError<InvalidArgument>([&] { findRotationCenter(sinogram(lopsidedBody(), 256, 118.3, tooFew), tooFew); },
                                 "the views span 169 degrees");
    expectError<InvalidArgument>([&] { findRotationCenter(Projections(256, 1, 1), {0}); }, "the views span 0 degrees");
    expectError<InvalidArgument>([&] { findRotationCenter(Projections(256, 1, 180), angles); }, "nothing in common");
    expectError<InvalidArgument>([&] { findRotationCenter(Projections(8, 1, 180), angles); }, "8 columns: too few");
    std::vector<double> broken = angles;
    broken[3] = std::numeric_limits<double>::quiet_NaN();
    expectError<InvalidArgument>([&] { findRotationCenter(body, broken); }, "must be finite");
}

TEST(RotationCenter, ToothIsFoundWhereItsScanSaysAndInPartsOfItToo) {
    const std::string path = findData("ct/tomopy_tooth.h5");
    if (path.empty()) GTEST_SKIP() << "ct/tomopy_tooth.h5 is not on this machine; set RAYSWEEP_DATA";
    const DataExchange scan = readDataExchange(path);
    const Projections tooth = lineIntegrals(scan.counts, scan.flat, scan.dark).projections;
    EXPECT_NEAR(findRotationCenter(tooth, scan.angles).column, 296, 0.167);  // known to a column; found: 0.152
    for (const int left : {100, 200}) {                                      // the tooth is in columns 130 to 460 or so
        Projections part(340, tooth.height, tooth.views);
        for (int n = 0; n < tooth.views; ++n)
            for (int y = 0; y < tooth.height; ++y)
                std::copy_n(tooth.view(n) + y * 640 + left, 340, part.view(n) + y * 340);
        EXPECT_NEAR(left + findRotationCenter(part, scan.angles).column, 296, 0.186) << "columns from " << left;
    }
}
