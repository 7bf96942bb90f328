#include "raysweep/projector/footprint.h"

#include "raysweep/core/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace raysweep {
namespace {

/// Columns and rows of the detector's plane that the footprint of a box reaches.
struct Reach {
    double low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
    int behind = 0;  ///< corners that are not before the source
};

/// @param margin around the centres of the outermost voxels, voxels
Reach reachOf(const VoxelBox& box, double margin, const JosephView& view) {
    const Vec3 normal = view.xray.column.cross(view.xray.row);
    const double area = normal.dot(normal);
    const bool cone = view.beam == BeamShape::cone;
    Reach reach;
    for (int corner = 0; corner < 8; ++corner) {
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis)
            point[axis] = (corner >> axis) & 1 ? box.high[axis] - 1 + margin : box.low[axis] - margin;
        const Vec3 from = cone ? view.xray.source : point,
                   along = cone ? point - view.xray.source : view.xray.direction;
        const double t = normal.dot(view.xray.origin - from) / normal.dot(along);
        if (cone && !(t > 0 && t < 1e9)) {
            ++reach.behind;
            continue;
        }
        // Where the ray through the corner meets the detector, in columns and rows (Cramer's rule).
        const Vec3 place = from + along * t - view.xray.origin;
        const double at[2] = {place.cross(view.xray.row).dot(normal) / area,
                              view.xray.column.cross(place).dot(normal) / area};
        for (int i = 0; i < 2; ++i) {
            reach.low[i] = std::min(reach.low[i], at[i]);
            reach.high[i] = std::max(reach.high[i], at[i]);
        }
    }
    return reach;
}

}  // namespace

PixelBox footprintOf(const VoxelBox& box, const JosephView& view) {
    const auto [low, high, behind] = reachOf(box, 1, view);  // a ray gives to voxels less than one away from it
    if (behind == 8) return {0, 0, 0, 0};
    if (behind > 0) return {0, view.width, 0, view.height};
    const auto limited = [](double value, int count) { return int(std::clamp(value, 0.0, double(count))); };
    return {limited(std::floor(low[0]), view.width), limited(std::ceil(high[0]) + 1, view.width),
            limited(std::floor(low[1]), view.height), limited(std::ceil(high[1]) + 1, view.height)};
}

bool isOnDetector(const VoxelBox& box, const JosephView& view) {
    constexpr double kRounding = 1e-6;  // pixels
    const auto [low, high, behind] = reachOf(box, 0.5, view);
    const double edge = -0.5 - kRounding;
    return behind == 0 && low[0] >= edge && low[1] >= edge && high[0] <= view.width - 1 - edge &&
           high[1] <= view.height - 1 - edge;
}

int requireSeen(const ProjectionGeometry& geometry, const ColumnLattice& lattice) {
    int seen = 0;
    for (int n = 0; n < int(geometry.views.size()); ++n) {
        const PixelBox pixels = footprintOf({Index3(0), lattice.dims}, josephView(geometry, n, lattice));
        seen += pixels.lowColumn < pixels.highColumn && pixels.lowRow < pixels.highRow;
    }
    if (seen > 0) return seen;
    std::ostringstream message;
    const Vec3 end =
        lattice.origin + Vec3(lattice.dims.x - 1, lattice.dims.y - 1, lattice.dims.z - 1) * lattice.worldFromVoxel;
    message << "the detector misses the volume in every view: the volume reaches from " << lattice.origin << " to "
            << end << ", the first view's detector from " << geometry.views[0].pixel(0, 0) << " to "
            << geometry.views[0].pixel(geometry.width - 1, geometry.height - 1) << " (world units); check units and "
            << "offsets";
    throw InvalidArgument(message.str());
}

}  // namespace raysweep
