#include "raysweep/reconstruct/fbp.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/phantoms/exact_projections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "unit/instruction_sets.h"

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

struct Case {
    ProjectionGeometry geometry;
    Projections projections;
    ReconstructionGrid grid;
};

Case smallCase(BeamShape beam) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.sourceToAxis = 60;
    orbit.sourceToDetector = 90;
    orbit.views = 30;
    orbit.arc = beam == BeamShape::cone ? 360 : 180;
    orbit.width = 40;
    orbit.height = 20;
    Case c;
    c.geometry = circularGeometry(orbit);
    c.projections = exactProjections({ellipsoid(1, Vec3(1, 2, 0), Vec3(6, 5, 7))}, c.geometry);
    c.grid.dims = Index3(20, 18, 11);
    c.grid.spacing = Vec3(1);
    return c;
}

std::string messageOf(const Case& c) {
    try {
        filteredBackprojection(c.projections, c.geometry, c.grid);
    } catch (const InvalidArgument& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST(Fbp, GridIsWhereItWasAskedForAndTheSameForAnyNumberOfThreads) {
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        Case c = smallCase(beam);
        c.grid.center = Vec3(1, 0, 0);
        FloatGrid::Ptr grids[2];
        for (int threads = 1; threads <= 2; ++threads) {
            const ThreadLimit limit(threads);
            grids[threads - 1] = filteredBackprojection(c.projections, c.geometry, c.grid);
        }
        const FloatGrid& grid = *grids[0];
        EXPECT_EQ(grid.getName(), "density");
        EXPECT_EQ(grid.evalActiveVoxelBoundingBox(), openvdb::CoordBBox(Coord(0), Coord(19, 17, 10)));
        const openvdb::Vec3d middle = grid.indexToWorld(openvdb::Vec3d(9.5, 8.5, 5));
        EXPECT_NEAR((middle - openvdb::Vec3d(1, 0, 0)).length(), 0, 1e-12);
        EXPECT_TRUE(grid.tree().hasSameTopology(grids[1]->tree()));
        for (auto it = grid.cbeginValueOn(); it; ++it) ASSERT_EQ(*it, grids[1]->tree().getValue(it.getCoord()));
    }
}

// Vectors of voxels find their rows in tables, or fetch them one by one: coarse and fine rows, columns of voxels that
// the detector's follow, and some that they do not. The set without vectors is the plain twin. Places are rounded
// otherwise where multiply-adds are fused.
TEST(Fbp, AllInstructionSetsAgree) {
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone})
        for (const double spacing : {0.3, 1.0, 1.9, 4.0})
            for (const bool leaning : {false, true}) {
                Case c = smallCase(beam);
                c.grid.spacing = Vec3(spacing);
                c.grid.dims = Index3(9, 10, 21);
                for (XrayView& view : c.geometry.views)
                    for (Vec3* v : {&view.source, &view.direction, &view.origin, &view.column, &view.row})
                        if (leaning) *v = Vec3(v->x, 0.6 * v->y - 0.8 * v->z, 0.8 * v->y + 0.6 * v->z);
                std::vector<FloatGrid::Ptr> found;
                test::forEachInstructionSet(
                    [&] { found.push_back(filteredBackprojection(c.projections, c.geometry, c.grid)); });
                for (const FloatGrid::Ptr& grid : found)
                    for (auto it = found[0]->cbeginValueOn(); it; ++it)
                        ASSERT_NEAR(*it, grid->tree().getValue(it.getCoord()), 1e-5) << spacing;
            }
}

TEST(Fbp, NegativeDensitiesCanBeCutOff) {
    const Case c = smallCase(BeamShape::parallel);
    FbpOptions options;
    const FloatGrid::Ptr all = filteredBackprojection(c.projections, c.geometry, c.grid, options);
    options.nonNegative = true;
    const FloatGrid::Ptr cut = filteredBackprojection(c.projections, c.geometry, c.grid, options);
    int negative = 0;
    for (auto it = all->cbeginValueOn(); it; ++it) {
        negative += *it < 0;
        ASSERT_EQ(cut->tree().getValue(it.getCoord()), std::max(*it, 0.0f));
        ASSERT_EQ(cut->tree().isValueOn(it.getCoord()), *it > 0);
    }
    EXPECT_GT(negative, 1220);  // found: 1348
}

TEST(Fbp, WhatItCannotWorkWithIsRefusedByName) {
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        Case c = smallCase(beam);
        EXPECT_EQ(messageOf(c), "");
        c.projections.view(3)[2 * 40 + 7] = std::numeric_limits<float>::quiet_NaN();
        EXPECT_NE(messageOf(c).find("view 3, row 2, column 7"), std::string::npos) << messageOf(c);
        c = smallCase(beam);
        c.projections.width = 39;
        EXPECT_NE(messageOf(c).find("39"), std::string::npos) << messageOf(c);
        c = smallCase(beam);
        c.grid.spacing = Vec3(0);
        EXPECT_NE(messageOf(c).find("spacing"), std::string::npos) << messageOf(c);
        c = smallCase(beam);
        FbpOptions options;
        options.cutoff = 0;
        EXPECT_THROW(filteredBackprojection(c.projections, c.geometry, c.grid, options), InvalidArgument);
    }
    Case c = smallCase(BeamShape::cone);
    c.grid.spacing = Vec3(10);
    EXPECT_NE(messageOf(c).find("source"), std::string::npos) << messageOf(c);
}

TEST(Fbp, ProgressRisesAndCanStopIt) {
    const Case c = smallCase(BeamShape::cone);
    int calls = 0;
    double last = 0;
    std::string stage;
    filteredBackprojection(c.projections, c.geometry, c.grid, {}, [&](const std::string& name, double fraction) {
        if (name != stage) last = 0;
        stage = name;
        EXPECT_GE(fraction, last);
        EXPECT_LE(fraction, 1);
        last = fraction;
        ++calls;
        return true;
    });
    EXPECT_EQ(calls, 30 + 3);
    const auto stopped = filteredBackprojection(
        c.projections, c.geometry, c.grid, {},
        [&](const std::string& name, double fraction) { return name == "filtering" || fraction < 0.3; });
    EXPECT_EQ(stopped->activeVoxelCount(), 8u * 18 * 11) << "the first of three layers";
}

TEST(Fbp, AScanThatIsTooShortIsTold) {
    CircularOrbit orbit;
    orbit.views = 90;
    EXPECT_EQ(scanWarning(circularGeometry(orbit)), "");
    orbit.arc = 120;
    EXPECT_NE(scanWarning(circularGeometry(orbit)).find("120.0 degrees"), std::string::npos);
    orbit.beam = BeamShape::cone;
    orbit.sourceToAxis = 300;
    orbit.sourceToDetector = 600;
    orbit.arc = 360;
    EXPECT_EQ(scanWarning(circularGeometry(orbit)), "");
    orbit.arc = 180 + 2 * 12.1;  // the fan's half angle is atan(127.5/600), 12.0 degrees
    EXPECT_EQ(scanWarning(circularGeometry(orbit)), "");
    orbit.arc = 190;
    EXPECT_NE(scanWarning(circularGeometry(orbit)).find("204.0"), std::string::npos)
        << scanWarning(circularGeometry(orbit));
}

namespace {

/// A ball of radius 12 about the axis, and a displaced detector that reaches `near` pixels beyond it.
Case displacedCase(BeamShape beam, double near, double arc = 360) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.sourceToAxis = 60;
    orbit.sourceToDetector = 60;
    orbit.views = int(arc / 4);
    orbit.arc = arc;
    orbit.width = 30;
    orbit.height = 20;
    orbit.axisColumn = near - 0.5;
    Case c;
    c.geometry = circularGeometry(orbit);
    c.projections = exactProjections({ellipsoid(1, Vec3(0), Vec3(12))}, c.geometry);
    c.grid.dims = Index3(24, 24, 3);
    c.grid.spacing = Vec3(1);
    return c;
}

}  // namespace

TEST(Fbp, DisplacedDetectorsThatMissTooMuchAreRefused) {
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        EXPECT_EQ(messageOf(displacedCase(beam, 8)), "");
        for (const double near : {-3.0, -6.0})
            EXPECT_NE(messageOf(displacedCase(beam, near)).find("does not see the axis"), std::string::npos) << near;
        EXPECT_NE(messageOf(displacedCase(beam, 2)).find("4 pixels beyond the axis"), std::string::npos);
        const std::string half = messageOf(displacedCase(beam, 8, 220));
        EXPECT_NE(half.find("measured from some sides only"), std::string::npos) << half;
        EXPECT_NE(half.find("iterative methods"), std::string::npos) << half;
    }
}

TEST(Fbp, MissingLinesThatShowNothingDoNotMatter) {
    Case c = displacedCase(BeamShape::cone, 8, 220);
    EXPECT_NE(scanWarning(c.geometry, &c.projections), "");
    c.projections = exactProjections({ellipsoid(1, Vec3(0), Vec3(6))}, c.geometry);
    EXPECT_EQ(scanWarning(c.geometry, &c.projections), "");
    EXPECT_EQ(messageOf(c), "");
}

TEST(Fbp, RaysAlongTheAxisAreRefused) {
    Case c = smallCase(BeamShape::cone);
    c.geometry.views[2].origin += Vec3(0, 0, 600);
    EXPECT_NE(messageOf(c).find("view 2: rays of its detector"), std::string::npos) << messageOf(c);
}
