/// Grids made from another grid's values, voxel by voxel. For this module's own sources: they compile copies of trees.
#pragma once

#include "raysweep/volume/active_values.h"

#include <memory>

namespace raysweep {

/// A grid with the active voxels and tiles of `topology`, background 0, and the transform of `source`; its values are
/// `valueOf(value of source, coordinate)`. A tile is given its low corner's value. Not pruned.
template <class GridType, class TopologyTree, class ValueOf>
typename GridType::Ptr mappedGrid(const openvdb::FloatGrid& source, const TopologyTree& topology,
                                  const ValueOf& valueOf) {
    using Tree = typename GridType::TreeType;
    using Value = typename GridType::ValueType;
    const auto tree = std::make_shared<Tree>(topology, Value(0.0f), openvdb::TopologyCopy());
    const auto grid = GridType::create(tree);
    grid->setTransform(source.transform().copy());
    setActive(*grid, [&] {
        return [&, in = source.getConstUnsafeAccessor()](const openvdb::Coord& at) {
            return valueOf(in.getValue(at), at);
        };
    });
    return grid;
}

}  // namespace raysweep
