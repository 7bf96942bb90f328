// Voxels that are no cubes, from exact line integrals, against the phantom's mean density of each voxel; beside them
// cubes of their shortest and of their longest edge, between which they should be.
#include "raysweep/phantoms/ct_phantoms.h"
#include "raysweep/phantoms/exact_projections.h"
#include "raysweep/reconstruct/fbp.h"
#include "raysweep/reconstruct/sart.h"

#include "support/detectors.h"
#include "support/worst.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

using namespace raysweep;
using test::rolled;

namespace {

using Shapes = std::vector<SolidShape>;

constexpr double kHalf = 24;  // world units: objects lie in [-kHalf, kHalf]³

const Vec3 kLong(1, 1, 2.5), kWide(2, 1, 1);

/// Pixels of 1 at the axis; as many views as the sampling theorem asks for at the objects' rim.
ProjectionGeometry turn(BeamShape beam, double roll) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.sourceToAxis = 120;
    orbit.sourceToDetector = 180;
    orbit.arc = beam == BeamShape::cone ? 360 : 180;
    orbit.views = beam == BeamShape::cone ? 150 : 75;
    orbit.width = orbit.height = 64;
    if (beam == BeamShape::cone) orbit.pixelWidth = orbit.pixelHeight = 1.5;
    return rolled(circularGeometry(orbit), roll);
}

/// As many voxels as cover the objects.
ReconstructionGrid gridOf(const Vec3& spacing) {
    ReconstructionGrid grid;
    grid.spacing = spacing;
    for (int axis = 0; axis < 3; ++axis) grid.dims[axis] = int(std::ceil(2 * kHalf / spacing[axis] - 1e-9));
    return grid;
}

/// Mean density of a voxel, by 4x4x4 points.
double meanAt(const Shapes& shapes, const Vec3& center, const Vec3& edges) {
    double sum = 0;
    for (int n = 0; n < 64; ++n)
        sum += densityAt(shapes, center + (Vec3(n % 4, n / 4 % 4, n / 16) - Vec3(1.5)) * 0.25 * edges);
    return sum / 64;
}

openvdb::FloatGrid::Ptr truthOf(const Shapes& shapes, const ReconstructionGrid& grid) {
    const auto truth = openvdb::FloatGrid::create(0.0f);
    truth->setTransform(grid.transform());
    for (int i = 0; i < grid.dims.x; ++i)
        for (int j = 0; j < grid.dims.y; ++j)
            for (int k = 0; k < grid.dims.z; ++k)
                truth->tree().setValueOn(openvdb::Coord(i, j, k),
                                         float(meanAt(shapes, grid.voxel(i, j, k), grid.spacing)));
    return truth;
}

double rmsOf(const openvdb::FloatGrid& volume, const openvdb::FloatGrid& truth) {
    double squares = 0, count = 0;
    for (auto value = truth.cbeginValueOn(); value; ++value, ++count)
        squares += std::pow(double(volume.tree().getValue(value.getCoord())) - *value, 2);
    return std::sqrt(squares / count);
}

/// RMS over the grid.
struct Errors {
    double sart, smooth, filtered;  ///< SART; the same with total variation; FBP or FDK
};

Errors errorsOf(const Shapes& shapes, const ProjectionGeometry& geometry, const Vec3& spacing) {
    const Projections exact = exactProjections(shapes, geometry);
    const ReconstructionGrid grid = gridOf(spacing);
    const openvdb::FloatGrid::Ptr truth = truthOf(shapes, grid);
    SartOptions options;
    options.lower = 0;
    options.iterations = 3;
    Errors errors;
    errors.sart = sart(exact, geometry, grid, options, {nullptr, truth}).history.back().rms;
    options.totalVariation = 0.3;
    errors.smooth = sart(exact, geometry, grid, options, {nullptr, truth}).history.back().rms;
    errors.filtered = rmsOf(*filteredBackprojection(exact, geometry, grid), *truth);
    return errors;
}

const Shapes& egg() {
    static const Shapes shapes{ellipsoid(1, Vec3(4, -3, 2), Vec3(17, 13, 15), 30),
                               ellipsoid(-0.5, Vec3(7, -5, 3), Vec3(6, 4, 6), -20)};
    return shapes;
}

Shapes head() {
    Shapes shapes = sheppLogan();
    for (SolidShape& shape : shapes) {
        shape.center *= kHalf;
        for (Vec3& axis : shape.halfAxes) axis *= kHalf;
    }
    return shapes;
}

constexpr double Errors::*kErrors[] = {&Errors::sart, &Errors::smooth, &Errors::filtered};

/// Errors of long and of wide voxels, relative to the larger of those of the two cubes: the largest of them.
double worstAgainstCubes(const std::string& name, const Shapes& shapes, const ProjectionGeometry& geometry) {
    const Errors fine = errorsOf(shapes, geometry, Vec3(1));
    double worst = 0;
    for (const Vec3& spacing : {kLong, kWide}) {
        const Errors coarse = errorsOf(shapes, geometry, Vec3(std::max(spacing.x, spacing.z)));
        const Errors errors = errorsOf(shapes, geometry, spacing);
        std::printf("%-24s %.1f,%.1f,%.1f: sart %.4f (%.4f, %.4f), tv %.4f (%.4f, %.4f), filtered %.4f (%.4f, %.4f)\n",
                    name.c_str(), spacing.x, spacing.y, spacing.z, errors.sart, fine.sart, coarse.sart, errors.smooth,
                    fine.smooth, coarse.smooth, errors.filtered, fine.filtered, coarse.filtered);
        for (const auto error : kErrors) test::raiseTo(worst, errors.*error / std::max(fine.*error, coarse.*error));
    }
    return worst;
}

}  // namespace

// Rows of a parallel beam that lie on the voxels' own planes are as sharp as voxels of 1, of any width.
TEST(VoxelShape, AnEggIsAsGoodInLongVoxelsAsInCubes) {
    EXPECT_LT(worstAgainstCubes("parallel", egg(), turn(BeamShape::parallel, 0)), 1.02);               // found: 1.013
    EXPECT_LT(worstAgainstCubes("parallel, rolled by 3", egg(), turn(BeamShape::parallel, 3)), 0.99);  // 0.905
    EXPECT_LT(worstAgainstCubes("cone", egg(), turn(BeamShape::cone, 0)), 0.92);                       // 0.84
    EXPECT_LT(worstAgainstCubes("cone, rolled by 3", egg(), turn(BeamShape::cone, 3)), 0.95);          // 0.87
    EXPECT_LT(worstAgainstCubes("cone, on its side", egg(), turn(BeamShape::cone, 90)), 0.92);         // 0.84
}

TEST(VoxelShape, AHeadIsAsGoodInLongVoxelsAsInCubes) {
    EXPECT_LT(worstAgainstCubes("head, parallel", head(), turn(BeamShape::parallel, 0)), 1.0);  // found: 0.97
    EXPECT_LT(worstAgainstCubes("head, cone", head(), turn(BeamShape::cone, 0)), 1.0);          // 0.98
}
