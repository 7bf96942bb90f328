#include "raysweep/reconstruct/fbp.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/reconstruct/orbit_fit.h"
#include "raysweep/reconstruct/scan_angles.h"
#include "raysweep/reconstruct/view_matrix.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <memory>
#include <sstream>
#include <vector>

namespace raysweep {
namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

void requireMatching(const Projections& projections, const ProjectionGeometry& geometry) {
    const auto text = [](int width, int height, std::size_t views) {
        return std::to_string(views) + " views of " + std::to_string(width) + "x" + std::to_string(height) + " pixels";
    };
    if (projections.width != geometry.width || projections.height != geometry.height ||
        std::size_t(projections.views) != geometry.views.size() ||
        projections.values.size() != projections.pixelsPerView() * geometry.views.size())
        throw InvalidArgument("the projections are " +
                              text(projections.width, projections.height, std::size_t(projections.views)) +
                              ", the geometry has " + text(geometry.width, geometry.height, geometry.views.size()));
}

void requireFinite(const Projections& projections) {
    const std::size_t width = std::size_t(projections.width), perView = projections.pixelsPerView();
    for (std::size_t n = 0; n < projections.values.size(); ++n)
        if (!std::isfinite(projections.values[n]))
            throw InvalidArgument("view " + std::to_string(n / perView) + ", column " + std::to_string(n % width) +
                                  ", row " + std::to_string(n % perView / width) + ": the value is " +
                                  std::to_string(projections.values[n]) +
                                  "; filtered backprojection needs all pixels, so fill in what was not measured");
}

/// The turn that the views make, and what each stands for.
struct Scan {
    OrbitFit orbit;
    ScanAngles angles;
    bool cone;

    explicit Scan(const ProjectionGeometry& geometry)
        : orbit(fitOrbit(geometry)),
          angles(scanAngles(orbit.angles, geometry.beam == BeamShape::cone ? 2 * kPi : kPi)),
          cone(geometry.beam == BeamShape::cone) {}

    /// Without the part along the axis.
    Vec3 inPlane(const Vec3& v) const { return v - orbit.axis * v.dot(orbit.axis); }

    /// From the source's line to the axis, in the orbit's plane and sense, radians.
    double fanAngle(const XrayView& view, const Vec3& pixel) const {
        const Vec3 toAxis = inPlane(orbit.center - view.source), ray = inPlane(pixel - view.source);
        return std::atan2(toAxis.cross(ray).dot(orbit.axis), toAxis.dot(ray));
    }

    /// What a ray counts, before its view is filtered: its part of the turn, half of it where a full turn measures each
    /// line twice, and the cosine of its angle with the ray to the axis.
    double weight(const XrayView& view, std::size_t n, const Vec3& pixel) const {
        if (!cone) return angles.weights[n];
        const double cosine = (pixel - view.source).normalized().dot(inPlane(orbit.center - view.source).normalized());
        if (angles.closed) return 0.5 * angles.weights[n] * cosine;
        const double turned = orbit.angles[n] - angles.begin;
        const double beta = turned - 2 * kPi * std::floor(turned / (2 * kPi));
        return parkerWeight(beta, fanAngle(view, pixel), 0.5 * (angles.arc - kPi)) * angles.weights[n] * cosine;
    }

    /// What filtering pixels as if their distance were 1, and backprojecting with 1/depth², leaves to be done: 1/pitch,
    /// and for cones distance of source and axis over that of source and detector, both in the orbit's plane.
    double scale(const XrayView& view) const {
        const Vec3 column = inPlane(view.column);
        if (!cone) return 1 / column.cross(view.direction).length();
        const Vec3 normal = inPlane(view.column.cross(view.row)).normalized();
        // Where the detector's plane meets the orbit's: a row's direction there, at right angles to `normal`.
        const Vec3 facing = view.column.cross(view.row);
        const double distance = std::abs((view.origin - view.source).dot(facing) / normal.dot(facing));
        return orbit.radius / (distance * column.length());
    }
};

/// A view ready for backprojection. Pixels are stored with a rim of zeros: one before, two after, so that the four
/// pixels about any place on the detector or one pixel beside it are there.
struct FilteredViews {
    int width, height;  ///< without the rim
    std::size_t stride;
    std::size_t perView;
    std::vector<float> values;
    std::vector<ViewMatrix> matrices;

    explicit FilteredViews(const ProjectionGeometry& geometry)
        : width(geometry.width),
          height(geometry.height),
          stride(std::size_t(width) + 3),
          perView(stride * (std::size_t(height) + 3)),
          values(perView * geometry.views.size()) {
        for (const XrayView& view : geometry.views) matrices.push_back(viewMatrix(view, geometry.beam));
    }

    float* row(std::size_t n, int y) { return values.data() + n * perView + std::size_t(y + 1) * stride + 1; }
    const float* view(std::size_t n) const { return values.data() + n * perView; }
};

void filterView(FilteredViews& filtered, std::size_t n, const Projections& projections, const XrayView& view,
                const Scan& scan, const RampFilter& ramp) {
    const double scale = scan.scale(view);
    parallelFor(std::size_t(filtered.height), [&](std::size_t y) {
        const float* from = projections.view(int(n)) + y * std::size_t(filtered.width);
        float* to = filtered.row(n, int(y));
        for (int x = 0; x < filtered.width; ++x)
            to[x] = float(from[x] * scale * scan.weight(view, n, view.pixel(x, double(y))));
    });
    ramp.apply(filtered.row(n, 0), std::size_t(filtered.height), filtered.stride);
}

/// A number that changes evenly from voxel to voxel of a column.
struct Progression {
    float first, step;
    float operator()(int k) const { return first + float(k) * step; }
};

/// Adds what one view shows to the `count` voxels of a column along z that begins at `first`.
void backprojectColumn(const FilteredViews& views, std::size_t n, const Vec3& first, double spacing, int count,
                       float* sums) {
    const ViewMatrix& matrix = views.matrices[n];
    const auto along = [&](const ViewMatrix::Affine& f) {
        return Progression{float(f(first)), float(f.a.z * spacing)};
    };
    const Progression x = along(matrix.x), y = along(matrix.y), depth = along(matrix.depth);
    const float* pixels = views.view(n);
    const float right = float(views.width + 1), low = float(views.height + 1);
    const std::size_t stride = views.stride;
    for (int k = 0; k < count; ++k) {
        const float inverse = 1 / depth(k);
        const float u = std::min(std::max(x(k) * inverse + 1, 0.0f), right);
        const float v = std::min(std::max(y(k) * inverse + 1, 0.0f), low);
        const int column = int(u), row = int(v);
        const float fu = u - float(column), fv = v - float(row);
        const float* p = pixels + std::size_t(row) * stride + std::size_t(column);
        const float above = p[0] + fu * (p[1] - p[0]), below = p[stride] + fu * (p[stride + 1] - p[stride]);
        sums[k] += inverse * inverse * (above + fv * (below - above));
    }
}

constexpr int kEdge = 8;  ///< of a leaf

/// The voxels of the leaves above each other at (i,j), i and j multiples of 8: 64 columns.
std::vector<float> backprojectBlock(const FilteredViews& views, const ReconstructionGrid& where, int i, int j) {
    const int count = where.dims.z;
    const int endI = std::min(kEdge, where.dims.x - i), endJ = std::min(kEdge, where.dims.y - j);
    std::vector<float> sums(std::size_t(kEdge) * kEdge * std::size_t(count));
    for (std::size_t n = 0; n < views.matrices.size(); ++n)
        for (int a = 0; a < endI; ++a)
            for (int b = 0; b < endJ; ++b)
                backprojectColumn(views, n, where.voxel(i + a, j + b, 0), where.spacing, count,
                                  sums.data() + std::size_t(a * kEdge + b) * std::size_t(count));
    return sums;
}

using Leaves = std::vector<std::unique_ptr<Leaf>>;

Leaves leavesOf(const std::vector<float>& sums, const ReconstructionGrid& where, int i, int j, bool nonNegative) {
    const int count = where.dims.z;
    Leaves leaves;
    for (int k = 0; k < count; k += kEdge) {
        auto leaf = std::make_unique<Leaf>(openvdb::Coord(i, j, k), 0.0f);
        for (openvdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const openvdb::Coord local = Leaf::offsetToLocalCoord(offset);
            if (k + local.z() >= count) continue;
            const float value =
                sums[std::size_t(local.x() * kEdge + local.y()) * std::size_t(count) + std::size_t(k + local.z())];
            if (nonNegative ? value > 0 : value != 0) leaf->setValueOn(offset, value);
        }
        if (!leaf->isEmpty()) leaves.push_back(std::move(leaf));
    }
    return leaves;
}

/// The depths of the grid's corners bound those of all its voxels.
void requireInFront(const FilteredViews& views, const ReconstructionGrid& where) {
    for (std::size_t n = 0; n < views.matrices.size(); ++n)
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 p = where.voxel(corner & 1 ? where.dims.x - 1 : 0, corner & 2 ? where.dims.y - 1 : 0,
                                       corner & 4 ? where.dims.z - 1 : 0);
            if (!(views.matrices[n].depth(p) > 1e-6))
                throw InvalidArgument("view " + std::to_string(n) +
                                      ": the reconstruction grid reaches behind the source; take a smaller one");
        }
}

}  // namespace

void FbpOptions::validate() const {
    if (!(cutoff > 0 && cutoff <= 1))
        throw InvalidArgument("cutoff is " + std::to_string(cutoff) + ", but must be in (0,1]");
}

std::string scanWarning(const ProjectionGeometry& geometry) {
    const Scan scan(geometry);
    if (scan.angles.closed) return "";
    double fan = 0;
    for (const XrayView& view : geometry.views) {
        if (!scan.cone) break;
        for (const int x : {0, geometry.width - 1})
            fan = std::max(fan, std::abs(scan.fanAngle(view, view.pixel(x, 0.5 * (geometry.height - 1)))));
    }
    const double degrees = 180 / kPi, needed = 180 + 2 * fan * degrees, arc = scan.angles.arc * degrees;
    if (arc > needed - 1) return "";
    std::ostringstream text;
    text << std::fixed << std::setprecision(1) << "the views cover " << arc << " degrees, but filtered backprojection "
         << "needs " << needed << (scan.cone ? " (half a turn and the angle of the fan)" : "")
         << ": expect streaks, or take an iterative method";
    return text.str();
}

openvdb::FloatGrid::Ptr filteredBackprojection(const Projections& projections, const ProjectionGeometry& geometry,
                                               const ReconstructionGrid& where, const FbpOptions& options,
                                               const ProgressCallback& progress) {
    options.validate();
    where.validate();
    requireMatching(projections, geometry);
    const Scan scan(geometry);
    requireFinite(projections);
    FilteredViews filtered(geometry);
    requireInFront(filtered, where);

    const auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(where.transform());
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    const RampFilter ramp(geometry.width, options.window, options.cutoff);
    for (std::size_t n = 0; n < geometry.views.size(); ++n) {
        if (!report(progress, "filtering", double(n) / double(geometry.views.size()))) return grid;
        filterView(filtered, n, projections, geometry.views[n], scan, ramp);
    }
    for (int i = 0; i < where.dims.x; i += kEdge) {
        if (!report(progress, "backprojecting", double(i) / where.dims.x)) return grid;
        std::vector<Leaves> made(std::size_t((where.dims.y + kEdge - 1) / kEdge));
        parallelFor(made.size(), [&](std::size_t block) {
            const int j = int(block) * kEdge;
            made[block] = leavesOf(backprojectBlock(filtered, where, i, j), where, i, j, options.nonNegative);
        });
        for (Leaves& leaves : made)
            for (auto& leaf : leaves) grid->tree().addLeaf(leaf.release());
    }
    return grid;
}

}  // namespace raysweep
