/// Voxels copied to where rays find all that a step needs at one place.
#pragma once

#include "raysweep/volume/grids.h"

#include <openvdb/tree/ValueAccessor.h>

#include <cstddef>
#include <memory>

namespace raysweep {

constexpr int kBlockCells = 8;                  ///< cells along a block's side
constexpr int kBlockCorners = kBlockCells + 1;  ///< voxel centres along it
constexpr int kNoBlock = -1;

/// Blocks of 8x8x8 cells, where cell (i,j,k) lies between the voxel centres (i,j,k) and (i+1,j+1,k+1). A block holds
/// the values at all corners of its cells, 9x9x9 of them, so that interpolation never looks beyond it; several values
/// at a corner lie side by side.
struct CellBlocks {
    /// Which cells are in which block: the values of tiles of 8x8x8 are blocks' numbers, or kNoBlock. Active where
    /// there is anything at all, block or not.
    openvdb::Int32Tree::Ptr numbers;
    int channels = 0;
    std::unique_ptr<float[]> values;

    std::size_t blockSize() const { return std::size_t(channels) * kBlockCorners * kBlockCorners * kBlockCorners; }
    const float* block(int number) const { return values.get() + std::size_t(number) * blockSize(); }
};

/// Copies a grid's values to one channel or three of one block after another.
template <class GridType>
class BlockFiller {
  public:
    explicit BlockFiller(const GridType& grid) : accessor_(grid.tree()) {}

    /// @param block where the first of the grid's channels goes; there are `channels` in all
    void fill(const openvdb::Coord& origin, float* block, int channels) {
        for (int part = 0; part < 8; ++part) {
            const openvdb::Coord side(part >> 2, (part >> 1) & 1, part & 1);
            copyPart(origin.offsetBy(kBlockCells * side.x(), kBlockCells * side.y(), kBlockCells * side.z()), side,
                     block, channels);
        }
    }

  private:
    static void put(float value, float* to) { *to = value; }
    static void put(const openvdb::Vec3s& value, float* to) {
        for (int c = 0; c < 3; ++c) to[c] = value[c];
    }

    /// The corners that lie in the leaf or tile at `from`: on a `side` of 1 only those that touch.
    void copyPart(const openvdb::Coord& from, const openvdb::Coord& side, float* block, int channels) {
        const auto* const leaf = accessor_.probeConstLeaf(from);
        const auto* const values = leaf ? leaf->buffer().data() : nullptr;
        const auto tile = leaf ? typename GridType::ValueType(0.0f) : accessor_.getValue(from);
        const openvdb::Coord count(side.x() ? 1 : kBlockCells, side.y() ? 1 : kBlockCells, side.z() ? 1 : kBlockCells);
        for (int x = 0; x < count.x(); ++x)
            for (int y = 0; y < count.y(); ++y)
                for (int z = 0; z < count.z(); ++z) {
                    const int corner =
                        ((x + kBlockCells * side.x()) * kBlockCorners + y + kBlockCells * side.y()) * kBlockCorners +
                        z + kBlockCells * side.z();
                    put(values ? values[x << 6 | y << 3 | z] : tile, block + channels * corner);
                }
    }

    // Not registered with the tree: nobody changes it while it is copied.
    openvdb::tree::ValueAccessor<const typename GridType::TreeType, false> accessor_;
};

/// Blocks of one grid, one channel or three, in the cells of tiles of 8x8x8 that are active in `occupied` (see
/// occupancy). Larger tiles stay without blocks: memory is proportional to the voxels of the tree.
/// @throw InvalidArgument if they need more memory than there is
CellBlocks makeBlocks(const openvdb::Int32Tree::Ptr& occupied, const openvdb::FloatGrid& grid);
CellBlocks makeBlocks(const openvdb::Int32Tree::Ptr& occupied, const openvdb::Vec3SGrid& grid);

/// Blocks of density and radiosity, which share their voxels: two channels or four. There is also one for each leaf of
/// `radiosity` that lies where `occupied` is active.
CellBlocks makeBlocks(const openvdb::Int32Tree::Ptr& occupied, const openvdb::FloatGrid& density,
                      const openvdb::FloatGrid& radiosity);
CellBlocks makeBlocks(const openvdb::Int32Tree::Ptr& occupied, const openvdb::FloatGrid& density,
                      const openvdb::Vec3SGrid& radiosity);

}  // namespace raysweep
