// Reconstructions from exact line integrals (not from our own projector), against the phantom's mean density of each
// voxel.
#include <gtest/gtest.h>

#include "raysweep/phantoms/ct_phantoms.h"
#include "raysweep/phantoms/exact_projections.h"
#include "raysweep/reconstruct/fbp.h"
#include "raysweep/reconstruct/sart.h"

#include <cmath>
#include <cstdio>

using namespace raysweep;

namespace {

constexpr int kSize = 48;  // voxels along each edge of [-1,1]³

ProjectionGeometry turn(BeamShape beam) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.views = beam == BeamShape::cone ? 150 : 75;  // π/2 per voxel of the width: Nyquist's at the rim
    orbit.arc = beam == BeamShape::cone ? 360 : 180;
    orbit.width = orbit.height = 64;
    orbit.sourceToAxis = orbit.sourceToDetector = 8;
    orbit.pixelWidth = orbit.pixelHeight = 2.0 / kSize;
    return circularGeometry(orbit);
}

struct Errors {
    double sart, filtered;  ///< RMS over the grid: SART; FBP or FDK
};

Errors errorsOf(const std::vector<SolidShape>& shapes, BeamShape beam) {
    const ProjectionGeometry geometry = turn(beam);
    const Projections exact = exactProjections(shapes, geometry);
    const ReconstructionGrid grid{Index3(kSize), Vec3(0), 2.0 / kSize};
    const openvdb::FloatGrid::Ptr truth = voxelize(shapes, openvdb::Coord(kSize), 2.0 / kSize);
    SartOptions options;
    options.lower = 0;
    options.iterations = 3;
    Errors errors;
    errors.sart = sart(exact, geometry, grid, options, {nullptr, truth}).history.back().rms;
    const openvdb::FloatGrid::Ptr filtered = filteredBackprojection(exact, geometry, grid);
    double squares = 0;
    for (const openvdb::Coord& voxel : openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(kSize - 1)))
        squares += std::pow(double(filtered->tree().getValue(voxel)) - truth->tree().getValue(voxel), 2);
    errors.filtered = std::sqrt(squares / std::pow(kSize, 3));
    return errors;
}

}  // namespace

TEST(ExactCt, AnEllipsoidComesBackBySartAndByFiltering) {
    const std::vector<SolidShape> egg{ellipsoid(1, Vec3(0.1, -0.05, 0.07), Vec3(0.7, 0.5, 0.6), 20)};
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        const Errors found = errorsOf(egg, beam);
        std::printf("egg %.5f %.5f\n", found.sart, found.filtered);
        EXPECT_LT(found.sart, 0.04);
        EXPECT_LT(found.filtered, 0.04);
    }
}

TEST(ExactCt, TheSheppLoganHeadComesBackBySartAndByFiltering) {
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        const Errors found = errorsOf(sheppLogan(), beam);
        std::printf("head %.5f %.5f\n", found.sart, found.filtered);
        EXPECT_LT(found.sart, 0.08);
        EXPECT_LT(found.filtered, 0.08);
    }
}
