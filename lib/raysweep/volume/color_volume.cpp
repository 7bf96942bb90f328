#include "raysweep/volume/color_volume.h"

#include "raysweep/volume/active_values.h"
#include "raysweep/volume/grid_transform.h"
#include "raysweep/volume/voxels_of.h"

#include <openvdb/tools/Morphology.h>

#include <cmath>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3SGrid;

constexpr const char* kColorName = "Cd";

/// Reads colours where they are known, and what they come to beside these.
struct ColorBeyond {
    FloatGrid::ConstUnsafeAccessor density;
    Vec3SGrid::ConstUnsafeAccessor color;

    openvdb::Vec3s operator()(const Coord& at) const {
        if (density.isValueOn(at)) return color.getValue(at);
        openvdb::Vec3d sum(0.0), plain(0.0);
        double weights = 0, count = 0;
        for (const Coord& beside : openvdb::CoordBBox(at.offsetBy(-1), at.offsetBy(1))) {
            float weight = 0;
            if (!density.probeValue(beside, weight)) continue;
            const openvdb::Vec3d value(color.getValue(beside));
            sum += value * double(weight), weights += weight;
            plain += value, count += 1;
        }
        if (weights > 0) return openvdb::Vec3s(sum / weights);
        return count > 0 ? openvdb::Vec3s(plain / count) : openvdb::Vec3s(0.0f);
    }
};

}  // namespace

FloatGrid::Ptr opacityGrid(const FloatGrid& density) {
    requireLinear(density);
    const double edge = std::cbrt(density.transform().voxelVolume());
    const FloatGrid::Ptr opacity = density.deepCopy();
    forEachActive(*opacity,
                  [&](float& value, const openvdb::CoordBBox&) { value = float(-std::expm1(-value * edge)); });
    opacity->setName("opacity");
    return opacity;
}

Vec3SGrid::Ptr extendedColor(const Vec3SGrid& color, const FloatGrid& density) {
    requireSameTransform(color, density);
    const auto result = withVoxelsOf<Vec3SGrid>(density);
    openvdb::tools::dilateActiveValues(result->tree(), 1, openvdb::tools::NN_FACE_EDGE_VERTEX,
                                       openvdb::tools::IGNORE_TILES);
    setActive(*result, [&] { return ColorBeyond{density.getConstUnsafeAccessor(), color.getConstUnsafeAccessor()}; });
    result->setName(kColorName);
    return result;
}

openvdb::GridPtrVec gridsOf(const ColorVolume& volume) {
    volume.color->setName(kColorName);
    volume.color->insertMeta("raysweep_density", openvdb::StringMetadata(volume.density->getName()));
    volume.color->insertMeta("raysweep_extinction", openvdb::DoubleMetadata(1));
    openvdb::GridPtrVec grids{volume.density, opacityGrid(*volume.density), volume.color};
    for (const FloatGrid::Ptr& seen : {volume.confidence, volume.views})
        if (seen) grids.push_back(seen);
    const DirectionalColor& directional = volume.directional;
    if (directional.constant)
        grids.insert(grids.end(), {directional.constant, directional.x, directional.y, directional.z});
    return grids;
}

ColorPower powerOf(const ColorVolume& volume) {
    const FloatGrid::Ptr opacity = opacityGrid(*volume.density);
    const openvdb::Vec3STree& color = volume.color->tree();
    return sumOverActive<ColorPower>(*opacity, [&](ColorPower& sum, float alpha, const openvdb::CoordBBox& box) {
        const openvdb::Vec3d seen(color.getValue(box.min()) * alpha);
        const double voxels = double(box.volume());
        sum += {voxels * alpha * alpha, voxels * seen.lengthSqr() / 3};
    });
}

Vec3SGrid::Ptr colorGrid(const VdbFile& file) {
    for (const auto& grid : file.grids)
        if (grid->getName() == kColorName && grid->isType<Vec3SGrid>()) return openvdb::gridPtrCast<Vec3SGrid>(grid);
    return nullptr;
}

}  // namespace raysweep
