// Eq. 3 and 4 of fbp.h: each view is weighted and filtered, then each voxel sums what the views show where it falls.
#include "raysweep/reconstruct/fbp.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/orbit_fit.h"
#include "raysweep/reconstruct/scan_angles.h"
#include "raysweep/reconstruct/view_matrix.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <memory>
#include <sstream>
#include <vector>

namespace raysweep {
namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

void requireFinite(const Projections& projections) {
    const ValuesFound bad = findValues(projections, [](float value) { return !std::isfinite(value); });
    if (bad.count > 0)
        throw InvalidArgument(placeOf(projections, bad.first) + ": the value is " +
                              std::to_string(projections.values[bad.first]) +
                              "; filtered backprojection needs all pixels, so fill in what was not measured");
}

/// The turn that the views make, and what each stands for.
struct ScanOrbit {
    const ProjectionGeometry& geometry;
    OrbitFit orbit;
    ScanAngles angles;
    bool cone;

    explicit ScanOrbit(const ProjectionGeometry& geometry)
        : geometry(geometry),
          orbit(fitOrbit(geometry)),
          angles(scanAngles(orbit.angles, geometry.beam == BeamShape::cone ? 2 * kPi : kPi)),
          cone(geometry.beam == BeamShape::cone) {}

    /// From the source's line to the axis, in the orbit's plane and sense, radians.
    double fanAngle(const XrayView& view, const Vec3& pixel) const {
        const Vec3 toAxis = orbit.inPlane(orbit.center - view.source), ray = orbit.inPlane(pixel - view.source);
        return std::atan2(toAxis.cross(ray).dot(orbit.axis), toAxis.dot(ray));
    }

    /// What a ray counts before its view is filtered, Δθ or w cos φ of eq. 3 and 4.
    double weight(const XrayView& view, std::size_t n, const Vec3& pixel) const {
        if (!cone) return angles.weights[n];
        const double cosine =
            (pixel - view.source).normalized().dot(orbit.inPlane(orbit.center - view.source).normalized());
        if (angles.closed) return 0.5 * angles.weights[n] * cosine;
        const double turned = orbit.angles[n] - angles.begin;
        const double beta = turned - 2 * kPi * std::floor(turned / (2 * kPi));
        return parkerWeight(beta, fanAngle(view, pixel), 0.5 * (angles.arc - kPi)) * angles.weights[n] * cosine;
    }

    /// What filtering pixels as if their distance were 1, and backprojecting with 1/depth², leaves to be done: 1/pitch,
    /// and for cones distance of source and axis over that of source and detector, both in the orbit's plane.
    double scale(const XrayView& view) const {
        const Vec3 column = orbit.inPlane(view.column);
        if (!cone) return 1 / column.cross(view.direction).length();
        const Vec3 normal = orbit.inPlane(view.column.cross(view.row)).normalized();
        // Where the detector's plane meets the orbit's: a row's direction there, at right angles to `normal`.
        const Vec3 facing = view.column.cross(view.row);
        const double distance = std::abs((view.origin - view.source).dot(facing) / normal.dot(facing));
        return orbit.radius / (distance * column.length());
    }
};

/// Views ready for backprojection: detector columns one after the other, as a column of voxels mostly falls on one.
/// They have a rim of zeros, one pixel before, two after, so that the four pixels about any place on the detector or
/// one pixel beside it are there.
struct FilteredViews {
    int width, height;   ///< without the rim
    std::size_t stride;  ///< of columns
    std::size_t perView;
    std::vector<float> values;
    std::vector<ViewMatrix> matrices;

    explicit FilteredViews(const ProjectionGeometry& geometry)
        : width(geometry.width),
          height(geometry.height),
          stride(std::size_t(height) + 3),
          perView(stride * (std::size_t(width) + 3)),
          values(perView * geometry.views.size()) {
        for (const XrayView& view : geometry.views) matrices.push_back(viewMatrix(view, geometry.beam));
    }

    float* column(std::size_t n, int x) { return values.data() + n * perView + std::size_t(x + 1) * stride + 1; }
    const float* view(std::size_t n) const { return values.data() + n * perView; }
};

void filterView(FilteredViews& filtered, std::size_t n, const Projections& projections, const ScanOrbit& scan,
                const RampFilter& ramp) {
    const XrayView& view = scan.geometry.views[n];
    std::vector<float> rows(projections.pixelsPerView());
    const std::size_t width = std::size_t(filtered.width), height = std::size_t(filtered.height);
    const double scale = scan.scale(view);
    parallelFor(height, [&](std::size_t y) {
        const float* from = projections.view(int(n)) + y * width;
        for (std::size_t x = 0; x < width; ++x)
            rows[y * width + x] = float(from[x] * scale * scan.weight(view, n, view.pixel(double(x), double(y))));
    });
    ramp.apply(rows.data(), height, width);
    parallelFor(width, [&](std::size_t x) {
        float* column = filtered.column(n, int(x));
        for (std::size_t y = 0; y < height; ++y) column[y] = rows[y * width + x];
    });
}

/// A number that changes evenly from voxel to voxel of a column.
struct Progression {
    float first, step;
    float operator()(int k) const { return first + float(k) * step; }
};

/// `count` voxels one above the other, and where a view sees them.
struct VoxelColumn {
    Progression x, y, depth;  ///< see ViewMatrix
    int count;

    VoxelColumn(const ViewMatrix& matrix, const Vec3& first, double spacing, int count)
        : x(along(matrix.x, first, spacing)),
          y(along(matrix.y, first, spacing)),
          depth(along(matrix.depth, first, spacing)),
          count(count) {}

    /// All on one column of the detector, at one depth: to a thousandth of a pixel.
    bool isUpright() const {
        const float n = float(count);
        return std::abs(x.step) * n < 1e-3f * depth.first && std::abs(depth.step) * n < 1e-6f * depth.first;
    }

  private:
    static Progression along(const ViewMatrix::Affine& f, const Vec3& first, double spacing) {
        return {float(f(first)), float(f.a.z * spacing)};
    }
};

/// Place on a detector of `size` pixels as one in the rim's count; beside the detector it becomes the rim's edge.
inline float inRim(float place, int size) {
    return std::min(std::max(place + 1, 0.0f), float(size + 1));
}

/// Adds what view n shows to a column of voxels: a term of eq. 3 or 4.
void addTilted(const FilteredViews& views, std::size_t n, const VoxelColumn& voxels, float* sums) {
    const float* pixels = views.view(n);
    const std::size_t stride = views.stride;
    for (int k = 0; k < voxels.count; ++k) {
        const float inverse = 1 / voxels.depth(k);
        const float u = inRim(voxels.x(k) * inverse, views.width), v = inRim(voxels.y(k) * inverse, views.height);
        const int column = int(u), row = int(v);
        const float fu = u - float(column), fv = v - float(row);
        const float* p = pixels + std::size_t(column) * stride + std::size_t(row);
        const float left = p[0] + fv * (p[1] - p[0]), right = p[stride] + fv * (p[stride + 1] - p[stride]);
        sums[k] += inverse * inverse * (left + fu * (right - left));
    }
}

/// The same for an upright column, which needs one blend of two detector columns. `line`: room for a detector column.
void addUpright(const FilteredViews& views, std::size_t n, const VoxelColumn& voxels, float* line, float* sums) {
    const float inverse = 1 / voxels.depth.first;
    const float u = inRim(voxels.x.first * inverse, views.width);
    const Progression y{voxels.y.first * inverse, voxels.y.step * inverse};
    const int column = int(u);
    const float fu = u - float(column);
    const float* left = views.view(n) + std::size_t(column) * views.stride;
    const float* right = left + views.stride;
    const float firstV = inRim(y(0), views.height), lastV = inRim(y(voxels.count - 1), views.height);
    const int from = int(std::min(firstV, lastV)), to = int(std::max(firstV, lastV)) + 1;
    for (int row = from; row <= to; ++row) line[row] = inverse * inverse * (left[row] + fu * (right[row] - left[row]));
    for (int k = 0; k < voxels.count; ++k) {
        const float v = inRim(y(k), views.height);
        const int row = int(v);
        sums[k] += line[row] + (v - float(row)) * (line[row + 1] - line[row]);
    }
}

constexpr int kEdge = 8;  ///< of a leaf

/// The voxels of the leaves above each other at (i,j), i and j multiples of 8: 64 columns.
std::vector<float> backprojectColumns(const FilteredViews& views, const ReconstructionGrid& where, int i, int j) {
    const int count = where.dims.z;
    const int endI = std::min(kEdge, where.dims.x - i), endJ = std::min(kEdge, where.dims.y - j);
    std::vector<float> sums(std::size_t(kEdge) * kEdge * std::size_t(count)), line(views.stride);
    for (std::size_t n = 0; n < views.matrices.size(); ++n)
        for (int a = 0; a < endI; ++a)
            for (int b = 0; b < endJ; ++b) {
                const VoxelColumn voxels(views.matrices[n], where.voxel(i + a, j + b, 0), where.spacing, count);
                float* to = sums.data() + std::size_t(a * kEdge + b) * std::size_t(count);
                if (voxels.isUpright())
                    addUpright(views, n, voxels, line.data(), to);
                else
                    addTilted(views, n, voxels, to);
            }
    return sums;
}

using Leaves = std::vector<std::unique_ptr<Leaf>>;

Leaves leavesOf(const std::vector<float>& sums, const ReconstructionGrid& where, int i, int j,
                const FbpOptions& options) {
    const int count = where.dims.z;
    Leaves leaves;
    for (int k = 0; k < count; k += kEdge) {
        auto leaf = std::make_unique<Leaf>(openvdb::Coord(i, j, k), 0.0f);
        for (openvdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const openvdb::Coord local = Leaf::offsetToLocalCoord(offset);
            if (k + local.z() >= count) continue;
            const float value =
                sums[std::size_t(local.x() * kEdge + local.y()) * std::size_t(count) + std::size_t(k + local.z())];
            if (options.nonNegative ? value > options.tolerance : std::abs(value) > options.tolerance)
                leaf->setValueOn(offset, value);
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

/// @return false if `progress` asked to stop.
bool filterViews(FilteredViews& filtered, const Projections& projections, const ScanOrbit& scan, const RampFilter& ramp,
                 const ProgressCallback& progress) {
    for (std::size_t n = 0; n < filtered.matrices.size(); ++n) {
        if (!report(progress, "filtering", double(n) / double(filtered.matrices.size()))) return false;
        filterView(filtered, n, projections, scan, ramp);
    }
    return true;
}

void backproject(const FilteredViews& filtered, const ReconstructionGrid& where, const FbpOptions& options,
                 const ProgressCallback& progress, openvdb::FloatGrid& grid) {
    for (int i = 0; i < where.dims.x; i += kEdge) {
        if (!report(progress, "backprojecting", double(i) / where.dims.x)) return;
        std::vector<Leaves> made(std::size_t((where.dims.y + kEdge - 1) / kEdge));
        parallelFor(made.size(), [&](std::size_t block) {
            const int j = int(block) * kEdge;
            made[block] = leavesOf(backprojectColumns(filtered, where, i, j), where, i, j, options);
        });
        for (Leaves& leaves : made)
            for (auto& leaf : leaves) grid.tree().addLeaf(leaf.release());
    }
}

}  // namespace

void FbpOptions::validate() const {
    requireField(cutoff > 0 && cutoff <= 1, "cutoff", cutoff, "in (0,1]");
    requireField(tolerance >= 0 && std::isfinite(tolerance), "tolerance", tolerance, "0 or more, and finite");
}

std::string scanWarning(const ProjectionGeometry& geometry) {
    const ScanOrbit scan(geometry);
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
    requireMatching(geometry, projections);
    const ScanOrbit scan(geometry);
    requireFinite(projections);
    FilteredViews filtered(geometry);
    requireInFront(filtered, where);

    const auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(where.transform());
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    const RampFilter ramp(geometry.width, options.window, options.cutoff);
    if (filterViews(filtered, projections, scan, ramp, progress))
        backproject(filtered, where, options, progress, *grid);
    return grid;
}

}  // namespace raysweep
