/// The one walk over a grid's active values. Grids are FloatGrid or Vec3SGrid; const ones are read, others may be
/// changed.
#pragma once

#include "raysweep/core/parallel.h"
#include "raysweep/volume/grids.h"

#include <cstddef>
#include <type_traits>
#include <vector>

namespace raysweep {

/// A leaf, which need not have active voxels, or an active tile.
template <class GridType>
struct ActiveBlock {
    template <class T>
    using LikeGrid = std::conditional_t<std::is_const<GridType>::value, const T, T>;

    openvdb::CoordBBox box;
    LikeGrid<typename GridType::TreeType::LeafNodeType>* leaf;  ///< null: a tile
    LikeGrid<typename GridType::ValueType>* tile;               ///< its value; null: a leaf

    bool isEmpty() const { return leaf && leaf->isEmpty(); }
};

/// All leaves, then all active tiles, each in the tree's order.
template <class GridType>
std::vector<ActiveBlock<GridType>> activeBlocks(GridType& grid);

extern template std::vector<ActiveBlock<openvdb::FloatGrid>> activeBlocks(openvdb::FloatGrid&);
extern template std::vector<ActiveBlock<openvdb::Vec3SGrid>> activeBlocks(openvdb::Vec3SGrid&);
extern template std::vector<ActiveBlock<const openvdb::FloatGrid>> activeBlocks(const openvdb::FloatGrid&);
extern template std::vector<ActiveBlock<const openvdb::Vec3SGrid>> activeBlocks(const openvdb::Vec3SGrid&);

/// Calls `visit(value, box)` for every active value of `block`, in order of offsets; `box` is one voxel, or the tile.
template <class GridType, class Visit>
void forEachActive(const ActiveBlock<GridType>& block, const Visit& visit) {
    if (!block.leaf) return visit(*block.tile, block.box);
    auto* const values = block.leaf->buffer().data();
    for (auto on = block.leaf->valueMask().beginOn(); on; ++on) {
        const openvdb::Coord at = block.leaf->offsetToGlobalCoord(on.pos());
        visit(values[on.pos()], openvdb::CoordBBox(at, at));
    }
}

/// The same for all of `grid`, block after block.
template <class GridType, class Visit>
void forEachActive(GridType& grid, const Visit& visit) {
    for (const auto& block : activeBlocks(grid)) forEachActive(block, visit);
}

/// Sums of the blocks, several of which are made at a time, added as orderedSum adds: the same bits for any number of
/// threads. `add(sum, value, box)` adds an active value to that of its block; `Sum` needs += and a zero default.
template <class Sum, class GridType, class Add>
Sum sumOverActive(GridType& grid, const Add& add) {
    const auto blocks = activeBlocks(grid);
    return orderedSum<Sum>(blocks.size(), [&](std::size_t i) {
        Sum sum{};
        forEachActive(blocks[i], [&](auto& value, const openvdb::CoordBBox& box) { add(sum, value, box); });
        return sum;
    });
}

/// Sets every active value to `valueAt(coordinate)`; a tile is given its low corner's. `makeValueAt()` makes one for
/// each block: what reads a grid remembers where it was, and is no use to two threads.
template <class GridType, class MakeValueAt>
void setActive(GridType& grid, const MakeValueAt& makeValueAt) {
    const auto blocks = activeBlocks(grid);
    parallelFor(blocks.size(), [&](std::size_t i) {
        auto valueAt = makeValueAt();
        forEachActive(blocks[i], [&](auto& value, const openvdb::CoordBBox& box) { value = valueAt(box.min()); });
    });
}

}  // namespace raysweep
