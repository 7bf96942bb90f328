#include "raysweep/render/cell_blocks.h"

#include "raysweep/bricks/brick_grids.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"
#include "raysweep/volume/channels.h"

#include <algorithm>
#include <vector>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Int32Tree;
using openvdb::Vec3SGrid;

/// Gives every tile of 8x8x8 a number. @return their low corners
std::vector<Coord> numberTiles(Int32Tree& tree) {
    std::vector<Coord> origins;
    for (auto tile = tree.beginValueOn(); tile; ++tile) {
        if (tile.getLevel() != 1) continue;
        tile.setValue(int(origins.size()));
        origins.push_back(tile.getCoord());
    }
    return origins;
}

/// Splits larger active tiles where `grid` has leaves.
template <class GridType>
void splitAtLeaves(Int32Tree& tree, const GridType& grid) {
    openvdb::tree::ValueAccessor<Int32Tree, false> accessor(tree);
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        if (accessor.isValueOn(leaf->origin())) accessor.addTile(1, leaf->origin(), kNoBlock, true);
}

/// Numbers the blocks and fills them: `fillBlocks(origins, first, end, blocks)` a few at a time.
template <class FillBlocks>
CellBlocks makeBlocks(const Int32Tree::Ptr& tree, int channels, const FillBlocks& fillBlocks) {
    CellBlocks blocks;
    blocks.numbers = tree;
    blocks.channels = channels;
    const std::vector<Coord> origins = numberTiles(*tree);
    requireMemory(double(origins.size()), blocks.blockSize() * sizeof(float) / kBrickVoxels);
    blocks.values.reset(new float[origins.size() * blocks.blockSize()]);  // not set to 0 first, as a vector would be
    constexpr std::size_t kGroup = 16;
    parallelFor((origins.size() + kGroup - 1) / kGroup, [&](std::size_t group) {
        fillBlocks(origins, group * kGroup, std::min(origins.size(), (group + 1) * kGroup), blocks.values.get());
    });
    return blocks;
}

template <class GridType>
CellBlocks makeSharedBlocks(const Int32Tree::Ptr& occupied, const FloatGrid& density, const GridType& radiosity,
                            int channels) {
    splitAtLeaves(*occupied, radiosity);
    return makeBlocks(
        occupied, channels, [&](const std::vector<Coord>& origins, std::size_t first, std::size_t end, float* values) {
            BlockFiller<FloatGrid> densities(density);
            BlockFiller<GridType> radiosities(radiosity);
            const std::size_t size = std::size_t(channels) * kBlockCorners * kBlockCorners * kBlockCorners;
            for (std::size_t b = first; b < end; ++b) {
                densities.fill(origins[b], values + b * size, channels);
                radiosities.fill(origins[b], values + b * size + 1, channels);
            }
        });
}

template <class GridType>
CellBlocks makeOwnBlocks(const Int32Tree::Ptr& occupied, const GridType& grid) {
    constexpr int kCount = kChannels<typename GridType::ValueType>;
    constexpr std::size_t kSize = std::size_t(kCount) * kBlockCorners * kBlockCorners * kBlockCorners;
    return makeBlocks(occupied, kCount,
                      [&](const std::vector<Coord>& origins, std::size_t first, std::size_t end, float* values) {
                          BlockFiller<GridType> filler(grid);
                          for (std::size_t b = first; b < end; ++b) filler.fill(origins[b], values + b * kSize, kCount);
                      });
}

}  // namespace

CellBlocks makeBlocks(const Int32Tree::Ptr& occupied, const FloatGrid& grid) {
    return makeOwnBlocks(occupied, grid);
}

CellBlocks makeBlocks(const Int32Tree::Ptr& occupied, const Vec3SGrid& grid) {
    return makeOwnBlocks(occupied, grid);
}

CellBlocks makeBlocks(const Int32Tree::Ptr& occupied, const FloatGrid& density, const FloatGrid& radiosity) {
    return makeSharedBlocks(occupied, density, radiosity, 2);
}

CellBlocks makeBlocks(const Int32Tree::Ptr& occupied, const FloatGrid& density, const Vec3SGrid& radiosity) {
    return makeSharedBlocks(occupied, density, radiosity, 4);
}

}  // namespace raysweep
