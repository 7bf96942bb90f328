#include "raysweep/projector/shadow.h"

#include "raysweep/core/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace raysweep {
namespace {

/// Columns and rows of the detector's plane that the shadow of a box reaches.
struct Reach {
    double low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
    int behind = 0;  ///< corners that are not before the source
};

/// @param margin around the centres of the outermost voxels, voxels
Reach reachOf(const VoxelBox& box, double margin, const ViewFootprint& f) {
    const Vec3 normal = f.view.column.cross(f.view.row);
    const double area = normal.dot(normal);
    const bool cone = f.beam == BeamShape::cone;
    Reach reach;
    for (int corner = 0; corner < 8; ++corner) {
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis)
            point[axis] = (corner >> axis) & 1 ? box.high[axis] - 1 + margin : box.low[axis] - margin;
        const Vec3 from = cone ? f.view.source : point, along = cone ? point - f.view.source : f.view.direction;
        const double t = normal.dot(f.view.origin - from) / normal.dot(along);
        if (cone && !(t > 0 && t < 1e9)) {
            ++reach.behind;
            continue;
        }
        // Where the ray through the corner meets the detector, in columns and rows (Cramer's rule).
        const Vec3 place = from + along * t - f.view.origin;
        const double at[2] = {place.cross(f.view.row).dot(normal) / area,
                              f.view.column.cross(place).dot(normal) / area};
        for (int i = 0; i < 2; ++i) {
            reach.low[i] = std::min(reach.low[i], at[i]);
            reach.high[i] = std::max(reach.high[i], at[i]);
        }
    }
    return reach;
}

}  // namespace

PixelBox shadowOf(const VoxelBox& box, const ViewFootprint& f) {
    const auto [low, high, behind] = reachOf(box, 1, f);  // a ray gives to voxels less than one away from it
    if (behind == 8) return {0, 0, 0, 0};
    if (behind > 0) return {0, f.width, 0, f.height};
    const auto limited = [](double value, int count) { return int(std::clamp(value, 0.0, double(count))); };
    return {limited(std::floor(low[0]), f.width), limited(std::ceil(high[0]) + 1, f.width),
            limited(std::floor(low[1]), f.height), limited(std::ceil(high[1]) + 1, f.height)};
}

bool isOnDetector(const VoxelBox& box, const ViewFootprint& f) {
    constexpr double kRounding = 1e-6;  // pixels
    const auto [low, high, behind] = reachOf(box, 0.5, f);
    const double edge = -0.5 - kRounding;
    return behind == 0 && low[0] >= edge && low[1] >= edge && high[0] <= f.width - 1 - edge &&
           high[1] <= f.height - 1 - edge;
}

int requireSeen(const ProjectionGeometry& geometry, const ColumnLattice& lattice) {
    int seen = 0;
    for (int view = 0; view < int(geometry.views.size()); ++view) {
        const PixelBox pixels = shadowOf({Index3(0), lattice.dims}, footprintOf(geometry, view, lattice));
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
