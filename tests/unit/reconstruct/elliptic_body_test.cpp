// The ellipse that line integrals fit best.
#include "raysweep/reconstruct/elliptic_body.h"

#include "raysweep/core/types.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace raysweep;

namespace {

EllipticBody tilted() {
    EllipticBody body;
    body.xx = 36;
    body.yx = 9;
    body.yy = 25;
    body.centerX = 4;
    body.centerY = -5;
    body.extinction = 0.02;
    return body;
}

/// Lines at 60 angles that pass the origin within `field`, and what `measure` says of them.
template <class Measure>
std::vector<PlaneLine> linesWithin(double field, const Measure& measure) {
    std::vector<PlaneLine> lines;
    for (int n = 0; n < 60; ++n)
        for (int k = 0; k < 40; ++k) {
            const double angle = n * kPi / 60;
            PlaneLine line{std::cos(angle), std::sin(angle), field * (2 * (k + 0.5) / 40 - 1), 0};
            line.value = measure(line);
            lines.push_back(line);
        }
    return lines;
}

double through(const EllipticBody& body, const PlaneLine& line) {
    return body.lineIntegral(line.normalX, line.normalY, line.distance);
}

}  // namespace

TEST(EllipticBody, LineIntegralsAreChordsTimesExtinction) {
    EllipticBody circle;
    circle.xx = circle.yy = 5;
    circle.centerX = 2;
    circle.extinction = 0.1;
    EXPECT_NEAR(circle.lineIntegral(1, 0, 2), 1, 1e-12);    // through the middle
    EXPECT_NEAR(circle.lineIntegral(1, 0, 5), 0.8, 1e-12);  // 3 off it: a chord of 8
    EXPECT_NEAR(circle.lineIntegral(0, 1, 4), 0.6, 1e-12);
    EXPECT_EQ(circle.lineIntegral(0, 1, 5.1), 0);
    EXPECT_NEAR(circle.reach(), 7, 1e-12);
    // By steps along the line, which know nothing of the formula.
    const EllipticBody body = tilted();
    for (const double angle : {0.3, 1.9}) {
        const double nx = std::cos(angle), ny = std::sin(angle), step = 0.001;
        double inside = 0;
        for (double t = -100; t < 100; t += step) inside += body.contains(3 * nx - t * ny, 3 * ny + t * nx) ? step : 0;
        EXPECT_NEAR(body.lineIntegral(nx, ny, 3), 0.02 * inside, 2 * 0.02 * step) << angle;
    }
}

TEST(EllipticBody, TheBodyIsFoundFromLinesThatDoNotReachItsRim) {
    const EllipticBody body = tilted();
    const EllipticBody found =
        fitEllipticBody(linesWithin(20, [&](const PlaneLine& l) { return through(body, l); }), 20);
    EXPECT_NEAR(found.xx, body.xx, 1e-3);  // where steps gain less than a millionth
    EXPECT_NEAR(found.yx, body.yx, 1e-3);
    EXPECT_NEAR(found.yy, body.yy, 1e-3);
    EXPECT_NEAR(found.centerX, body.centerX, 1e-3);
    EXPECT_NEAR(found.centerY, body.centerY, 1e-3);
    EXPECT_NEAR(found.extinction, body.extinction, 1e-6);
}

TEST(EllipticBody, WhatIsInItIsPassedOver) {
    const EllipticBody body = tilted();
    EllipticBody ball;
    ball.xx = ball.yy = 5;
    ball.centerX = 12;
    ball.extinction = 0.03;
    const EllipticBody found =
        fitEllipticBody(linesWithin(20, [&](const PlaneLine& l) { return through(body, l) + through(ball, l); }), 20);
    EXPECT_NEAR(found.reach(), body.reach(), 0.02 * body.reach());
    EXPECT_NEAR(found.extinction, body.extinction, 0.02 * body.extinction);
}

TEST(EllipticBody, NothingIsNoBody) {
    EXPECT_EQ(fitEllipticBody(linesWithin(20, [](const PlaneLine&) { return 0.0; }), 20).extinction, 0);
}
