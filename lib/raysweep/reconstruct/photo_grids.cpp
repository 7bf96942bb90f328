#include "raysweep/reconstruct/photo_grids.h"

#include "raysweep/volume/color_volume.h"

namespace raysweep {

void addGrids(const CompositeLayout& layout, const ReconstructionGrid& grid, const VoxelAt& voxelAt,
              PhotoReconstruction& result) {
    const auto transform = grid.transform();
    const auto color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
    result.density = openvdb::FloatGrid::create(0);
    result.density->setName("density");
    result.density->setGridClass(openvdb::GRID_FOG_VOLUME);
    result.density->setTransform(transform);
    color->setTransform(transform);
    auto toDensity = result.density->getAccessor();
    auto toColor = color->getAccessor();
    for (std::size_t b = 1; b < layout.brickCount(); ++b)
        for (int i = 0; i < 512; ++i) {
            const std::optional<CompositeVoxel> voxel = voxelAt(b * 512 + std::size_t(i));
            if (!voxel) continue;
            const Index3 at = layout.origins[b] + Index3(i >> 6, i >> 3 & 7, i & 7);
            const openvdb::Coord place(at.x, at.y, at.z);
            toDensity.setValue(place, float(voxel->extinction / grid.edge()));
            toColor.setValue(place, openvdb::Vec3s(voxel->red, voxel->green, voxel->blue));
        }
    result.opacity = opacityGrid(*result.density);
    result.color = extendedColor(*color, *result.density);
}

void addDirectional(const PhotoLevel& level, const std::vector<CompositeVoxel>& constants,
                    PhotoReconstruction& result) {
    const auto gridOf = [&](const char* name, const auto& colorAt) {
        const auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
        grid->setTransform(level.grid.transform());
        auto to = grid->getAccessor();
        for (auto voxel = result.density->cbeginValueOn(); voxel; ++voxel) {
            const openvdb::Coord at = voxel.getCoord();
            to.setValue(at, openvdb::Vec3s(colorAt(level.layout.voxel(Index3(at.x(), at.y(), at.z())))));
        }
        const auto extended = extendedColor(*grid, *result.density);
        extended->setName(name);
        return extended;
    };
    result.directional.constant = gridOf("Cd_0", [&](std::size_t i) { return &constants[i].red; });
    const char* const names[] = {"Cd_x", "Cd_y", "Cd_z"};
    openvdb::Vec3SGrid::Ptr* const grids[] = {&result.directional.x, &result.directional.y, &result.directional.z};
    for (int axis = 0; axis < 3; ++axis)
        *grids[axis] = gridOf(names[axis], [&](std::size_t i) { return level.slopes[i].of[axis]; });
}

std::vector<MaskedBrick> bricksOf(const openvdb::FloatGrid& grid, const openvdb::Coord& origin) {
    std::vector<MaskedBrick> bricks;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        const openvdb::Coord low = leaf->origin() - origin;
        MaskedBrick brick{Index3(low.x(), low.y(), low.z()), {}};
        for (auto on = leaf->cbeginValueOn(); on; ++on)
            brick.mask[on.pos() >> 6] |= std::uint64_t(1) << (on.pos() & 63);
        bricks.push_back(brick);
    }
    return bricks;
}

}  // namespace raysweep
