#include "raysweep/render/occupancy.h"

#include "raysweep/core/parallel.h"
#include "raysweep/render/cell_blocks.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3SGrid;
template <class GridType>
using LeafOf = typename GridType::TreeType::LeafNodeType;
template <class GridType>
const typename GridType::ValueType kZero = openvdb::zeroVal<typename GridType::ValueType>();
using Accessor = openvdb::tree::ValueAccessor<openvdb::Int32Tree, false>;  // not registered: the tree is its own

constexpr int kBlock = 8;  // voxels along a leaf's side

/// What a leaf holds: anything at all, and anything in its faces x = 0, y = 0, z = 0. A voxel there reaches into the
/// cells before it, which lie in the neighbouring leaf.
enum LeafContent : std::uint8_t { kAny = 8, kFaceX = 4, kFaceY = 2, kFaceZ = 1 };

template <class GridType>
std::uint8_t content(const LeafOf<GridType>& leaf) {
    std::uint8_t result = 0;
    for (auto value = leaf.cbeginValueOn(); value; ++value) {
        if (*value == kZero<GridType>) continue;
        const auto offset = value.pos();  // x<<6 | y<<3 | z
        result |= kAny;
        if ((offset >> 6) == 0) result |= kFaceX;
        if (((offset >> 3) & 7) == 0) result |= kFaceY;
        if ((offset & 7) == 0) result |= kFaceZ;
    }
    return result;
}

void markBlock(Accessor& marks, const Coord& origin) {
    if (!marks.isValueOn(origin)) marks.addTile(1, origin, kNoBlock, true);
}

void markLeaf(Accessor& marks, const Coord& origin, std::uint8_t held) {
    if (!(held & kAny)) return;
    for (int faces = 0; faces < 8; ++faces)
        if ((held & faces) == faces)
            markBlock(marks, origin.offsetBy(faces & kFaceX ? -kBlock : 0, faces & kFaceY ? -kBlock : 0,
                                             faces & kFaceZ ? -kBlock : 0));
}

/// Marks the box [min,max] with tiles of `level`, whose side is `side`; min must be a multiple of it.
void markBox(Accessor& marks, const CoordBBox& box, int level, int side) {
    for (int x = box.min().x(); x <= box.max().x(); x += side)
        for (int y = box.min().y(); y <= box.max().y(); y += side)
            for (int z = box.min().z(); z <= box.max().z(); z += side) {
                if (level == 1)
                    markBlock(marks, Coord(x, y, z));
                else
                    marks.addTile(level, Coord(x, y, z), kNoBlock, true);
            }
}

/// Marks a tile and the cells before it. These are marked in tiles one level smaller than the tile itself, so that a
/// huge tile does not need millions of small blocks.
void markTile(Accessor& marks, const CoordBBox& tile, int level) {
    marks.addTile(level, tile.min(), kNoBlock, true);
    const int shellLevel = level > 1 ? level - 1 : 1;
    const int side = shellLevel == 1 ? kBlock : 128;
    const Coord low = tile.min().offsetBy(-side), high = tile.max(), first = tile.min();
    markBox(marks, {low, Coord(first.x() - 1, high.y(), high.z())}, shellLevel, side);
    markBox(marks, {Coord(first.x(), low.y(), low.z()), Coord(high.x(), first.y() - 1, high.z())}, shellLevel, side);
    markBox(marks, {Coord(first.x(), first.y(), low.z()), Coord(high.x(), high.y(), first.z() - 1)}, shellLevel, side);
}

template <class GridType>
void markTiles(Accessor& marks, const GridType& density) {
    auto tile = density.tree().cbeginValueOn();
    tile.setMaxDepth(GridType::TreeType::ValueOnCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
        CoordBBox box;
        tile.getBoundingBox(box);
        if (*tile != kZero<GridType>) markTile(marks, box, int(tile.getLevel()));
    }
}

template <class GridType>
bool isZeroWhereInactive(const GridType& density, const std::vector<const LeafOf<GridType>*>& leaves) {
    if (density.background() != kZero<GridType>) return false;
    auto tile = density.tree().cbeginValueOff();
    tile.setMaxDepth(GridType::TreeType::ValueOffCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile)
        if (*tile != kZero<GridType>) return false;
    std::atomic<bool> zero{true};
    parallelFor(leaves.size(), [&](std::size_t i) {
        for (auto value = leaves[i]->cbeginValueOff(); value; ++value)
            if (*value != kZero<GridType>) zero = false;
    });
    return zero;
}

template <class GridType>
std::vector<const LeafOf<GridType>*> leavesOf(const GridType& density) {
    std::vector<const LeafOf<GridType>*> leaves;
    density.tree().getNodes(leaves);
    return leaves;
}

template <class GridType>
openvdb::Int32Tree::Ptr occupancyOf(const GridType& density) {
    const auto leaves = leavesOf(density);
    std::vector<std::uint8_t> held(leaves.size());
    parallelFor(leaves.size(), [&](std::size_t i) { held[i] = content<GridType>(*leaves[i]); });

    auto tree = std::make_shared<openvdb::Int32Tree>(kNoBlock);
    Accessor marks(*tree);
    markTiles(marks, density);
    for (std::size_t i = 0; i < leaves.size(); ++i) markLeaf(marks, leaves[i]->origin(), held[i]);
    return tree;
}

template <class GridType>
typename GridType::ConstPtr cleared(const typename GridType::ConstPtr& density) {
    if (isZeroWhereInactive(*density, leavesOf(*density))) return density;
    const typename GridType::Ptr copy = density->deepCopy();
    for (auto value = copy->beginValueOff(); value; ++value) value.setValue(kZero<GridType>);
    copy->tree().root().setBackground(kZero<GridType>, /*updateChildNodes=*/false);
    return copy;
}

}  // namespace

openvdb::Int32Tree::Ptr occupancy(const FloatGrid& density) {
    return occupancyOf(density);
}

openvdb::Int32Tree::Ptr occupancy(const Vec3SGrid& emission) {
    return occupancyOf(emission);
}

FloatGrid::ConstPtr zeroWhereInactive(const FloatGrid::ConstPtr& density) {
    return cleared<FloatGrid>(density);
}

Vec3SGrid::ConstPtr zeroWhereInactive(const Vec3SGrid::ConstPtr& emission) {
    return cleared<Vec3SGrid>(emission);
}

}  // namespace raysweep
