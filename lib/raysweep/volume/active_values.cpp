#include "raysweep/volume/active_values.h"

namespace raysweep {

template <class GridType>
std::vector<ActiveBlock<GridType>> activeBlocks(GridType& grid) {
    using Block = ActiveBlock<GridType>;
    using Value = std::remove_pointer_t<decltype(Block::tile)>;
    std::vector<decltype(Block::leaf)> leaves;
    leaves.reserve(grid.tree().leafCount());
    grid.tree().getNodes(leaves);
    std::vector<Block> blocks(leaves.size());
    parallelFor(
        blocks.size(),
        [&](std::size_t i) {
            blocks[i] = {leaves[i]->getNodeBoundingBox(), leaves[i], nullptr};
        },
        1024);
    auto tile = grid.tree().cbeginValueOn();
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    // Iterators that may change values give no address; the tile itself is as const as the grid.
    for (; tile; ++tile) blocks.push_back({tile.getBoundingBox(), nullptr, const_cast<Value*>(&*tile)});
    return blocks;
}

template std::vector<ActiveBlock<openvdb::FloatGrid>> activeBlocks(openvdb::FloatGrid&);
template std::vector<ActiveBlock<openvdb::Vec3SGrid>> activeBlocks(openvdb::Vec3SGrid&);
template std::vector<ActiveBlock<const openvdb::FloatGrid>> activeBlocks(const openvdb::FloatGrid&);
template std::vector<ActiveBlock<const openvdb::Vec3SGrid>> activeBlocks(const openvdb::Vec3SGrid&);

}  // namespace raysweep
