#include "raysweep/reconstruct/ramp_filter.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/types.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace raysweep;

// A disc's parallel projection is 2 sqrt(r² - t²). As all views are alike and their mean over half a turn is 1 inside,
// its ramp filtered projection is 1/pi there; outside it is (1 - |t| / sqrt(t² - r²)) / pi.
TEST(RampFilter, FilteredProjectionOfADiscIsTheClosedForm) {
    const int width = 1001;
    const double radius = 200.5;
    std::vector<float> row(width);
    for (int x = 0; x < width; ++x)
        row[x] = float(2 * std::sqrt(std::max(0.0, radius * radius - std::pow(x - 500, 2))));
    RampFilter(width).apply(row.data(), 1, width);
    for (int x = 0; x < width; ++x) {
        const double t = std::abs(x - 500.0);
        if (std::abs(t - radius) < 20) continue;  // rings at the jump
        const double expected = (t < radius ? 1 : 1 - t / std::sqrt(t * t - radius * radius)) / kPi;
        // Rings fall with the distance from the rim; 20 samples away they are 0.28 % of the jump.
        EXPECT_NEAR(row[x], expected, 0.00306 / kPi * (1 + std::abs(expected))) << "at " << t;
    }
    EXPECT_NEAR(row[500], 1 / kPi, 1.18e-5) << "far from the rim";
}

// Kak and Slaney's kernel, summed in space: what the transform must give but for rounding of floats.
TEST(RampFilter, IsTheConvolutionWithTheKernelWithoutWrappingAround) {
    for (const int width : {1, 2, 37, 64}) {
        std::vector<float> row(width);
        for (int x = 0; x < width; ++x) row[x] = float(std::sin(x * 1.7) + (x == 0 ? 3 : 0));
        std::vector<float> filtered = row;
        RampFilter(width).apply(filtered.data(), 1, width);
        for (int x = 0; x < width; ++x) {
            double sum = 0.25 * row[x];
            for (int from = 0; from < width; ++from)
                if ((from - x) % 2 != 0) sum -= row[from] / std::pow(kPi * (from - x), 2);
            EXPECT_NEAR(filtered[x], sum, 3.09e-8) << width << ": " << x;
        }
    }
}

// |f| is 0 at 0. A row has ends, so what remains in the middle of one of 1 is what lies beyond them: 2/(pi² width).
TEST(RampFilter, AConstantRowVanishes) {
    for (const RampWindow window :
         {RampWindow::ramLak, RampWindow::sheppLogan, RampWindow::cosine, RampWindow::hamming, RampWindow::hann}) {
        const int width = 2000;
        std::vector<float> row(width, 1.0f);
        RampFilter(width, window).apply(row.data(), 1, width);
        // An even number of samples, so the middle lies between two: the kernel's alternate zeros leave ~1/width².
        EXPECT_NEAR(0.5 * (row[width / 2 - 1] + row[width / 2]), 2 / (kPi * kPi * width), 1.32e-10);
    }
}

TEST(RampFilter, WindowsPassLowFrequenciesAndHoldBackHighOnes) {
    const int width = 512;
    const auto amplitude = [&](RampWindow window, double cutoff, double frequency) {
        std::vector<float> row(width);
        for (int x = 0; x < width; ++x) {
            const double hump = std::pow(std::sin(kPi * (x + 0.5) / width), 4);
            row[x] = float(hump * std::cos(2 * kPi * frequency * (x - width / 2)));
        }
        RampFilter(width, window, cutoff).apply(row.data(), 1, width);
        return double(row[width / 2]);
    };
    // A wave of frequency f leaves with amplitude f times the window; the hump spreads f by 1/512. Found: up to 2.5e-5.
    EXPECT_NEAR(amplitude(RampWindow::ramLak, 1, 0.25), 0.25, 2.76e-5);
    EXPECT_NEAR(amplitude(RampWindow::sheppLogan, 1, 0.25), 0.25 * std::sin(kPi / 4) / (kPi / 4), 2.76e-5);
    EXPECT_NEAR(amplitude(RampWindow::cosine, 1, 0.25), 0.25 * std::cos(kPi / 4), 2.76e-5);
    EXPECT_NEAR(amplitude(RampWindow::hamming, 1, 0.25), 0.25 * 0.54, 2.76e-5);
    EXPECT_NEAR(amplitude(RampWindow::hann, 1, 0.25), 0.25 * 0.5, 2.76e-5);
    EXPECT_NEAR(amplitude(RampWindow::hann, 0.5, 0.125), 0.125 * 0.5, 2.76e-5);
    EXPECT_NEAR(amplitude(RampWindow::ramLak, 0.5, 0.3), 0, 4.6e-9) << "beyond the cutoff";
    EXPECT_THROW(RampFilter(8, RampWindow::hann, 0), InvalidArgument);
    EXPECT_THROW(RampFilter(8, RampWindow::hann, 1.5), InvalidArgument);
    EXPECT_THROW(RampFilter(0), InvalidArgument);
}

TEST(RampFilter, RowsAreFilteredEachForItselfAndGapsBetweenThemStay) {
    const int width = 50, stride = 57, count = 23;
    std::vector<float> rows(std::size_t(stride) * count, -7.0f);
    for (int n = 0; n < count; ++n)
        for (int x = 0; x < width; ++x) rows[n * stride + x] = float((n * 31 + x * 17) % 11);
    std::vector<float> alone = rows;
    RampFilter(width).apply(rows.data(), count, stride);
    for (int n = 0; n < count; ++n) {
        RampFilter(width).apply(alone.data() + n * stride, 1, stride);
        for (int x = 0; x < stride && n * stride + x < int(rows.size()); ++x)
            EXPECT_NEAR(rows[n * stride + x], alone[n * stride + x], 1e-7);
    }
}
