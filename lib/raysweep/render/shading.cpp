#include "raysweep/render/shading.h"

#include "raysweep/core/finite.h"
#include "raysweep/core/require.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/grid_transform.h"
#include "raysweep/volume/voxel_check.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3SGrid;

/// Slopes below this part of the opacity are rounding.
constexpr double kFlat = 1e-6;

/// Normal at a voxel; one for each thread.
struct NormalAt {
    FloatGrid::ConstUnsafeAccessor density;
    openvdb::Mat4d indexFromWorld;
    double depth;  ///< optical depth of a voxel edge at density 1

    double opacity(const Coord& at) const {
        float value = 0;
        return density.probeValue(at, value) ? -std::expm1(-depth * value) : 0.0;
    }

    openvdb::Vec3s operator()(const Coord& at) const {
        Vec3d slope;  // along the axes of index space, per voxel
        for (int axis = 0; axis < 3; ++axis) {
            Coord ahead = at, behind = at;
            ++ahead[axis], --behind[axis];
            slope[axis] = 0.5 * (opacity(ahead) - opacity(behind));
        }
        if (!(slope.length() > kFlat * opacity(at))) return openvdb::Vec3s(0.0f);
        // grad_world_j = sum_i d index_i / d world_j slope_i; OpenVDB's matrices stand to the right of row vectors.
        const openvdb::Mat4d& m = indexFromWorld;
        Vec3d gradient;
        for (int j = 0; j < 3; ++j) gradient[j] = m[j][0] * slope[0] + m[j][1] * slope[1] + m[j][2] * slope[2];
        const double length = gradient.length();
        return length > 0 ? openvdb::Vec3s(gradient / -length) : openvdb::Vec3s(0.0f);
    }
};

template <class ShapeGrid>
Vec3SGrid::Ptr normalsOf(const ShapeGrid& shape, const NormalAt& normal) {
    const auto tree = std::make_shared<openvdb::Vec3STree>(shape.tree(), openvdb::Vec3s(0.0f), openvdb::TopologyCopy());
    tree->voxelizeActiveTiles();
    const auto normals = Vec3SGrid::create(tree);
    normals->setTransform(shape.transform().copy());
    setActive(*normals, [&] { return normal; });
    return normals;
}

template <class ColorGrid>
typename ColorGrid::Ptr shadedGrid(const ColorGrid& color, const Vec3SGrid& normals, const Shading& shading) {
    const Vec3 light = unitVector(shading.light);
    const openvdb::Vec3s toLight(float(-light.x), float(-light.y), float(-light.z));
    const auto ambient = float(shading.ambient), diffuse = float(shading.diffuse);
    const auto result = color.deepCopy();
    voxelizeTiles(*result);
    setActive(*result, [&] {
        return [=, inColor = color.getConstUnsafeAccessor(),
                inNormals = normals.getConstUnsafeAccessor()](const Coord& at) {
            const openvdb::Vec3s normal = inNormals.getValue(at);
            const float facing = normal.isZero() ? 1 : std::max(0.0f, normal.dot(toLight));
            return typename ColorGrid::ValueType(inColor.getValue(at) * (ambient + diffuse * facing));
        };
    });
    return result;
}

}  // namespace

void Shading::validate() const {
    requireField(ambient >= 0 && ambient <= 1, "ambient", ambient, "in [0,1]");
    requireField(diffuse >= 0 && diffuse <= 1, "diffuse", diffuse, "in [0,1]");
    requireField(ambient + diffuse <= 1 + 1e-9, "ambient and diffuse together", ambient + diffuse, "at most 1");
    requireField(isDirection(light), "light", light, "finite and not zero");
}

Vec3SGrid::Ptr surfaceNormals(const FloatGrid& density, double extinctionScale, const openvdb::GridBase& shape) {
    requireLinear(density);
    requireSameTransform(shape, density);
    const NormalAt normal{density.getConstUnsafeAccessor(),
                          density.transform().baseMap()->getAffineMap()->getMat4().inverse(),
                          extinctionScale * std::cbrt(density.transform().voxelVolume())};
    return withTypedGrid(shape, [&](const auto& typed) { return normalsOf(typed, normal); });
}

openvdb::GridBase::Ptr shaded(const openvdb::GridBase& color, const Vec3SGrid& normals, const Shading& shading) {
    shading.validate();
    return withTypedGrid(
        color, [&](const auto& typed) -> openvdb::GridBase::Ptr { return shadedGrid(typed, normals, shading); });
}

}  // namespace raysweep
