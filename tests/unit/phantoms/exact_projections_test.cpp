#include "raysweep/phantoms/exact_projections.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace raysweep;

// A ball's chord depends on the ray's distance from its centre only: 2 sqrt(r² - d²), in any geometry.
TEST(ExactProjections, OfABallAreChords) {
    const Vec3 center(3, -2, 1);
    const double radius = 8;
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        CircularOrbit orbit;
        orbit.beam = beam;
        orbit.sourceToAxis = 60;
        orbit.sourceToDetector = 100;
        orbit.views = 7;
        orbit.arc = 360;
        orbit.width = 40;
        orbit.height = 31;
        const ProjectionGeometry geometry = circularGeometry(orbit);
        const Projections projections = exactProjections({ellipsoid(0.5, center, Vec3(radius))}, geometry);
        ASSERT_EQ(projections.values.size(), 7u * 40 * 31);
        int hit = 0;
        for (int n = 0; n < 7; ++n)
            for (int y = 0; y < 31; ++y)
                for (int x = 0; x < 40; ++x) {
                    const XrayView& view = geometry.views[n];
                    const Vec3 pixel = view.pixel(x, y);
                    const Vec3 ray = beam == BeamShape::cone ? (pixel - view.source).normalized() : view.direction;
                    const double distance2 = ray.cross(center - pixel).length2();
                    const double chord = 2 * std::sqrt(std::max(0.0, radius * radius - distance2));
                    const double measured = projections.view(n)[y * 40 + x];
                    ASSERT_NEAR(measured, 0.5 * chord, 1e-6) << "view " << n << ", column " << x << ", row " << y;
                    hit += chord > 0;
                }
        EXPECT_GT(hit, 1000);
    }
}

TEST(ExactProjections, RaysOfAConeBeginAtTheSourceAndDoNotEndAtTheDetector) {
    CircularOrbit orbit;
    orbit.beam = BeamShape::cone;
    orbit.sourceToAxis = orbit.sourceToDetector = 10;
    orbit.views = orbit.width = orbit.height = 1;
    const ProjectionGeometry geometry = circularGeometry(orbit);
    EXPECT_NEAR(exactProjections({box(1, Vec3(0), Vec3(2))}, geometry).values[0], 4, 1e-6);
    EXPECT_NEAR(exactProjections({box(1, Vec3(20, 0, 0), Vec3(2))}, geometry).values[0], 0, 1e-6)
        << "behind the source";
    EXPECT_THROW(exactProjections({}, ProjectionGeometry()), InvalidArgument);
}
