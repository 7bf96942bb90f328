// Rays that say no more than "at least" or "at most": a ball of metal that stops all of them, and air that over-exposes
// the detector.
#include "raysweep/phantoms/solid_shapes.h"
#include "raysweep/projector/project_grid.h"
#include "raysweep/reconstruct/reconstruct.h"
#include "raysweep/scan/line_integrals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

using namespace raysweep;

namespace {

using Shapes = std::vector<SolidShape>;

const Vec3 kMetal(10, 6, 0);
constexpr double kBody = 0.05, kMetalRadius = 3;

Shapes bodyWithMetal(double metal) {
    return {ellipsoid(kBody, Vec3(0), Vec3(20, 17, 20), 0), ellipsoid(metal, kMetal, Vec3(kMetalRadius), 0)};
}

ProjectionGeometry turn() {
    CircularOrbit orbit;
    orbit.views = 90;
    orbit.width = 56;
    orbit.height = 12;
    return circularGeometry(orbit);
}

/// Of voxels, since the edge of a ball of metal within a voxel, many times as dense as what is beside it, is another
/// matter.
Projections projectionsOf(const Shapes& shapes) {
    const openvdb::FloatGrid::Ptr voxels = voxelize(shapes, openvdb::Coord(56, 56, 12), 1);
    voxels->setTransform(ReconstructionGrid{Index3(56, 56, 12), Vec3(0), Vec3(1)}.transform());
    return projectGrid(*voxels, turn());
}

/// What an integrating detector counts; `bright` without object.
Projections countsOf(const Shapes& shapes, double bright, double most) {
    Projections counts = projectionsOf(shapes);
    for (float& value : counts.values)
        value = float(std::min(most, std::round(100 + bright * std::exp(-double(value)))));
    return counts;
}

LineIntegrals integralsOf(const Projections& counts, double bright, double most) {
    LineIntegralOptions options;
    options.leastCount = 1;
    options.saturatedAbove = most;
    const std::vector<float> flat(counts.pixelsPerView(), float(100 + bright)), dark(counts.pixelsPerView(), 100.0f);
    return lineIntegrals(counts, flat, dark, options);
}

/// Relative differences to the body of means of 3x3x3 voxels within it, 3 from its rim and from the metal.
struct Errors {
    double worst = 0, rms = 0;
};

Errors errorsOf(const Projections& projections, const SartOptions& sartOptions) {
    Scan scan;
    scan.projections = projections;
    scan.geometry = turn();
    ReconstructOptions options;
    options.sart = sartOptions;
    const Reconstruction result = reconstruct(scan, options);
    const auto values = result.volume->getConstAccessor();
    Errors errors;
    double squares = 0, count = 0;
    for (const openvdb::Coord& voxel :
         openvdb::CoordBBox(openvdb::Coord(1),
                            openvdb::Coord(result.grid.dims.x - 2, result.grid.dims.y - 2, result.grid.dims.z - 2))) {
        const Vec3 p = result.grid.voxel(voxel.x(), voxel.y(), voxel.z());
        if (std::hypot(p.x / 16, p.y / 13) > 1 || (p - kMetal).length() < kMetalRadius + 4) continue;
        double mean = 0;
        for (int n = 0; n < 27; ++n)
            mean += values.getValue(voxel + openvdb::Coord(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)) / 27;
        errors.worst = std::max(errors.worst, std::abs(mean / kBody - 1));
        squares += std::pow(mean / kBody - 1, 2);
        ++count;
    }
    errors.rms = std::sqrt(squares / count);
    return errors;
}

SartOptions careful() {
    SartOptions options;
    options.iterations = 20;
    options.lower = 0;
    return options;
}

}  // namespace

// A ball ten times as dense as the body, of which the detector sees no more than 3: the middle of the ball stays open.
// Where nothing is cut off the body's RMS error is 0.005 after as many passes.
TEST(BoundedRays, MetalThatStopsAllRaysLeavesTheBodyAsItIs) {
    constexpr float kMost = 3;
    Projections clipped = projectionsOf(bodyWithMetal(0.5));
    for (float& value : clipped.values) value = std::min(value, kMost);
    Projections bounded = clipped, ignored = clipped;
    bounded.saturation = kMost;
    EXPECT_GT(countRays(bounded).saturated, 1000u);
    for (float& value : ignored.values)
        if (value >= kMost) value = std::numeric_limits<float>::quiet_NaN();
    const Errors as = errorsOf(bounded, careful()), asMeasured = errorsOf(clipped, careful()),
                 without = errorsOf(ignored, careful());
    std::printf("metal: bounded %.4f (rms %.4f), taken as measured %.4f (rms %.4f), left out %.4f (rms %.4f)\n",
                as.worst, as.rms, asMeasured.worst, asMeasured.rms, without.worst, without.rms);
    EXPECT_LT(as.rms, 0.0121);   // found: 0.0110
    EXPECT_LT(as.worst, 0.068);  // found: 0.0618, in a streak that the ball throws
    EXPECT_GT(asMeasured.rms, 1.5 * as.rms);
    EXPECT_GT(without.rms, 1.5 * as.rms);
}

// Few counts: none of them says at least log(gain), not as much as the detector could tell with more light.
TEST(BoundedRays, FewCountsBoundNoMoreThanTheyCan) {
    const LineIntegrals few = integralsOf(countsOf(bodyWithMetal(5), 500, 65535), 500, 65536);
    ASSERT_FALSE(few.projections.bounds.empty());
    std::size_t bounded = 0;
    for (std::size_t p = 0; p < few.projections.values.size(); ++p) {
        if (few.projections.boundOf(p) != RayBound::atLeast) continue;
        EXPECT_NEAR(few.projections.values[p], std::log(500.0), 1e-5);
        ++bounded;
    }
    EXPECT_GT(bounded, 1000u);
}

TEST(BoundedRays, OverExposedAirLeavesTheBodyAsItIs) {
    const double bright = 40000, most = 100 + 0.6 * bright;  // all rays of less than 0.51 look alike
    const LineIntegrals integrals = integralsOf(countsOf(bodyWithMetal(0), bright, most), bright, most);
    EXPECT_GT(countRays(integrals.projections).overexposed, 1000u);
    const Errors bounded = errorsOf(integrals.projections, careful());
    Projections taken = integrals.projections;
    taken.bounds.clear();
    const Errors asMeasured = errorsOf(taken, careful());
    std::printf("air: bounded %.4f (rms %.4f), taken as measured %.4f (rms %.4f)\n", bounded.worst, bounded.rms,
                asMeasured.worst, asMeasured.rms);
    EXPECT_LT(bounded.worst, 0.0148);  // found: 0.0135
    EXPECT_GT(asMeasured.worst, 0.2);
}
