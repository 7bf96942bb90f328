#include "raysweep/illuminate/quad.h"

#include "raysweep/core/error.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

constexpr int kSamplesPerVoxel = 4;  ///< along each edge
constexpr double kMostVoxels = 1e7;

openvdb::Vec3d vdbVector(const Vec3& v) {
    return {v.x, v.y, v.z};
}

}  // namespace

openvdb::FloatGrid::Ptr rasterizeQuad(const QuadLight& quad, const openvdb::math::Transform& transform) {
    const auto inIndex = [&](const Vec3& at) { return transform.worldToIndex(vdbVector(at)); };
    const openvdb::Vec3d corner = inIndex(quad.corner);
    const openvdb::Vec3d u = inIndex(quad.corner + quad.u) - corner, v = inIndex(quad.corner + quad.v) - corner;
    if (std::max(1.0, u.length()) * std::max(1.0, v.length()) > kMostVoxels)
        throw InvalidArgument("a quad light covers more than 1e7 voxels; is it in the units of the volume?");
    const auto count = [](double voxels) { return std::max(1, int(std::ceil(voxels * kSamplesPerVoxel))); };
    const int countU = count(u.length()), countV = count(v.length());
    // A quad exactly between two layers of voxels takes the one that it shines into, and not, by rounding, some of
    // both.
    const bool mirrored = transform.baseMap()->determinant() < 0;
    const openvdb::Vec3d ahead = u.cross(v).unit() * (mirrored ? -1e-4 : 1e-4);
    const double area = quad.u.cross(quad.v).length() / (double(countU) * double(countV));
    auto grid = openvdb::FloatGrid::create(0);
    grid->setTransform(transform.copy());
    auto accessor = grid->getAccessor();
    for (int i = 0; i < countU; ++i)
        for (int j = 0; j < countV; ++j) {
            const openvdb::Vec3d at = corner + ahead + u * ((i + 0.5) / countU) + v * ((j + 0.5) / countV);
            const openvdb::Coord voxel = openvdb::Coord::round(at);
            accessor.setValue(voxel, accessor.getValue(voxel) + float(area));
        }
    return grid;
}

}  // namespace raysweep
