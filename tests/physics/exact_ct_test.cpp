// Reconstructions from exact line integrals (not from our own projector), against the phantom's mean density of each
// voxel.
#include <gtest/gtest.h>

#include "raysweep/phantoms/ct_phantoms.h"
#include "raysweep/phantoms/exact_projections.h"
#include "raysweep/reconstruct/fbp.h"
#include "raysweep/reconstruct/sart.h"

#include <cmath>

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
    const ReconstructionGrid grid{Index3(kSize), Vec3(0), Vec3(2.0 / kSize)};
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

// A surface of area A cuts 3/2 A/h² voxels of edge h: 3.5 % of these. Neither method can say where in a voxel the jump
// is; were all means from 0 to 1 as good there, the RMS would be sqrt(0.035 / 12) = 0.054. Limits are a tenth above
// what is found.
TEST(ExactCt, AnEllipsoidComesBackBySartAndByFiltering) {
    const std::vector<SolidShape> egg{ellipsoid(1, Vec3(0.1, -0.05, 0.07), Vec3(0.7, 0.5, 0.6), 20)};
    const Errors parallel = errorsOf(egg, BeamShape::parallel), cone = errorsOf(egg, BeamShape::cone);
    EXPECT_LT(parallel.sart, 0.0260);      // found: 0.0236
    EXPECT_LT(parallel.filtered, 0.0229);  // found: 0.0208
    EXPECT_LT(cone.sart, 0.0344);          // found: 0.0313
    EXPECT_LT(cone.filtered, 0.0203);      // found: 0.0185
}

// The skull, of density 1 and 0.8 above the brain, has two surfaces that are 1 to 2 voxels apart.
TEST(ExactCt, TheSheppLoganHeadComesBackBySartAndByFiltering) {
    const Errors parallel = errorsOf(sheppLogan(), BeamShape::parallel), cone = errorsOf(sheppLogan(), BeamShape::cone);
    EXPECT_LT(parallel.sart, 0.0430);      // found: 0.0391
    EXPECT_LT(parallel.filtered, 0.0462);  // found: 0.0421
    EXPECT_LT(cone.sart, 0.0589);          // found: 0.0536
    EXPECT_LT(cone.filtered, 0.0400);      // found: 0.0364
}
