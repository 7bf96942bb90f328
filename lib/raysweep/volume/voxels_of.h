/// Grids with the active voxels of others.
#pragma once

#include "raysweep/volume/grids.h"

#include <memory>

namespace raysweep {

/// A grid of 0 with the active voxels of `shape`, tiles as voxels.
template <class GridType, class ShapeType>
typename GridType::Ptr withVoxelsOf(const ShapeType& shape) {
    const auto tree = std::make_shared<typename GridType::TreeType>(
        shape.tree(), openvdb::zeroVal<typename GridType::ValueType>(), openvdb::TopologyCopy());
    tree->voxelizeActiveTiles();
    const auto grid = GridType::create(tree);
    grid->setTransform(shape.transform().copy());
    return grid;
}

}  // namespace raysweep
