#include "raysweep/projector/project.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/core/parallel.h"
#include "raysweep/phantoms/ct_phantoms.h"
#include "raysweep/phantoms/solid_shapes.h"
#include "raysweep/projector/backproject.h"
#include "raysweep/projector/project_grid.h"
#include "support/detectors.h"
#include "support/worst.h"
#include "unit/instruction_sets.h"

using namespace raysweep;
using test::rolled;

namespace {

/// A lattice of that many voxels of these edges around the world's origin, columns along axis 2.
ColumnLattice centredLattice(const Index3& dims, const Vec3& spacing = Vec3(1)) {
    const auto transform = openvdb::math::Transform::createLinearTransform();
    const openvdb::Vec3d edges(spacing.x, spacing.y, spacing.z);
    transform->postScale(edges);
    transform->postTranslate(-0.5 * edges * openvdb::Vec3d(dims.x - 1, dims.y - 1, dims.z - 1));
    return columnLattice({openvdb::Coord(0), openvdb::Coord(dims.x - 1, dims.y - 1, dims.z - 1)}, *transform, 2);
}

/// Random numbers in [0,1) in all voxels of the lattice that are kept.
void randomize(ColumnVolume& volume, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    const Index3 dims = volume.lattice().dims;
    for (int x = 0; x < dims.x; ++x)
        for (int y = 0; y < dims.y; ++y) {
            const std::size_t block = volume.blockOf(x, y);
            const ColumnRange range = volume.ranges()[block];
            for (int z = range.low; z < std::min(range.high, dims.z); ++z)
                volume.column(block, x, y)[z - range.low] = uniform(random);
        }
}

/// Every other block empty, the others with columns of different ends.
ColumnVolume sparseVolume(const ColumnLattice& lattice) {
    std::vector<ColumnRange> kept(ColumnVolume(lattice).blockCount());
    for (std::size_t t = 0; t < kept.size(); ++t)
        if (t % 3 != 0) kept[t] = {t % 2 ? 16 : 0, t % 5 ? 48 : 32};
    return ColumnVolume(lattice, kept);
}

struct Scan {
    std::string name;
    ProjectionGeometry geometry;
};

/// `geometry` turned such that its axis is the world's axis `axis` instead of z.
ProjectionGeometry turned(ProjectionGeometry geometry, int axis) {
    const auto turn = [&](Vec3& v) {
        if (axis == 0) v = Vec3(v.z, v.x, v.y);
        if (axis == 1) v = Vec3(v.y, v.z, v.x);
    };
    for (XrayView& view : geometry.views)
        for (Vec3* v : {&view.source, &view.direction, &view.origin, &view.column, &view.row}) turn(*v);
    return geometry;
}

CircularOrbit smallOrbit(BeamShape beam) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.views = 7;
    orbit.firstAngle = 3;
    orbit.arc = 360;
    orbit.width = 70;
    orbit.height = 50;
    orbit.sourceToAxis = 80;
    orbit.sourceToDetector = 95;
    return orbit;
}

/// Parallel and cone, level and tilted, coarse and fine detectors, rays along every axis.
std::vector<Scan> scans() {
    std::vector<Scan> all;
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        const std::string name = beam == BeamShape::cone ? "cone" : "parallel";
        const CircularOrbit orbit = smallOrbit(beam);
        for (int axis = 0; axis < 3; ++axis)
            all.push_back({name + " about " + "xyz"[axis], turned(circularGeometry(orbit), axis)});
        CircularOrbit fine = orbit;
        fine.pixelHeight = 0.3;
        all.push_back({name + " with fine rows", circularGeometry(fine)});
        CircularOrbit coarse = orbit;
        coarse.pixelHeight = 2.7;
        coarse.axisColumn = 30.3;
        all.push_back({name + " with coarse rows and an offset", circularGeometry(coarse)});
        ProjectionGeometry tilted = circularGeometry(orbit);
        for (XrayView& view : tilted.views) view.row += view.column * 0.2;
        all.push_back({name + " with a turned detector", tilted});
        for (const double roll : {-0.6, 3.0, 37.0, 70.0, 90.0, 177.0, -93.0})
            all.push_back({name + " rolled by " + std::to_string(roll), rolled(circularGeometry(orbit), roll)});
        all.push_back({name + " with fine rows, rolled", rolled(circularGeometry(fine), 2)});
        all.push_back({name + " with coarse rows, rolled", rolled(circularGeometry(coarse), 2)});
        ProjectionGeometry inclined = circularGeometry(orbit);
        for (XrayView& view : inclined.views) view.row += view.column.cross(view.row) * 0.1;
        all.push_back({name + " with an inclined detector", inclined});
        // Some rows behind the last one's z would pass through infinity.
        CircularOrbit few = orbit;
        few.height = 3;
        few.pixelHeight = 15;
        for (const double lean : {-0.577, 0.577}) {
            inclined = circularGeometry(few);
            for (XrayView& view : inclined.views) view.row += view.column.cross(view.row).normalized() * (lean * 15);
            all.push_back({name + " with few rows that lean by " + std::to_string(lean), inclined});
        }
    }
    ProjectionGeometry rising = circularGeometry(smallOrbit(BeamShape::parallel));
    for (XrayView& view : rising.views) view.direction = (view.direction + Vec3(0, 0, 0.4)).normalized();
    all.push_back({"parallel that rises", rising});
    return all;
}

double dot(const RayImage& a, const RayImage& b, int columns, int rows) {
    double sum = 0;
    for (int u = 0; u < columns; ++u)
        for (int v = 0; v < rows; ++v) sum += double(a.column(u)[v]) * b.column(u)[v];
    return sum;
}

double dot(const ColumnVolume& a, const ColumnVolume& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.storedVoxels(); ++i) sum += double(a.block(0)[i]) * b.block(0)[i];
    return sum;
}

void randomize(RayImage& image, int columns, int rows, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (int u = 0; u < columns; ++u)
        for (int v = 0; v < rows; ++v) image.column(u)[v] = uniform(random);
}

/// Largest difference of two images, relative to the largest value of the first.
double largestDifference(const RayImage& a, const RayImage& b, int columns, int rows) {
    double most = 0, largest = 0;
    for (int u = 0; u < columns; ++u)
        for (int v = 0; v < rows; ++v) {
            test::raiseTo(most, double(std::abs(a.column(u)[v] - b.column(u)[v])));
            test::raiseTo(largest, double(std::abs(a.column(u)[v])));
        }
    return most / largest;
}

}  // namespace

namespace {

void expectAdjoint(const std::vector<Scan>& scans, const Vec3& spacing = Vec3(1)) {
    const ColumnLattice lattice = centredLattice(Index3(40, 45, 37), spacing);
    for (const bool sparse : {false, true})
        for (const Scan& scan : scans) {
            ColumnVolume x = sparse ? sparseVolume(lattice) : ColumnVolume(lattice);
            ColumnVolume back(lattice, x.ranges());
            randomize(x, 1);
            for (int view = 0; view < int(scan.geometry.views.size()); ++view) {
                ViewRays forward, backward;
                setView(forward, scan.geometry, view, lattice);
                const int width = forward.view.width, height = forward.view.height;
                projectView(x, forward);
                setView(backward, scan.geometry, view, lattice);
                randomize(backward.values, width, height, unsigned(view));
                const double projected = dot(forward.values, backward.values, width, height);
                backprojectView(backward, back);
                ASSERT_GT(projected, 0) << scan.name;
                EXPECT_NEAR(dot(x, back) / projected, 1, height < 10 ? 6.6e-7 : 2.3e-7)
                    << scan.name << ", view " << view;
            }
        }
}

}  // namespace

// Floats are summed in different orders on both sides; what is found is 1e-11 to 2.1e-7, and up to 6.1e-7 where three
// rows are all that rounding is averaged over.
TEST(Projector, BackprojectionIsItsAdjointOnEveryAxis) {
    expectAdjoint(scans());
}

TEST(Projector, ItIsSoInVoxelsThatAreNoCubes) {
    for (const Vec3& spacing : {Vec3(1, 1, 2.5), Vec3(2, 1, 1), Vec3(1, 0.8, 0.4)}) expectAdjoint(scans(), spacing);
}

namespace {

/// The same rays from detectors on their side: rows and columns are exchanged.
ProjectionGeometry onSide(ProjectionGeometry geometry) {
    std::swap(geometry.width, geometry.height);
    for (XrayView& view : geometry.views) std::swap(view.column, view.row);
    return geometry;
}

}  // namespace

// The same bits: they are taken as detectors that stand, whose columns are their rows.
TEST(Projector, DetectorsOnTheirSideAreTakenByWholeColumns) {
    PhantomOptions options;
    options.dims = openvdb::Coord(40, 44, 36);
    options.voxelSize = 1;
    const openvdb::FloatGrid::Ptr box = makeBoxWithHoles(options);
    for (const Scan& scan : scans()) {
        const Projections upright = projectGrid(*box, scan.geometry), turned = projectGrid(*box, onSide(scan.geometry));
        for (int n = 0; n < upright.views; ++n)
            for (int y = 0; y < upright.height; ++y)
                for (int x = 0; x < upright.width; ++x)
                    ASSERT_EQ(upright.view(n)[y * upright.width + x], turned.view(n)[x * upright.height + y])
                        << scan.name;
    }
    const ColumnLattice lattice = centredLattice(Index3(40, 45, 37));
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone})
        for (const double roll : {87.0, 90.0, -93.0, 100.0})
            for (int view = 0; view < 7; ++view) {
                const JosephView taken = josephView(rolled(circularGeometry(smallOrbit(beam)), roll), view, lattice);
                EXPECT_TRUE(taken.onSide) << roll;
                EXPECT_NE(taken.kind, JosephView::Kind::oblique) << roll;
            }
}

// Slightly rolled detectors, such as every calibrated C-arm has, are not left to rays one by one.
TEST(Projector, RolledAndInclinedDetectorsAreTakenByWholeColumns) {
    const ColumnLattice lattice = centredLattice(Index3(40, 45, 37));
    std::vector<Scan> leaning;
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone})
        for (const double roll : {-37.0, -3.0, 0.6, 2.0, 10.0, 37.0})
            leaning.push_back({std::to_string(roll), rolled(circularGeometry(smallOrbit(beam)), roll)});
    for (const Scan& scan : leaning)
        for (int view = 0; view < int(scan.geometry.views.size()); ++view)
            EXPECT_EQ(josephView(scan.geometry, view, lattice).kind, JosephView::Kind::rolled) << scan.name;
    test::forEachInstructionSet([&] { expectAdjoint(leaning); });
}

// Vectors of 4, 8 and 16 numbers reach rows of other distances by table look-ups.
TEST(Projector, AllInstructionSetsAreAdjointForRowsOfAnyDistance) {
    std::vector<Scan> pitches;
    for (const double pitch : {0.509, 0.511, 1.0, 1.66, 1.68, 1.857, 1.87, 1.93, 1.95}) {
        CircularOrbit orbit = smallOrbit(BeamShape::parallel);
        orbit.views = 1;
        orbit.pixelHeight = pitch;
        pitches.push_back({"pitch " + std::to_string(pitch), circularGeometry(orbit)});
    }
    test::forEachInstructionSet([&] { expectAdjoint(pitches); });
}

#ifdef __OPTIMIZE__
constexpr double kWeightRounding = 2.35e-7;
#else
constexpr double kWeightRounding = 4.4e-7;
#endif

// The sums of weights are found another way than by projecting ones: by intervals, not by voxels.
TEST(Projector, WeightsAreThoseOfAVolumeOfOnes) {
    const ColumnLattice lattice = centredLattice(Index3(40, 45, 37));
    for (const Scan& scan : scans()) {
        ColumnVolume ones = sparseVolume(lattice);
        for (int x = 0; x < lattice.dims.x; ++x)
            for (int y = 0; y < lattice.dims.y; ++y) {
                const std::size_t block = ones.blockOf(x, y);
                const ColumnRange range = ones.ranges()[block];
                std::fill_n(ones.column(block, x, y), std::max(0, std::min(range.high, lattice.dims.z) - range.low),
                            1.0f);
            }
        ViewRays rays;
        setView(rays, scan.geometry, 1, lattice);
        projectView(ones, rays);
        // Rounding of positions and sums; found: 2.14e-7, and 4.01e-7 where the compiler does not contract to fused
        // multiply-adds (without optimisation).
        EXPECT_LT(largestDifference(rays.values, rays.weights, rays.view.width, rays.view.height), kWeightRounding)
            << scan.name;
    }
}

// Rays one by one are the plain twin of the kernels: they take the weights of joseph.h, voxel by voxel. Floats are
// rounded in other places; found: 1.1e-6 and 9e-7; where rows are placed by a quotient of floats, a few
// hundred-thousandths of a voxel off, 5.0e-6 and 5.2e-6.
TEST(Projector, KernelsAgreeWithRaysOneByOneOnAllInstructionSets) {
    const ColumnLattice lattice = centredLattice(Index3(40, 45, 37), Vec3(0.7));
    ColumnVolume volume = sparseVolume(lattice);
    randomize(volume, 3);
    for (const Scan& scan : scans()) {
        ViewRays single;
        setView(single, scan.geometry, 2, lattice);
        const int width = single.view.width, height = single.view.height;
        if (single.view.kind == JosephView::Kind::oblique) continue;
        single.view.kind = JosephView::Kind::oblique;
        projectView(volume, single);
        test::forEachInstructionSet([&] {
            ViewRays rays;
            setView(rays, scan.geometry, 2, lattice);
            projectView(volume, rays);
            const bool rolled = rays.view.kind == JosephView::Kind::rolled;
            EXPECT_LT(largestDifference(single.values, rays.values, width, height), rolled ? 5.4e-6 : 1.2e-6)
                << scan.name;
            // On its side the detector has 70 rows, not 50, whose places are further from 0; found: 6.7e-6.
            const double rolledLimit = rays.view.onSide ? 7.4e-6 : 5.6e-6;
            EXPECT_LT(largestDifference(single.weights, rays.weights, width, height), rolled ? rolledLimit : 9.9e-7)
                << scan.name;
        });
    }
}

TEST(Projector, NoVoxelThatADivergingBeamCoversIsMissed) {
    // Rays part by up to one voxel at the far side: 1.43 along a slice where they run at 45 degrees. Then the voxel
    // furthest from its rays has weights of at least 1 - 1.43 / 2 in the slice and 1/2 along the columns: 0.14. What is
    // found is 0.65: rays of several rows meet it.
    CircularOrbit orbit = smallOrbit(BeamShape::cone);
    orbit.sourceToAxis = 60;
    orbit.sourceToDetector = 60;
    orbit.pixelWidth = orbit.pixelHeight = 0.8;
    orbit.width = orbit.height = 128;
    const ProjectionGeometry geometry = circularGeometry(orbit);
    const ColumnLattice lattice = centredLattice(Index3(32, 32, 32));
    ColumnVolume back(lattice);
    for (int view = 0; view < orbit.views; ++view) {
        ViewRays rays;
        setView(rays, geometry, view, lattice);
        for (int u = 0; u < orbit.width; ++u) std::fill_n(rays.values.column(u), orbit.height, 1.0f);
        backprojectView(rays, back);
        for (int x = 0; x < 32; ++x)
            for (int y = 0; y < 32; ++y)
                for (int z = 0; z < 32; ++z) ASSERT_GT(back.value(x, y, z), 0.59f) << x << " " << y << " " << z;
    }
}

TEST(Projector, AnyNumberOfThreadsGivesTheSameBits) {
    const ColumnLattice lattice = centredLattice(Index3(40, 45, 37));
    for (const Scan& scan : scans()) {
        ColumnVolume volume = sparseVolume(lattice), one(lattice), many(lattice);
        randomize(volume, 4);
        const auto run = [&](int threads, ColumnVolume& back) {
            const ThreadLimit limit(threads);
            ViewRays rays;
            setView(rays, scan.geometry, 3, lattice);
            projectView(volume, rays);
            backprojectView(rays, back);
        };
        run(1, one);
        run(4, many);
        EXPECT_TRUE(std::equal(one.block(0), one.block(0) + one.storedVoxels(), many.block(0))) << scan.name;
    }
}

namespace {

/// An ellipsoid in [-1,1]³, as the means of voxels of these edges: those of cubes, in a world where they are cubes.
openvdb::FloatGrid::Ptr voxelized(const SolidShape& shape, const Vec3& edges) {
    SolidShape there = shape;
    there.center = shape.center / edges;
    openvdb::Coord dims;
    for (int axis = 0; axis < 3; ++axis) {
        there.halfAxes[axis] = shape.halfAxes[axis] / edges;
        dims[axis] = int(std::lround(2 / edges[axis]));
    }
    const openvdb::FloatGrid::Ptr grid = voxelize({there}, dims, 1);
    grid->transform().postScale(openvdb::Vec3d(edges.x, edges.y, edges.z));
    return grid;
}

/// RMS difference of a voxelised ellipsoid's projections from the exact ones, relative to the largest.
/// @param edges of a voxel; if those along x and y differ, the ellipsoid must not be turned by `degrees`
double ellipsoidError(BeamShape beam, const Vec3& edges, double degrees = 20) {
    const std::vector<SolidShape> shapes{ellipsoid(1, Vec3(0.1, -0.05, 0.07), Vec3(0.7, 0.5, 0.6), degrees)};
    const openvdb::FloatGrid::Ptr grid = voxelized(shapes[0], edges);
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.views = 5;
    orbit.arc = 171;
    orbit.width = orbit.height = 64;
    orbit.pixelWidth = orbit.pixelHeight = 2.0 / 64;
    orbit.sourceToAxis = orbit.sourceToDetector = 4;
    const ProjectionGeometry geometry = circularGeometry(orbit);
    const Projections found = projectGrid(*grid, geometry);
    double squares = 0;
    for (int n = 0; n < orbit.views; ++n)
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                const XrayView& view = geometry.views[std::size_t(n)];
                const Vec3 pixel = view.pixel(x, y);
                const Vec3 direction = beam == BeamShape::cone ? (pixel - view.source).normalized() : view.direction;
                const double exact = lineIntegral(shapes, pixel, direction);
                const double error = found.view(n)[y * 64 + x] - exact;
                squares += error * error;
            }
    return std::sqrt(squares / (orbit.views * 64 * 64));
}

}  // namespace

// A density that jumps is smeared over a voxel: near the rim, where the chord rises as a square root, a share h of the
// rays is off by about sqrt(h), so the RMS falls as h or a little better; in between as h^2.
TEST(Projector, ErrorAgainstAnEllipsoidsChordsFallsWithTheVoxels) {
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        const double coarse = ellipsoidError(beam, Vec3(1.0 / 16)), fine = ellipsoidError(beam, Vec3(1.0 / 64));
        const bool cone = beam == BeamShape::cone;
        EXPECT_LT(fine, cone ? 0.00571 : 0.00617);       // of chords up to 1.4; found 0.0052 and 0.0056
        EXPECT_LT(fine / coarse, cone ? 0.282 : 0.305);  // 1/4, and the noise of the few rays at the rim
    }
}

// An error goes by a voxel's width along what normals of the surface there are: it is between those of cubes. Found:
// 0.0158, 0.0099, 0.0058; cone 0.0155, 0.0100, 0.0059.
TEST(Projector, VoxelsThatAreNoCubesAreBetweenCubesOfTheirShortestAndLongestEdge) {
    struct Case {
        Vec3 shape;
        double most;
    };
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone})
        for (const Case& c : {Case{Vec3(1, 1, 2.5), 0.0173}, {Vec3(2, 1, 1), 0.0109}, {Vec3(1, 1, 0.4), 0.0064}}) {
            const double stretched = ellipsoidError(beam, c.shape / 40, 0);
            EXPECT_LT(stretched, c.most) << c.shape;
            EXPECT_GT(stretched, ellipsoidError(beam, Vec3(std::min(c.shape.x, c.shape.z) / 40), 0)) << c.shape;
            EXPECT_LT(stretched, ellipsoidError(beam, Vec3(std::max(c.shape.x, c.shape.z) / 40), 0)) << c.shape;
        }
}

TEST(Projector, GridsMayBeTurnedAndStretched) {
    // Voxels of 1 x 2 x 0.5, turned: a ray through the middle of a block of ones crosses a known length.
    auto transform = openvdb::math::Transform::createLinearTransform();
    transform->postScale(openvdb::Vec3d(1, 2, 0.5));
    transform->postRotate(0.3, openvdb::math::Z_AXIS);
    openvdb::FloatGrid grid(0);
    grid.fill({openvdb::Coord(-10, -6, -20), openvdb::Coord(10, 6, 20)}, 0.25f);
    grid.setTransform(transform);
    CircularOrbit orbit;
    orbit.views = 2;
    orbit.firstAngle = 0.3 * 180 / kPi;
    orbit.width = orbit.height = 3;
    const Projections found = projectGrid(grid, circularGeometry(orbit));
    // Interpolation spreads the ends of the block, and keeps the integral.
    EXPECT_NEAR(found.view(0)[4], 0.25 * 21, 1e-6);
    EXPECT_NEAR(found.view(1)[4], 0.25 * 26, 1e-6);
}

TEST(Projector, RefusesWhatCannotBeProjected) {
    const ProjectionGeometry geometry = circularGeometry(smallOrbit(BeamShape::cone));
    openvdb::FloatGrid grid(0);
    EXPECT_THROW(projectGrid(grid, geometry), InvalidArgument);
    grid.fill({openvdb::Coord(1000), openvdb::Coord(1010)}, 1);
    EXPECT_THROW(projectGrid(grid, geometry), InvalidArgument);  // far beside
    ProjectionGeometry flat = geometry;
    flat.views[2].row = flat.views[2].column;
    EXPECT_THROW(projectGrid(grid, flat), InvalidArgument);
    ProjectionGeometry inside = geometry;
    inside.views[1].source = inside.views[1].pixel(3, 4);
    EXPECT_THROW(projectGrid(grid, inside), InvalidArgument);
}
