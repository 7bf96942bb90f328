// One call makes a volume of a scan: from files to a volume in the library alone; what it makes is what its parts make;
// where the volume lies; what is said of it, and what is refused.
#include "raysweep/reconstruct/reconstruct.h"

#include "raysweep/phantoms/ct_phantoms.h"
#include "raysweep/phantoms/exact_projections.h"
#include "raysweep/reconstruct/rays_beside.h"
#include "raysweep/scan/line_integrals.h"
#include "raysweep/volume/statistics.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <utility>

#include "support/temporary_folder.h"
#include "support/volumes.h"
#include "unit/scan/ct_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

using Method = ReconstructionMethod;
using Kind = ReconstructionWarning::Kind;

/// 32x32x16 voxels of 1 world unit.
PhantomOptions smallBox() {
    PhantomOptions options;
    options.dims = openvdb::Coord(32, 32, 16);
    options.voxelSize = 1;
    return options;
}

CircularOrbit orbitOf(BeamShape beam) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.views = 24;
    orbit.width = 48;
    orbit.height = 20;
    if (beam == BeamShape::cone) {
        orbit.arc = 360;
        orbit.sourceToAxis = 80;
        orbit.sourceToDetector = 100;
    }
    return orbit;
}

/// The exact line integrals of the box.
Scan scanOf(const CircularOrbit& orbit) {
    Scan scan;
    scan.geometry = circularGeometry(orbit);
    scan.projections = exactProjections(boxWithHoles(smallBox()), scan.geometry);
    return scan;
}

Scan smallScan(BeamShape beam = BeamShape::parallel) {
    return scanOf(orbitOf(beam));
}

/// On the box's voxels.
ReconstructOptions onItsVoxels(Method method) {
    ReconstructOptions options;
    options.method = method;
    options.grid.dims = Index3(32, 32, 16);
    options.grid.spacing = Vec3(1);
    options.sart.iterations = 2;
    return options;
}

bool hasWarning(const Reconstruction& result, Kind kind) {
    return std::any_of(result.warnings.begin(), result.warnings.end(),
                       [&](const ReconstructionWarning& warning) { return warning.kind == kind; });
}

void expectRefused(const Scan& scan, const ReconstructOptions& options, const std::string& message) {
    expectError<InvalidArgument>([&] { reconstruct(scan, options); }, message);
}

}  // namespace

TEST(Reconstruct, FromFilesToAVolumeByEveryMethod) {
    // Of the RMS distance from the box, of values 0 and 1. Found, in this order: .0749 .0775 .1186 .0819, .1110 .1027
    // .1254 .1658.
    using Limits = std::map<Method, double>;
    const std::pair<BeamShape, Limits> cases[] = {
        {BeamShape::parallel,
         {{Method::sart, 0.082}, {Method::osSart, 0.085}, {Method::sirt, 0.13}, {Method::fbp, 0.09}}},
        {BeamShape::cone,
         {{Method::sart, 0.122}, {Method::osSart, 0.1125}, {Method::sirt, 0.137}, {Method::fbp, 0.182}}}};
    const TemporaryFolder folder;
    const openvdb::FloatGrid::Ptr box = makeBoxWithHoles(smallBox());
    for (const auto& [beam, limits] : cases) {
        std::filesystem::create_directory(folder / "scan");
        writeProjections(folder / "scan/p.exr", smallScan(beam).projections);
        ScanOptions scanOptions;
        scanOptions.projections = {folder / "scan"};
        scanOptions.geometry.beam = beam;
        if (beam == BeamShape::cone) {
            scanOptions.geometry.sourceToAxis = 80;
            scanOptions.geometry.sourceToDetector = 100;
        }
        const Scan scan = readScan(scanOptions);
        for (const auto& [method, limit] : limits) {
            ReconstructOptions options;
            options.method = method;
            options.volumes.reference = box;
            options.sart.iterations = method == Method::sirt ? 10 : 3;
            const Reconstruction result = reconstruct(scan, options);
            const bool direct = method == Method::fbp;
            EXPECT_EQ(result.grid.dims.x, 20) << "the box takes up 5/8 of 32";
            EXPECT_EQ(result.viewsSeeing, 24);
            EXPECT_EQ(result.termination,
                      direct ? ReconstructionTermination::done : ReconstructionTermination::iterations);
            EXPECT_EQ(result.history.size(), direct ? 0u : std::size_t(options.sart.iterations));
            EXPECT_EQ(result.updates, direct ? 0
                                             : options.sart.iterations * (method == Method::sart     ? 24
                                                                          : method == Method::osSart ? 12
                                                                                                     : 1));
            EXPECT_LT(result.rms, limit);
            if (!direct) {
                EXPECT_NEAR(result.rms, result.history.back().rms, 1e-6) << "both of the last volume";
            }
            EXPECT_GT(result.seconds.total, 0);
            EXPECT_TRUE(result.warnings.empty()) << result.warnings.front().message;
        }
    }
}

TEST(Reconstruct, MakesWhatItsPartsMake) {
    const Scan scan = smallScan(BeamShape::cone);
    ReconstructOptions options = onItsVoxels(Method::osSart);
    options.subset = 5;
    options.sart.lower = 0;
    const ReconstructionGrid grid{Index3(32, 32, 16), Vec3(0), Vec3(1)};
    SartOptions together = options.sart;
    together.viewsPerUpdate = 5;
    const auto direct = filteredBackprojection(scan.projections, scan.geometry, grid, options.fbp);
    EXPECT_TRUE(
        sameBits(*reconstruct(scan, options).volume, *sart(scan.projections, scan.geometry, grid, together).volume));
    EXPECT_TRUE(sameBits(*reconstruct(scan, onItsVoxels(Method::fbp)).volume, *direct));
    options.startFiltered = true;
    const Reconstruction started = reconstruct(scan, options);
    EXPECT_TRUE(
        sameBits(*started.volume, *sart(scan.projections, scan.geometry, grid, together, {direct, nullptr}).volume));
    EXPECT_GT(started.seconds.filtered, 0);
    EXPECT_TRUE(std::isnan(started.rms));
}

TEST(Reconstruct, TheDifferenceToTheReferenceIsThatOfTheHistory) {
    const openvdb::FloatGrid::Ptr box = makeBoxWithHoles(smallBox());
    box->tree().setValueOff(box->evalActiveVoxelBoundingBox().min().offsetBy(-1), 7);  // is nothing: it is not active
    ReconstructOptions options = onItsVoxels(Method::sart);
    options.volumes.reference = box;
    const Reconstruction result = reconstruct(smallScan(), options);
    EXPECT_NEAR(result.rms, result.history.back().rms, 1e-12);

    box->setTransform(openvdb::math::Transform::createLinearTransform(0.9));
    options.grid.center = Vec3(0);
    expectRefused(smallScan(), options, "the reference volume are not where those of the reconstruction are");
    options.method = Method::fbp;
    EXPECT_GT(reconstruct(smallScan(), options).rms, 0) << "compared where it is";
}

TEST(Reconstruct, RaysThatWereNotMeasuredAreFilledInForFilteredBackprojectionOnly) {
    Scan scan = smallScan();
    scan.projections.view(3)[200] = std::numeric_limits<float>::quiet_NaN();
    Projections complete = scan.projections;
    fillUnmeasured(complete);
    const ReconstructOptions options = onItsVoxels(Method::fbp);
    const Reconstruction result = reconstruct(scan, options);
    EXPECT_TRUE(sameBits(*result.volume, *filteredBackprojection(complete, scan.geometry, result.grid, options.fbp)));
    const std::size_t all = reconstruct(smallScan(), onItsVoxels(Method::sart)).raysUsed;
    EXPECT_EQ(reconstruct(scan, onItsVoxels(Method::sart)).raysUsed, all - 1);
}

TEST(Reconstruct, WhereTheVolumeLies) {
    const ProjectionGeometry geometry = smallScan().geometry;
    const ReconstructionGrid seen = coveringGrid(geometry);
    const ReconstructionGrid all = reconstructionGrid(geometry, {});
    EXPECT_EQ(all.dims.x, seen.dims.x);
    EXPECT_EQ(all.spacing, seen.spacing);

    GridOptions options;
    options.spacing = seen.spacing * 2.0;
    EXPECT_EQ(reconstructionGrid(geometry, options).dims.x, (seen.dims.x + 1) / 2) << "the extent stays";
    options.dims = Index3(4, 5, 6);
    options.center = Vec3(1, 2, 3);
    const ReconstructionGrid asked = reconstructionGrid(geometry, options);
    EXPECT_EQ(asked.dims.z, 6);
    EXPECT_EQ((asked.center - Vec3(1, 2, 3)).length(), 0);

    // Wherever the axis is, also with fewer voxels than all that is seen, and whatever the detector's rows are.
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        CircularOrbit orbit;
        orbit.beam = beam;
        orbit.sourceToAxis = 60;
        orbit.sourceToDetector = 90;
        orbit.views = 12;
        orbit.width = 24;
        orbit.height = 16;
        orbit.center = Vec3(40, -30, 20);
        const auto isCentered = [&orbit](const GridOptions& grid, double tolerance) {
            return (reconstructionGrid(circularGeometry(orbit), grid).center - orbit.center).length() < tolerance;
        };
        GridOptions few;
        few.dims = Index3(6, 6, 4);
        EXPECT_TRUE(isCentered(few, 1e-12));
        few.spacing = Vec3(0.5);
        EXPECT_TRUE(isCentered(few, 1e-12));
        orbit.views = 2;  // of a cone no turn, but the rays through the detector's middle meet
        orbit.arc = 90;
        // Found: 7.8e-6 of parallel rays, whose axis may then fall onto any column, so that the fit holds it by a
        // ridge.
        EXPECT_TRUE(isCentered(few, 8.5e-6));
    }

    // A frame: its active voxels; with other dims voxels still lie on its voxels.
    const openvdb::FloatGrid::Ptr box = makeBoxWithHoles(smallBox());
    const ReconstructionGrid framed = reconstructionGrid(geometry, {}, box.get());
    EXPECT_EQ(framed.dims.x, 20);
    EXPECT_LT((framed.center - middleOf(*box)).length(), 1e-9);
    GridOptions odd;
    odd.dims = Index3(5, 5, 5);
    const ReconstructionGrid snapped = reconstructionGrid(geometry, odd, box.get());
    const Vec3 first = snapped.voxel(0, 0, 0);
    const openvdb::Vec3d index = box->worldToIndex(openvdb::Vec3d(first.x, first.y, first.z));
    EXPECT_LT((index - openvdb::Coord::round(index).asVec3d()).length(), 1e-9);

    const auto stretched = openvdb::math::Transform::createLinearTransform(
        openvdb::math::Mat4d(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1));
    box->setTransform(stretched);
    const ReconstructionGrid taken = reconstructionGrid(geometry, {}, box.get());
    EXPECT_EQ(taken.spacing, Vec3(1, 1, 2)) << "a frame's voxels need not be cubes";
    EXPECT_LT((taken.center - middleOf(*box)).length(), 1e-9);
    const openvdb::Vec3d last = taken.transform()->indexToWorld(openvdb::Vec3d(1, 2, 3));
    EXPECT_LT((Vec3(last.x(), last.y(), last.z()) - taken.voxel(1, 2, 3)).length(), 1e-12);
    stretched->postRotate(0.1, openvdb::math::X_AXIS);  // but then must lie along the world's axes
    for (const bool both : {false, true}) {
        GridOptions flat;
        flat.dims = Index3(5, 5, 5);
        if (both) flat.spacing = Vec3(1);
        const auto call = [&] { reconstructionGrid(geometry, flat, box.get()); };
        if (both)
            EXPECT_NO_THROW(call());
        else
            expectError<InvalidArgument>(call, "are no cubes and do not lie along the world's axes");
    }

    options.spacing = Vec3(1, 0, 1);
    expectError<InvalidArgument>([&] { reconstructionGrid(geometry, options); }, "spacing 0: must be positive");
    options.dims = Index3(4, 0, 6);
    expectError<InvalidArgument>([&] { reconstructionGrid(geometry, options); }, "dims[1] 0: must be 1 to 16384");
}

TEST(Reconstruct, StopsForGoodWhenAskedToOnce) {
    ReconstructOptions options = onItsVoxels(Method::sart);
    options.startFiltered = true;
    int calls = 0;
    const Reconstruction result =
        reconstruct(smallScan(), options, [&](const std::string&, double) { return ++calls != 3; });
    EXPECT_EQ(result.termination, ReconstructionTermination::interrupted);
    EXPECT_EQ(result.updates, 0);
    EXPECT_EQ(calls, 3) << "nobody is asked again";
    const Reconstruction direct =
        reconstruct(smallScan(), onItsVoxels(Method::fbp), [](const std::string&, double) { return false; });
    EXPECT_EQ(direct.termination, ReconstructionTermination::interrupted);
}

TEST(Reconstruct, WhatIsHardlyMeantIsSaid) {
    ReconstructOptions large = onItsVoxels(Method::sart);
    large.grid.spacing = Vec3(10);
    const Reconstruction coarse = reconstruct(smallScan(), large);
    EXPECT_TRUE(hasWarning(coarse, Kind::voxelSize));
    EXPECT_FALSE(hasWarning(coarse, Kind::emptyVolume));

    ReconstructOptions aside = onItsVoxels(Method::sart);
    aside.grid.dims = Index3(4, 4, 4);
    aside.grid.center = Vec3(100, 0, 0);
    EXPECT_TRUE(hasWarning(reconstruct(smallScan(), aside), Kind::fewViews));

    Scan nothing = smallScan();
    std::fill(nothing.projections.values.begin(), nothing.projections.values.end(), 0.f);
    EXPECT_TRUE(hasWarning(reconstruct(nothing, onItsVoxels(Method::sart)), Kind::emptyVolume));

    Scan saturated = smallScan();
    saturated.projections.saturation = 5;
    EXPECT_TRUE(hasWarning(reconstruct(saturated, onItsVoxels(Method::fbp)), Kind::saturation));
    EXPECT_FALSE(hasWarning(reconstruct(saturated, onItsVoxels(Method::sart)), Kind::saturation));

    Scan opaque = smallScan();
    for (float& value : opaque.projections.values) value *= 10;
    EXPECT_TRUE(hasWarning(reconstruct(opaque, onItsVoxels(Method::sart)), Kind::opaqueVoxel));

    CircularOrbit half = orbitOf(BeamShape::parallel);
    half.arc = 90;
    EXPECT_TRUE(hasWarning(reconstruct(scanOf(half), onItsVoxels(Method::fbp)), Kind::shortScan));
    CircularOrbit fan = orbitOf(BeamShape::cone);
    fan.arc = 180;  // without the angle of the fan
    EXPECT_TRUE(hasWarning(reconstruct(scanOf(fan), onItsVoxels(Method::fbp)), Kind::shortScan));
}

// A box of 20x20x10 voxels, in as many or less of them.
TEST(Reconstruct, ThatTheObjectIsLargerThanTheGridIsSaidWhereItMatters) {
    const auto isSaid = [](BeamShape beam, Method method, const Index3& dims) {
        ReconstructOptions options = onItsVoxels(method);
        options.grid.dims = dims;
        return hasWarning(reconstruct(scanOf(orbitOf(beam)), options), Kind::raysBeside);
    };
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        EXPECT_FALSE(isSaid(beam, Method::sart, Index3(20, 20, 16)));
        EXPECT_FALSE(isSaid(beam, Method::sart, Index3(24, 24, 16)));
        EXPECT_TRUE(isSaid(beam, Method::sart, Index3(12, 20, 16)));
        EXPECT_TRUE(isSaid(beam, Method::sirt, Index3(10, 10, 16)));
        EXPECT_FALSE(isSaid(beam, Method::fbp, Index3(12, 12, 16))) << "needs no more";
    }
    EXPECT_FALSE(isSaid(BeamShape::parallel, Method::sart, Index3(20, 20, 4))) << "slices of parallel rays are apart";
    EXPECT_TRUE(isSaid(BeamShape::cone, Method::sart, Index3(20, 20, 4)));
}

// By hand: of the rays along x that see a block of 20 by 20, half pass a grid of 9 voxels, which reach 10 of them; of
// those along y none: a quarter of all. They measure what the others do.
TEST(Reconstruct, HowMuchRunsBesideTheGridIsCounted) {
    CircularOrbit orbit = orbitOf(BeamShape::parallel);
    orbit.views = 2;
    orbit.arc = 180;
    const ProjectionGeometry geometry = circularGeometry(orbit);
    const Projections projections = exactProjections({box(0.1, Vec3(0), Vec3(10, 10, 8))}, geometry);
    const auto beside = findRaysBeside(projections, geometry, {Index3(20, 9, 16), Vec3(0), Vec3(1)});
    ASSERT_TRUE(beside);
    EXPECT_NEAR(beside->share, 0.25, 1e-12);
    EXPECT_NEAR(beside->mean, 1, 1e-6);
    EXPECT_FALSE(findRaysBeside(projections, geometry, {Index3(20, 20, 16), Vec3(0), Vec3(1)}));
}

TEST(Reconstruct, WhatNoMachineHoldsIsRefusedBeforeItIsTried) {
    const ReconstructionGrid grid{Index3(100, 100, 100), Vec3(0), Vec3(1)};
    ReconstructOptions options;
    EXPECT_EQ(leastBytes(grid, options), 4e6 / 16) << "what no view looks past";
    options.sart.support = Support::none;
    EXPECT_EQ(leastBytes(grid, options), 4e6);
    options.sart.support = Support::automatic;
    options.method = Method::fbp;
    EXPECT_EQ(leastBytes(grid, options), 4e6);
    options.grid.dims = Index3(kMostVoxelsAlong, kMostVoxelsAlong, kMostVoxelsAlong);
    options.grid.spacing = Vec3(1e-3);
    expectRefused(smallScan(), options, "a volume of 16384x16384x16384 voxels needs");
}

TEST(Reconstruct, WhatCannotBeReconstructedIsRefused) {
    const Scan scan = smallScan();
    Scan other = scan;
    other.geometry.views.pop_back();
    expectRefused(other, {}, "the geometry has 23 views, but the projections have 24");

    Scan none = scan;
    none.geometry.views.clear();
    none.projections = Projections(scan.geometry.width, scan.geometry.height, 0);
    for (const Method method : {Method::sart, Method::fbp})
        expectRefused(none, onItsVoxels(method), "the geometry has no views");

    CircularOrbit once = orbitOf(BeamShape::parallel);
    once.views = 1;
    ReconstructOptions options;
    expectRefused(scanOf(once), options, "not those of a turn about an axis");
    EXPECT_FALSE(reconstruct(scanOf(once), onItsVoxels(Method::sart)).volume->empty()) << "the grid is known";
    options.method = Method::fbp;
    expectRefused(scanOf(once), options, "filtered backprojection needs a turn");

    options = onItsVoxels(Method::sart);
    options.grid.center = Vec3(0, 0, 900);
    expectRefused(scan, options, "the detector misses the volume in every view");
    options = {};
    options.subset = -1;
    expectRefused(scan, options, "subset -1");
    options = {};
    options.sart.relaxation = 2.5;
    expectRefused(scan, options, "relaxation 2.5");
    options = {};
    options.volumes.reference = openvdb::FloatGrid::create();
    expectRefused(scan, options, "the reference volume has no active voxels");
    options = {};
    options.volumes.initial = makeBoxWithHoles(smallBox());
    options.startFiltered = true;
    expectRefused(scan, options, "startFiltered");
}
