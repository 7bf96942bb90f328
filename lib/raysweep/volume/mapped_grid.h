/// Grids made from another grid's values, voxel by voxel. For this module's own sources: it instantiates trees.
#pragma once

#include "raysweep/volume/grids.h"

#include <openvdb/tree/LeafManager.h>

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
    openvdb::tree::LeafManager<Tree>(*tree).foreach ([&](auto& leaf, std::size_t) {
        const auto* const from = source.tree().probeConstLeaf(leaf.origin());
        const float tile = from ? 0 : source.tree().getValue(leaf.origin());
        for (auto on = leaf.beginValueOn(); on; ++on)
            on.setValue(valueOf(from ? from->getValue(on.pos()) : tile, on.getCoord()));
    });
    auto tile = tree->beginValueOn();
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    for (; tile; ++tile) tile.setValue(valueOf(source.tree().getValue(tile.getCoord()), tile.getCoord()));
    const auto grid = GridType::create(tree);
    grid->setTransform(source.transform().copy());
    return grid;
}

}  // namespace raysweep
