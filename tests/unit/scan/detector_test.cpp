#include "raysweep/scan/detector.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/core/error.h"

using namespace raysweep;

namespace {

Projections even(float value) {
    Projections projections(50, 40, 10);
    std::fill(projections.values.begin(), projections.values.end(), value);
    return projections;
}

}  // namespace

// Counts N of mean N0 exp(-p) have the variance of their mean; -log(N / N0) then has 1 / N.
TEST(Detector, NoiseIsThatOfCountedPhotons) {
    DetectorModel model;
    model.photons = 2000;
    Projections projections = even(1.5f);
    detect(projections, model);
    double sum = 0, squares = 0;
    for (const float value : projections.values) {
        sum += value;
        squares += value * value;
    }
    const double count = double(projections.values.size()), mean = sum / count;
    const double expected = 1 / (2000 * std::exp(-1.5));
    EXPECT_NEAR(mean, 1.5 + expected / 2, 4 * std::sqrt(expected / count));  // log is curved; 4 standard errors
    EXPECT_NEAR((squares / count - mean * mean) / expected, 1, 0.05);        // 20000 samples know it to 1 %
    Projections again = even(1.5f);
    detect(again, model);
    EXPECT_EQ(again.values, projections.values);
    model.seed = 2;
    detect(again = even(1.5f), model);
    EXPECT_NE(again.values, projections.values);
}

TEST(Detector, SaturationAndBits) {
    DetectorModel model;
    model.saturation = 2;
    Projections projections = even(3);
    projections.values[0] = 1;
    projections.values[1] = std::nanf("");
    detect(projections, model);
    EXPECT_EQ(projections.saturation, 2);
    EXPECT_EQ(projections.values[0], 1);
    EXPECT_TRUE(std::isnan(projections.values[1]));
    EXPECT_EQ(projections.values[2], 2);

    model = DetectorModel();
    model.bits = 2;  // levels 0, 1, 2, 3 thirds
    projections = even(3);
    projections.values[0] = 0.4f;
    projections.values[1] = 1.6f;
    detect(projections, model);
    EXPECT_FLOAT_EQ(projections.values[0], 0);
    EXPECT_FLOAT_EQ(projections.values[1], 2);
    EXPECT_FLOAT_EQ(projections.values[2], 3);
}

TEST(Detector, NothingComesThroughThickBodies) {
    DetectorModel model;
    model.photons = 1000;
    Projections projections = even(100);
    detect(projections, model);
    for (const float value : projections.values) ASSERT_FLOAT_EQ(value, float(std::log(2000.0)));
}

TEST(Detector, RefusesWhatNoDetectorIs) {
    DetectorModel model;
    model.bits = 25;
    EXPECT_THROW(model.validate(), InvalidArgument);
    model = DetectorModel();
    model.photons = -1;
    EXPECT_THROW(model.validate(), InvalidArgument);
}
