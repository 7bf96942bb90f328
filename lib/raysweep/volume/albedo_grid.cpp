#include "raysweep/volume/albedo_grid.h"

#include "raysweep/volume/active_values.h"
#include "raysweep/volume/channels.h"
#include "raysweep/volume/grid_transform.h"
#include "raysweep/volume/voxel_check.h"
#include "raysweep/volume/voxels_of.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;

constexpr int kMostPoints = 16;  ///< along an edge of a voxel

/// Points in a voxel of the density, as offsets in index space of the albedo: one for each of its voxels, about.
std::vector<Vec3d> pointsIn(const FloatGrid& density, const openvdb::GridBase& albedo) {
    const auto inAlbedo = [&](const Vec3d& at) { return albedo.worldToIndex(density.indexToWorld(at)); };
    const Vec3d middle = inAlbedo(Vec3d(0.0));
    Vec3d edges[3];
    int count[3];
    for (int axis = 0; axis < 3; ++axis) {
        Vec3d unit(0.0);
        unit[axis] = 1;
        edges[axis] = inAlbedo(unit) - middle;
        count[axis] = int(std::clamp(std::ceil(edges[axis].length() - 1e-6), 1.0, double(kMostPoints)));
    }
    std::vector<Vec3d> points;
    for (int i = 0; i < count[0]; ++i)
        for (int j = 0; j < count[1]; ++j)
            for (int k = 0; k < count[2]; ++k)
                points.push_back(edges[0] * ((i + 0.5) / count[0] - 0.5) + edges[1] * ((j + 0.5) / count[1] - 0.5) +
                                 edges[2] * ((k + 0.5) / count[2] - 0.5));
    return points;
}

/// Mean of the active voxels around points.
template <class GridType>
class ActiveMean {
  public:
    using Value = typename GridType::ValueType;

    explicit ActiveMean(const GridType& grid) : in_(grid.getConstUnsafeAccessor()) {}

    void add(const Vec3d& at) {
        const Coord cell = Coord::floor(at);
        for (int corner = 0; corner < 8; ++corner) {
            const Coord side(corner >> 2, (corner >> 1) & 1, corner & 1);
            double weight = 1;
            for (int axis = 0; axis < 3; ++axis) {
                const double within = at[axis] - cell[axis];
                weight *= side[axis] ? within : 1 - within;
            }
            Value value;
            if (!(weight > 0) || !in_.probeValue(cell + side, value)) continue;
            weight_ += weight;
            for (int c = 0; c < kChannels<Value>; ++c) sum_[c] += weight * double(channel(value, c));
        }
    }
    Value mean() const {
        constexpr double kLeast = 1e-6;  // rounding of a point that lies on inactive voxels
        Value value = openvdb::zeroVal<Value>();
        if (weight_ > kLeast)
            for (int c = 0; c < kChannels<Value>; ++c) channel(value, c) = std::min(1.0f, float(sum_[c] / weight_));
        return value;
    }

  private:
    typename GridType::ConstUnsafeAccessor in_;
    double sum_[3] = {0, 0, 0}, weight_ = 0;
};

template <class GridType>
typename GridType::Ptr meansOf(const GridType& albedo, const FloatGrid& density) {
    const std::vector<Vec3d> points = pointsIn(density, albedo);
    const auto means = withVoxelsOf<GridType>(density);
    setActive(*means, [&] {
        return [&, empty = ActiveMean<GridType>(albedo)](const Coord& at) {
            ActiveMean<GridType> mean = empty;
            const Vec3d middle = albedo.worldToIndex(density.indexToWorld(at));
            for (const Vec3d& point : points) mean.add(middle + point);
            return mean.mean();
        };
    });
    means->setName(albedo.getName());
    return means;
}

}  // namespace

openvdb::GridBase::ConstPtr albedoOnDensity(const Medium& medium) {
    const openvdb::GridBase& albedo = *medium.albedoGrid;
    checkAlbedo(albedo);
    if (albedo.transform() == medium.density->transform()) return medium.albedoGrid;
    requireLinear(albedo);
    requireLinear(*medium.density);
    return withTypedGrid(
        albedo, [&](const auto& typed) -> openvdb::GridBase::ConstPtr { return meansOf(typed, *medium.density); });
}

}  // namespace raysweep
