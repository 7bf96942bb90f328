// Objects wider than the detector, from exact line integrals: inside the field densities are right, whatever the
// method; outside there is nothing.
#include "raysweep/reconstruct/truncation.h"
#include "raysweep/phantoms/exact_projections.h"
#include "raysweep/reconstruct/reconstruct.h"
#include "support/memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace raysweep;

namespace {

using Shapes = std::vector<SolidShape>;

/// A body of 0.02, with a dense ball in it, that a detector of 40 by 40 does not see all of.
Shapes ball() {
    return {ellipsoid(0.02, Vec3(0), Vec3(30), 0), ellipsoid(0.03, Vec3(14, 5, 4), Vec3(5), 0)};
}
Shapes egg() {
    return {ellipsoid(0.02, Vec3(4, 5, 0), Vec3(36, 26, 30), 25), ellipsoid(-0.01, Vec3(8, 5, 0), Vec3(5), 0),
            ellipsoid(0.02, Vec3(-28, -8, 3), Vec3(4, 3, 5), 0)};
}

Scan scanOf(const Shapes& shapes, const CircularOrbit& orbit, double noise = 0) {
    Scan scan;
    scan.geometry = circularGeometry(orbit);
    scan.projections = exactProjections(shapes, scan.geometry);
    std::mt19937 random(7);
    std::normal_distribution<double> normal(0, noise);
    for (float& value : scan.projections.values) value += float(normal(random));
    return scan;
}

CircularOrbit parallelBeam() {
    CircularOrbit orbit;
    orbit.views = 90;
    orbit.width = orbit.height = 40;
    return orbit;
}

CircularOrbit coneBeam() {
    CircularOrbit orbit = parallelBeam();
    orbit.beam = BeamShape::cone;
    orbit.sourceToAxis = 200;
    orbit.sourceToDetector = 300;
    orbit.pixelWidth = orbit.pixelHeight = 1.5;
    orbit.views = 180;
    orbit.arc = 360;
    return orbit;
}

/// Differences to what a detector that sees all of the object makes by the same method, relative to the body's 0.02: of
/// the means of 3x3x3 voxels up to 2 from the field's rim.
struct Errors {
    double worst = 0, mean = 0;
    double inner = 0;  ///< worst up to 0.8 of the field's radius
};

Errors differenceOf(const Reconstruction& cut, const Reconstruction& whole) {
    const auto is = cut.volume->getConstAccessor(), shouldBe = whole.volume->getConstAccessor();
    Errors errors;
    double sum = 0;
    int count = 0;
    for (int i = 1; i + 1 < cut.grid.dims.x; ++i)
        for (int j = 1; j + 1 < cut.grid.dims.y; ++j)
            for (int k = cut.grid.dims.z / 4; k < 3 * cut.grid.dims.z / 4; ++k) {
                const Vec3 p = cut.grid.voxel(i, j, k);
                if (std::hypot(p.x, p.y) > cut.fieldRadius - 2) continue;
                double difference = 0;
                for (int n = 0; n < 27; ++n) {
                    const openvdb::Coord voxel(i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1);
                    difference += (double(is.getValue(voxel)) - shouldBe.getValue(voxel)) / 27 / 0.02;
                }
                errors.worst = std::max(errors.worst, std::abs(difference));
                if (std::hypot(p.x, p.y) < 0.8 * cut.fieldRadius)
                    errors.inner = std::max(errors.inner, std::abs(difference));
                sum += difference;
                ++count;
            }
    EXPECT_GT(count, 10000);
    errors.mean = sum / count;
    return errors;
}

Reconstruction reconstructed(const Scan& scan, ReconstructionMethod method) {
    ReconstructOptions options;
    options.method = method;
    const Reconstruction result = reconstruct(scan, options);
    EXPECT_TRUE(std::any_of(result.warnings.begin(), result.warnings.end(), [](const ReconstructionWarning& warning) {
        return warning.kind == ReconstructionWarning::Kind::truncation;
    }));
    // Outside the field there is nothing, and metadata say where that is.
    for (auto value = result.volume->cbeginValueOn(); value; ++value) {
        const openvdb::Vec3d p = result.volume->indexToWorld(value.getCoord());
        EXPECT_LE(std::hypot(p.x(), p.y()), result.fieldRadius + 1e-6);
        EXPECT_TRUE(std::isfinite(*value));
    }
    EXPECT_NEAR(result.volume->metaValue<double>("field_radius"), result.fieldRadius, 1e-12);
    return result;
}

}  // namespace

// The limit asked for is 3 % of the body; found, up to 0.8 of the field's radius: 2.97 % filtered, 2.88 % by SART, with
// noise 3.2 %. A row that is cut and taken for 0 beyond is 40 to 60 % off.
TEST(Truncation, DensitiesInsideTheFieldAreThoseOfAWideDetector) {
    struct Case {
        const char* name;
        Shapes shapes;
        CircularOrbit orbit;
        double noise, filtered, sart;  ///< limits of `inner`
    };
    for (const Case& c : {Case{"ball, parallel", ball(), parallelBeam(), 0, 0.03, 0.03},
                          {"egg, parallel", egg(), parallelBeam(), 0, 0.03, 0.03},
                          {"egg, parallel, noise", egg(), parallelBeam(), 0.01, 0.03, 0.035},
                          {"ball, cone", ball(), coneBeam(), 0, 0.03, 0.03},
                          {"egg, cone", egg(), coneBeam(), 0, 0.03, 0.03}}) {
        const Scan scan = scanOf(c.shapes, c.orbit, c.noise);
        CircularOrbit wide = c.orbit;
        wide.width = 100;
        const Scan whole = scanOf(c.shapes, wide);
        for (const bool direct : {true, false}) {
            const auto method = direct ? ReconstructionMethod::fbp : ReconstructionMethod::sart;
            const Reconstruction cut = reconstructed(scan, method);
            EXPECT_NEAR(cut.fieldRadius, c.orbit.beam == BeamShape::cone ? 19.9 : 20, 0.05) << c.name;
            EXPECT_GT(cut.rowsCut, 0.8) << c.name;
            ReconstructOptions options;
            options.method = method;
            options.grid.dims = direct ? cut.grid.dims : Index3(80, 80, cut.grid.dims.z);
            options.grid.spacing = cut.grid.spacing;
            Reconstruction all = reconstruct(whole, options);
            if (!direct) {  // the same voxels: 20 on
                const openvdb::Coord shift((80 - cut.grid.dims.x) / 2, (80 - cut.grid.dims.y) / 2, 0);
                const auto moved = openvdb::FloatGrid::create(0.0f);
                for (auto value = all.volume->cbeginValueOn(); value; ++value)
                    moved->tree().setValue(value.getCoord() - shift, *value);
                all.volume = moved;
            }
            const Errors errors = differenceOf(cut, all);
            std::printf("%s, %s: worst %.4f, inner %.4f, mean %.4f\n", c.name, direct ? "filtered" : "sart",
                        errors.worst, errors.inner, errors.mean);
            EXPECT_LT(errors.inner, direct ? c.filtered : c.sart) << c.name << (direct ? ", filtered" : ", sart");
            EXPECT_LT(errors.worst, 0.096) << c.name;  // found: 0.0874, where the dense ball touches the field's rim
            EXPECT_LT(std::abs(errors.mean), 0.004) << c.name;  // found: 0.0036
        }
    }
}

TEST(Truncation, AnObjectThatIsSeenWholeIsLeftAlone) {
    const Shapes small{ellipsoid(0.02, Vec3(3, 0, 0), Vec3(14, 12, 30), 0)};
    for (const CircularOrbit& orbit : {parallelBeam(), coneBeam()}) {
        for (const double noise : {0.0, 0.03}) {
            const Scan scan = scanOf(small, orbit, noise);
            EXPECT_FALSE(findTruncation(scan.projections, scan.geometry)) << noise;
        }
    }
    Scan hot = scanOf(small, parallelBeam());  // a column of hot pixels at the detector's end is no object
    for (int n = 0; n < hot.projections.views; ++n)
        for (int y = 0; y < 40; ++y) hot.projections.view(n)[y * 40] = 2;
    EXPECT_FALSE(findTruncation(hot.projections, hot.geometry));
}

// In a full turn a displaced detector's short side is cut by design: its other side sees what it misses.
TEST(Truncation, ADisplacedDetectorIsCutOnItsShortSideByDesign) {
    CircularOrbit orbit = coneBeam();
    orbit.width = 60;
    orbit.axisColumn = 10;
    const Shapes body{ellipsoid(0.02, Vec3(0), Vec3(30, 28, 30), 0)};
    const Scan seen = scanOf(body, orbit);
    EXPECT_FALSE(findTruncation(seen.projections, seen.geometry));
    orbit.width = 40;
    const Scan cut = scanOf(body, orbit);
    const auto truncation = findTruncation(cut.projections, cut.geometry);
    ASSERT_TRUE(truncation);
    for (const OuterEnds& ends : truncation->ends) EXPECT_TRUE(!ends.low && ends.high);
    EXPECT_NEAR(truncation->radius, 29.5 * 1.5 / std::hypot(1.5, 29.5 * 1.5 / 200), 1.0);
    orbit.arc = 200;  // not in less than a full turn
    const auto half = findTruncation(exactProjections(body, circularGeometry(orbit)), circularGeometry(orbit));
    ASSERT_TRUE(half);
    // But for the views that have one on the other side, 20 degrees at both ends of the arc, less the fan's angle.
    const auto low = std::count_if(half->ends.begin(), half->ends.end(), [](const OuterEnds& e) { return e.low; });
    EXPECT_GT(low, 0.75 * 180);
    EXPECT_NEAR(half->radius, 10.5, 0.3) << "what is seen on the short side";
}

namespace {

/// Views of detectors of `width` columns in a turn, one behind the other: each is displaced by `columns(n)`.
template <class Columns>
Scan displacedScan(const Shapes& shapes, CircularOrbit orbit, int width, int together, const Columns& columns) {
    std::vector<double> angles;
    for (int n = 0; n < orbit.views * together; ++n) angles.push_back(orbit.arc * (n / together) / orbit.views);
    orbit.angles = angles;
    orbit.width = width;
    Scan scan;
    scan.geometry = circularGeometry(orbit);
    for (std::size_t n = 0; n < scan.geometry.views.size(); ++n)
        scan.geometry.views[n].origin += scan.geometry.views[n].column * double(columns(int(n)));
    scan.projections = exactProjections(shapes, scan.geometry);
    return scan;
}

/// A turn displaced to each side, and three tiles side by side from each angle; both reach 32 pixels from the axis.
std::vector<Scan> unionsOf(const Shapes& shapes, const CircularOrbit& orbit) {
    return {displacedScan(shapes, orbit, 42, 2, [](int n) { return n % 2 ? 11 : -11; }),
            displacedScan(shapes, orbit, 26, 3, [](int n) { return 19 * (n % 3 - 1); })};
}

CircularOrbit fullTurn(BeamShape beam) {
    CircularOrbit orbit = beam == BeamShape::cone ? coneBeam() : parallelBeam();
    orbit.views = 120;
    orbit.arc = 360;
    return orbit;
}

bool warns(const Reconstruction& result, ReconstructionWarning::Kind kind) {
    return std::any_of(result.warnings.begin(), result.warnings.end(),
                       [&](const ReconstructionWarning& warning) { return warning.kind == kind; });
}

}  // namespace

/// Mean of the voxels next to the sources' plane that are `from` to `to` from the axis, relative to 0.02.
double ringMean(const Reconstruction& result, double from, double to) {
    double sum = 0;
    int count = 0;
    const int middle = result.grid.dims.z / 2;
    for (int i = 0; i < result.grid.dims.x; ++i)
        for (int j = 0; j < result.grid.dims.y; ++j)
            for (const int k : {middle - 1, middle}) {
                const Vec3 p = result.grid.voxel(i, j, k);
                const double away = std::hypot(p.x, p.y);
                if (away < from || away > to) continue;
                sum += result.volume->tree().getValue({i, j, k}) / 0.02;
                ++count;
            }
    return sum / count;
}

ReconstructOptions by(ReconstructionMethod method) {
    ReconstructOptions options;
    options.method = method;
    options.grid.dims = Index3(64, 64, 40);
    options.grid.spacing = Vec3(1);
    options.sart.iterations = 2;
    return options;
}

// What one detector does not see, another does: together they see all of the body.
TEST(Truncation, WhatDetectorsSeeTogetherIsNotCut) {
    const Shapes body{ellipsoid(0.02, Vec3(0), Vec3(28, 28, 15), 0)};
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone})
        for (const Scan& scan : unionsOf(body, fullTurn(beam)))
            for (const auto method : {ReconstructionMethod::fbp, ReconstructionMethod::sart}) {
                const Reconstruction result = reconstruct(scan, by(method));
                EXPECT_FALSE(warns(result, ReconstructionWarning::Kind::truncation));
                EXPECT_EQ(result.fieldRadius, 0);
                std::printf("union, method %d: mean %.5f\n", int(method), ringMean(result, 0, 26));
                EXPECT_NEAR(ringMean(result, 0, 26), 1, 0.0023);  // found: 0.0021
            }
}

// A body that all of them together do not see is continued at their outer ends only, as that of one wide detector is.
TEST(Truncation, DetectorsSideBySideAreContinuedAsOneIs) {
    const Shapes body{ellipsoid(0.02, Vec3(3, 2, 0), Vec3(44, 38, 40), 25),
                      ellipsoid(0.02, Vec3(14, 5, 0), Vec3(6), 0)};
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        CircularOrbit wide = fullTurn(beam);
        wide.width = 64;
        Scan one = scanOf(body, wide);
        for (const auto method : {ReconstructionMethod::fbp, ReconstructionMethod::sart}) {
            const Reconstruction single = reconstructed(one, method);
            for (const Scan& scan : unionsOf(body, fullTurn(beam))) {
                const Reconstruction several = reconstructed(scan, method);
                EXPECT_NEAR(several.fieldRadius, single.fieldRadius, 0.1);
                ASSERT_LE((several.grid.spacing - single.grid.spacing).length(), 1e-9);
                ASSERT_EQ(several.grid.dims, single.grid.dims);
                const Errors errors = differenceOf(several, single);
                std::printf("side by side, method %d: worst %.4f, inner %.4f, mean %.4f\n", int(method), errors.worst,
                            errors.inner, errors.mean);
                // Found: 0.0012 filtered, 0.0141 by SART after its few passes.
                EXPECT_LT(errors.inner, method == ReconstructionMethod::fbp ? 0.0013 : 0.0155);
                EXPECT_LT(std::abs(errors.mean), 0.00025);  // found: 0.0002
            }
        }
    }
}

// Rays on one side of the axis only: nothing about the axis is known, and what was measured is all there is.
TEST(Truncation, ADetectorBesideTheAxisHasNoField) {
    const Shapes body{ellipsoid(0.02, Vec3(0), Vec3(30, 30, 15), 0)};
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone})
        for (const double arc : {180.0, 200.0, 360.0}) {
            CircularOrbit orbit = fullTurn(beam);
            orbit.arc = arc;
            const Scan scan = displacedScan(body, orbit, 40, 1, [](int) { return 25; });
            EXPECT_FALSE(findTruncation(scan.projections, scan.geometry)) << arc;
            try {
                reconstruct(scan, by(ReconstructionMethod::fbp));
                ADD_FAILURE() << "not refused: " << arc;
            } catch (const InvalidArgument& error) {
                EXPECT_NE(std::string(error.what()).find("does not see the axis"), std::string::npos) << error.what();
            }
            const Reconstruction result = reconstruct(scan, by(ReconstructionMethod::sart));
            EXPECT_EQ(result.fieldRadius, 0);
            std::printf("beside the axis, %.0f degrees: mean %.5f\n", arc, ringMean(result, 10, 28));
            EXPECT_GT(ringMean(result, 10, 28), 0.5) << "what was measured is there";
        }
}

// An axis that falls hardly within the detector leaves a field that is as small, and a detector of bounded width.
TEST(Truncation, ASmallFieldDoesNotMakeTheDetectorEndless) {
    const Shapes body{ellipsoid(0.02, Vec3(0), Vec3(300, 300, 40), 0)};
    for (const double beyond : {0.01, 0.3, 1.0, 3.0}) {
        CircularOrbit orbit = parallelBeam();
        orbit.axisColumn = beyond - 0.5;
        const Scan scan = scanOf(body, orbit);
        const auto truncation = findTruncation(scan.projections, scan.geometry);
        EXPECT_EQ(bool(truncation), beyond > 1) << beyond;
        if (!truncation) continue;
        EXPECT_NEAR(truncation->radius, beyond, 0.05);
        EXPECT_LE(wideDetector(*truncation, scan.geometry).geometry.width, 5 * 40);
    }
}

// --initial and a filtered start: what is known within the field stays, tiles of the grid and air included; volumes
// whose voxels lie elsewhere are refused as they are where nothing is cut.
TEST(Truncation, AnInitialVolumeIsTakenAsItIs) {
    const Scan scan = scanOf(ball(), parallelBeam());
    const auto truncation = findTruncation(scan.projections, scan.geometry);
    ASSERT_TRUE(truncation);
    const ReconstructionGrid grid{Index3(40, 40, 40), Vec3(0), Vec3(1)};
    const auto known = openvdb::FloatGrid::create(0.0f);
    known->setTransform(grid.transform());
    known->fill(openvdb::CoordBBox(openvdb::Coord(8), openvdb::Coord(23)), 0.5f);  // tiles
    EXPECT_GT(known->tree().activeTileCount(), 0u);
    const ReconstructionGrid wide = widened(*truncation, grid);
    const auto volume = continuedObject(*truncation, scan.geometry, wide, {known.get(), grid});
    const auto at = [&](const Vec3& p) {
        const openvdb::Vec3d index = volume->worldToIndex(openvdb::Vec3d(p.x, p.y, p.z));
        return volume->tree().getValue(openvdb::Coord::round(index));
    };
    EXPECT_EQ(at(grid.voxel(10, 12, 20)), 0.5f) << "a tile";
    EXPECT_EQ(at(grid.voxel(30, 20, 20)), 0.0f) << "air";
    EXPECT_NEAR(at(Vec3(0.5, 24.5, 0.5)), 0.02, 0.005) << "beyond the field";
    EXPECT_NEAR(at(Vec3(17.5, 17.5, 0.5)), 0.02, 0.005) << "beyond the field, within the grid";

    ReconstructOptions options;
    const auto coarse = openvdb::FloatGrid::create(0.0f);
    coarse->setTransform(openvdb::math::Transform::createLinearTransform(2));
    coarse->fill(openvdb::CoordBBox(openvdb::Coord(-10), openvdb::Coord(9)), 0.02f);
    options.volumes.initial = coarse;
    options.grid.dims = Index3(40);
    options.grid.spacing = Vec3(1);
    try {
        reconstruct(scan, options);
        ADD_FAILURE() << "not refused";
    } catch (const InvalidArgument& error) {
        EXPECT_NE(std::string(error.what()).find("voxels of the initial volume are not where"), std::string::npos)
            << error.what();
    }
}

// One view at a time is as wide as the object: beside the scan there are filtered views, and little else.
TEST(Truncation, FilteringTakesTheMemoryOfFilteredViews) {
    CircularOrbit orbit = parallelBeam();
    orbit.views = 200;
    orbit.width = orbit.height = 160;
    const Shapes body{ellipsoid(0.02, Vec3(0), Vec3(120, 120, 160), 0)};
    const Scan scan = scanOf(body, orbit);
    const auto truncation = findTruncation(scan.projections, scan.geometry);
    ASSERT_TRUE(truncation);
    const double width = wideDetector(*truncation, scan.geometry).geometry.width;
    ReconstructOptions options;
    options.method = ReconstructionMethod::fbp;
    options.grid.dims = Index3(32);
    options.grid.spacing = Vec3(1);
    reconstruct(scan, options);  // what is made once is there
    const std::optional<std::size_t> took = test::bytesTaken([&] { reconstruct(scan, options); });
    if (!took) GTEST_SKIP() << "what memory this takes cannot be told";
    const double views = 200 * width * 160 * sizeof(float);
    std::printf("took %.1f MB, filtered views %.1f MB\n", double(*took) / 1e6, views / 1e6);
    EXPECT_LT(double(*took), 1.1 * views);
}

// A detector that lies on its side sees the same body.
TEST(Truncation, ColumnsOfADetectorOnItsSideAreItsRows) {
    Scan scan = scanOf(egg(), parallelBeam());
    const auto upright = findTruncation(scan.projections, scan.geometry);
    Projections turned(40, 40, scan.projections.views);
    for (int n = 0; n < turned.views; ++n)
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x) turned.view(n)[x * 40 + y] = scan.projections.view(n)[y * 40 + x];
    for (XrayView& view : scan.geometry.views) std::swap(view.column, view.row);
    const auto sideways = findTruncation(turned, scan.geometry);
    ASSERT_TRUE(upright && sideways);
    EXPECT_TRUE(sideways->sideways);
    EXPECT_EQ(sideways->share, upright->share);
    EXPECT_NEAR(sideways->reach, upright->reach, 1e-6);
}
