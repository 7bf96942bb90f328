#include "raysweep/volume/checksum.h"

#include "raysweep/volume/active_values.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <vector>

namespace raysweep {
namespace {

using openvdb::Coord;
using Leaf = openvdb::FloatTree::LeafNodeType;

class Fnv1a {
  public:
    /// The four bytes of `word`, the lowest first.
    void add(std::uint32_t word) {
        constexpr std::uint64_t kPrime = 0x100000001b3;
        for (int byte = 0; byte < 4; ++byte) hash_ = (hash_ ^ ((word >> (8 * byte)) & 0xff)) * kPrime;
    }
    std::uint64_t value() const { return hash_; }

  private:
    std::uint64_t hash_ = 0xcbf29ce484222325;
};

/// 8x8x8 voxels: a leaf, or part of a tile.
struct Block {
    Coord origin;
    const Leaf* leaf;  ///< null: all voxels are `tile`
    float tile;
};

/// In the order of their origins.
std::vector<Block> blocksOf(const openvdb::FloatGrid& grid) {
    constexpr int kEdge = int(Leaf::DIM);
    std::vector<Block> blocks;
    for (const auto& active : activeBlocks(grid)) {
        const Coord low = active.box.min(), high = active.box.max();
        for (int x = low.x(); x <= high.x(); x += kEdge)
            for (int y = low.y(); y <= high.y(); y += kEdge)
                for (int z = low.z(); z <= high.z(); z += kEdge)
                    blocks.push_back({Coord(x, y, z), active.leaf, active.leaf ? 0 : *active.tile});
    }
    std::sort(blocks.begin(), blocks.end(), [](const Block& a, const Block& b) { return a.origin < b.origin; });
    return blocks;
}

/// Adds the active voxels of row (x, y) of a block.
void addRow(Fnv1a& hash, const Block& block, int x, int y) {
    for (int z = 0; z < int(Leaf::DIM); ++z) {
        const Coord at = block.origin.offsetBy(x, y, z);
        const openvdb::Index offset = Leaf::coordToOffset(at);
        if (block.leaf && !block.leaf->isValueOn(offset)) continue;
        const float value = block.leaf ? block.leaf->getValue(offset) : block.tile;
        std::uint32_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        for (int axis = 0; axis < 3; ++axis) hash.add(std::uint32_t(at[axis]));
        hash.add(bits);
    }
}

using BlockIterator = std::vector<Block>::const_iterator;

/// The end of those that begin at one coordinate along `axis`.
BlockIterator endOfRun(BlockIterator first, BlockIterator last, int axis) {
    return std::find_if(first, last, [&](const Block& block) { return block.origin[axis] != first->origin[axis]; });
}

/// Adds the voxels of a layer of blocks, slice by slice.
void addLayer(Fnv1a& hash, BlockIterator first, BlockIterator last) {
    for (int x = 0; x < int(Leaf::DIM); ++x)
        for (BlockIterator row = first, rowEnd; row != last; row = rowEnd) {
            rowEnd = endOfRun(row, last, 1);
            for (int y = 0; y < int(Leaf::DIM); ++y)
                for (BlockIterator block = row; block != rowEnd; ++block) addRow(hash, *block, x, y);
        }
}

}  // namespace

std::string checksum(const openvdb::FloatGrid& grid) {
    const std::vector<Block> blocks = blocksOf(grid);
    Fnv1a hash;
    for (BlockIterator layer = blocks.begin(), layerEnd; layer != blocks.end(); layer = layerEnd) {
        layerEnd = endOfRun(layer, blocks.end(), 0);
        addLayer(hash, layer, layerEnd);
    }
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash.value()));
    return digits;
}

}  // namespace raysweep
