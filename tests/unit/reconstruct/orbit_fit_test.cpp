#include "raysweep/reconstruct/orbit_fit.h"

#include "raysweep/core/error.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/reconstruct/scan_angles.h"
#include "raysweep/reconstruct/view_matrix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

using namespace raysweep;

namespace {

CircularOrbit someOrbit(BeamShape beam) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.sourceToAxis = 50;
    orbit.sourceToDetector = 80;
    orbit.views = 24;
    orbit.firstAngle = 33;
    orbit.arc = beam == BeamShape::cone ? 220 : 180;
    orbit.width = 20;
    orbit.height = 12;
    orbit.axisColumn = 11;
    orbit.centerRow = 4;
    orbit.center = Vec3(2, -3, 5);
    return orbit;
}

/// x, y, z become y, z, x: a turn about x.
Vec3 turned(const Vec3& v) {
    return Vec3(v.z, v.x, v.y);
}

ProjectionGeometry turned(ProjectionGeometry geometry) {
    for (XrayView& view : geometry.views)
        for (Vec3* v : {&view.source, &view.direction, &view.origin, &view.column, &view.row}) *v = turned(*v);
    return geometry;
}

double sumOf(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace

TEST(OrbitFit, FindsAxisCentreAndAnglesOfATurn) {
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone})
        for (const bool aboutX : {false, true}) {
            const ProjectionGeometry upright = circularGeometry(someOrbit(beam));
            const OrbitFit fit = fitOrbit(aboutX ? turned(upright) : upright);
            const Vec3 axis = aboutX ? Vec3(1, 0, 0) : Vec3(0, 0, 1);
            const Vec3 center = aboutX ? turned(Vec3(2, -3, 5)) : Vec3(2, -3, 5);
            EXPECT_NEAR((fit.axis - axis).length(), 0, 1e-12);
            // Found: 1e-8, from the ridge of fitDirections. Along a parallel beam's axis the middle of the detector
            // counts: 1.5 rows below row 4.
            const Vec3 expected = beam == BeamShape::cone ? center : center - axis * 1.5;
            EXPECT_NEAR((fit.center - expected).length(), 0, 1.1e-8);
            EXPECT_NEAR(fit.radius, beam == BeamShape::cone ? 50 : 0, 1e-12);
            const double step = someOrbit(beam).arc / 24 * kPi / 180;
            for (std::size_t n = 1; n < 24; ++n) {
                const double turn = fit.angles[n] - fit.angles[n - 1];
                EXPECT_NEAR(turn < 0 ? turn + 2 * kPi : turn, step, 1e-12);
            }
        }
}

TEST(OrbitFit, ViewsThatDoNotTurnAboutAnAxisAreRefused) {
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        ProjectionGeometry geometry = circularGeometry(someOrbit(beam));
        EXPECT_THROW(fitOrbit(selectViews(geometry, {3})), InvalidArgument);
        EXPECT_THROW(fitOrbit(selectViews(geometry, {3, 3, 3})), InvalidArgument) << "all from one side";
        geometry.views[7].source.z += 10;
        geometry.views[7].direction = (geometry.views[7].direction + Vec3(0, 0, 0.2)).normalized();
        EXPECT_THROW(fitOrbit(geometry), InvalidArgument);
    }
}

TEST(ScanAngles, EvenViewsStandForEvenParts) {
    std::vector<double> angles;
    for (int n = 0; n < 36; ++n) angles.push_back((170 + 10 * n) * kPi / 180);
    for (const double period : {kPi, 2 * kPi}) {
        const ScanAngles scan = scanAngles(angles, period);
        EXPECT_TRUE(scan.closed);
        EXPECT_NEAR(sumOf(scan.weights), period, 1e-12);
        // Of half a turn each place is visited twice; the two visitors share what it stands for.
        for (int n = 0; n < 18; ++n)
            EXPECT_NEAR(scan.weights[n] + scan.weights[n + 18], 2 * period / 36, 1e-12) << "view " << n;
    }
}

TEST(ScanAngles, UnevenViewsStandForHalfTheGapsBesideThem) {
    const ScanAngles scan = scanAngles({0.1, 2.0, 0.7, 1.0}, kPi);
    EXPECT_TRUE(scan.closed);
    EXPECT_NEAR(scan.weights[2], 0.45, 1e-12);
    EXPECT_NEAR(scan.weights[3], 0.65, 1e-12);
    EXPECT_NEAR(scan.weights[0], 0.5 * (0.6 + kPi - 1.9), 1e-12);
    EXPECT_NEAR(sumOf(scan.weights), kPi, 1e-12);
}

TEST(ScanAngles, NobodyStandsForWhatAScanLeavesOut) {
    std::vector<double> angles;
    for (int n = 0; n < 50; ++n) angles.push_back((250 + 4 * n) * kPi / 180);  // 200 degrees, across 0
    const ScanAngles scan = scanAngles(angles, 2 * kPi);
    EXPECT_FALSE(scan.closed);
    EXPECT_NEAR(scan.arc, 200 * kPi / 180, 1e-12);
    ASSERT_EQ(scan.arcs.size(), 1u);
    EXPECT_NEAR(scan.arcs[0].begin, 248 * kPi / 180, 1e-12);
    for (const double weight : scan.weights) EXPECT_NEAR(weight, 4 * kPi / 180, 1e-12);
}

// Several exposures from one angle, whose numbers may differ in the last digits, do not make it stand for more.
TEST(ScanAngles, ViewsFromOneAngleShareWhatItStandsFor) {
    for (const int together : {2, 3, 12})
        for (const double apart : {0.0, 1e-13, 1e-7}) {
            std::vector<double> angles;
            for (int k = 0; k < 40; ++k)
                for (int i = 0; i < together; ++i)  // about 0 on both sides of it
                    angles.push_back(2 * kPi * k / 40 + apart * (i - 0.5 * together) / together);
            const ScanAngles scan = scanAngles(angles, 2 * kPi);
            EXPECT_TRUE(scan.closed);
            ASSERT_EQ(scan.directions.size(), 40u) << together << " " << apart;
            for (const double weight : scan.weights) EXPECT_NEAR(weight, 2 * kPi / 40 / together, 1e-9);
            EXPECT_NEAR(sumOf(scan.weights), 2 * kPi, 1e-12);
        }
}

TEST(ViewMatrix, PointsOfAPixelsRayFallOnIt) {
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        ProjectionGeometry geometry = circularGeometry(someOrbit(beam));
        for (XrayView& view : geometry.views) {  // tilted both ways
            view.column += Vec3(0.1, 0.2, 0.3);
            view.row += Vec3(-0.2, 0.1, 0.1);
            const ViewMatrix matrix = viewMatrix(view, beam);
            for (const double t : {0.3, 0.9, 1.4}) {
                const Vec3 pixel = view.pixel(4.25, 9.5);
                const Vec3 p = beam == BeamShape::cone ? view.source + (pixel - view.source) * t
                                                       : pixel + view.direction * (30 * t);
                const double depth = matrix.depth(p);
                EXPECT_NEAR(depth, beam == BeamShape::cone ? t : 1, 1e-12);
                EXPECT_NEAR(matrix.x(p) / depth, 4.25, 1e-12);
                EXPECT_NEAR(matrix.y(p) / depth, 9.5, 1e-12);
            }
        }
    }
}

TEST(ReconstructionGrid, CoversWhatTheDetectorSees) {
    CircularOrbit orbit;
    orbit.width = 100;
    orbit.height = 40;
    orbit.pixelWidth = orbit.pixelHeight = 0.5;
    orbit.center = Vec3(1, 2, 3);
    const ReconstructionGrid flat = coveringGrid(circularGeometry(orbit));
    EXPECT_EQ(flat.dims, Index3(100, 100, 40));
    EXPECT_NEAR((flat.center - orbit.center).length(), 0, 1e-12);
    EXPECT_NEAR(flat.edge(), 0.5, 1e-12);

    orbit.beam = BeamShape::cone;
    orbit.sourceToAxis = 100;
    orbit.sourceToDetector = 200;
    orbit.arc = 360;
    const ReconstructionGrid cone = coveringGrid(circularGeometry(orbit));
    EXPECT_NEAR(cone.edge(), 0.25, 1e-12) << "magnified twice";
    // The ray at the side leaves the axis aside at 100 sin(atan(25/200)), 12.4 units.
    EXPECT_EQ(cone.dims, Index3(100, 100, 40));
    EXPECT_NEAR((cone.center - orbit.center).length(), 0, 1e-12);

    const ReconstructionGrid turnedGrid = coveringGrid(turned(circularGeometry(orbit)));
    EXPECT_EQ(turnedGrid.dims, Index3(40, 100, 100)) << "a turn about x";
    EXPECT_NEAR((turnedGrid.center - turned(orbit.center)).length(), 0, 1e-12);
}

TEST(ReconstructionGrid, TransformPutsItsCentreWhereItWasAskedFor) {
    ReconstructionGrid grid;
    grid.dims = Index3(4, 5, 6);
    grid.center = Vec3(1, -2, 3);
    grid.spacing = Vec3(0.5);
    const openvdb::Vec3d first = grid.transform()->indexToWorld(openvdb::Vec3d(0, 0, 0));
    EXPECT_NEAR((Vec3(first.x(), first.y(), first.z()) - Vec3(0.25, -3, 1.75)).length(), 0, 1e-12);
    EXPECT_NEAR((grid.voxel(1.5, 2, 2.5) - grid.center).length(), 0, 1e-12);
    grid.dims.y = 0;
    EXPECT_THROW(grid.validate(), InvalidArgument);
    EXPECT_THROW(ReconstructionGrid().validate(), InvalidArgument);
}
