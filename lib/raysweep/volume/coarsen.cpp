#include "raysweep/volume/coarsen.h"

#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/grid_transform.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;
using openvdb::Vec3s;
using LeafMask = openvdb::FloatTree::LeafNodeType::NodeMaskType;
constexpr int kLeafEdge = int(openvdb::FloatTree::LeafNodeType::DIM);
constexpr int kLeafVoxels = kLeafEdge * kLeafEdge * kLeafEdge;

// Sums of many voxels are made in double precision.
double inDouble(float v) {
    return double(v);
}
Vec3d inDouble(const Vec3s& v) {
    return {double(v[0]), double(v[1]), double(v[2])};
}

void requireArguments(const openvdb::GridBase& grid, double resolution) {
    requireField(resolution > 0 && resolution <= 1, "resolution", resolution, "in (0, 1]");
    requireLinear(grid);
}

/// Where the low face of fine voxel i lies, counted in coarse voxels from the low face of coarse voxel 0. Faces that
/// coincide but for rounding are made to: a sliver between them would be an active voxel with next to nothing in it.
double faceOf(int i, double resolution) {
    const double face = i * resolution, whole = std::round(face);
    return std::abs(face - whole) <= 1e-12 * (1 + std::abs(face)) ? whole : face;
}

/// Fine voxels in a line, seen from the coarse ones.
struct Span {
    int first, last;   ///< coarse voxels it overlaps
    double low, high;  ///< where its ends lie, in coarse voxels

    Span(int from, int to, double resolution) : low(faceOf(from, resolution)), high(faceOf(to + 1, resolution)) {
        first = int(std::floor(low));
        last = std::max(first, int(std::ceil(high)) - 1);
    }
    /// Part of coarse voxel c that it covers.
    double share(int c) const { return std::max(0.0, std::min(high, c + 1.0) - std::max(low, double(c))); }
};

template <class GridType>
using Block = ActiveBlock<const GridType>;

/// Fine block `block` overlaps the coarse leaf at `leaf`.
struct Meeting {
    Coord leaf;
    std::size_t block;
    bool operator<(const Meeting& o) const { return leaf == o.leaf ? block < o.block : leaf < o.leaf; }
};

/// Origins of the coarse leaves that a box of fine voxels overlaps: the first and the last.
CoordBBox leavesAt(const CoordBBox& box, double resolution) {
    CoordBBox leaves;
    for (int axis = 0; axis < 3; ++axis) {
        const Span span(box.min()[axis], box.max()[axis], resolution);
        leaves.min()[axis] = span.first & ~(kLeafEdge - 1);
        leaves.max()[axis] = span.last & ~(kLeafEdge - 1);
    }
    return leaves;
}

double countOf(const CoordBBox& leaves) {
    double count = 1;
    for (int axis = 0; axis < 3; ++axis) count *= (double(leaves.max()[axis]) - leaves.min()[axis]) / kLeafEdge + 1;
    return count;
}

/// All of them, by leaf, and for one leaf by block: sums have the same bits whatever the number of threads.
template <class GridType>
std::vector<Meeting> meetings(const std::vector<Block<GridType>>& blocks, double resolution) {
    double ofTiles = 0;  // few tiles can stand for more voxels than the machine can hold
    for (const auto& block : blocks)
        if (block.tile) ofTiles += countOf(leavesAt(block.box, resolution));
    requireMemory(ofTiles, sizeof(typename GridType::ValueType));
    std::vector<Meeting> all;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        if (blocks[b].isEmpty()) continue;
        const CoordBBox leaves = leavesAt(blocks[b].box, resolution);
        for (int x = leaves.min().x(); x <= leaves.max().x(); x += kLeafEdge)
            for (int y = leaves.min().y(); y <= leaves.max().y(); y += kLeafEdge)
                for (int z = leaves.min().z(); z <= leaves.max().z(); z += kLeafEdge)
                    all.push_back({Coord(x, y, z), b});
    }
    std::sort(all.begin(), all.end());
    return all;
}

/// What fine voxels add to the voxels of one coarse leaf.
template <class GridType>
class LeafSums {
  public:
    using Leaf = typename GridType::TreeType::LeafNodeType;

    LeafSums(const Coord& origin, double resolution) : origin_(origin), resolution_(resolution) {}

    void add(const Block<GridType>& block) {
        const Coord low = block.box.min(), high = block.box.max();
        if (block.tile)
            return addBox(spanOf(0, low.x(), high.x()), spanOf(1, low.y(), high.y()), spanOf(2, low.z(), high.z()),
                          *block.tile);
        std::vector<Span> spans;  // of each of the leaf's voxels, along x, then y, then z
        for (int axis = 0; axis < 3; ++axis)
            for (int i = low[axis]; i <= high[axis]; ++i) spans.push_back(spanOf(axis, i, i));
        forEachActive(block, [&](const auto& value, const CoordBBox& box) {
            const Coord in = box.min() - low;
            addBox(spans[in.x()], spans[kLeafEdge + in.y()], spans[2 * kLeafEdge + in.z()], value);
        });
    }

    /// Null if nothing overlaps it.
    Leaf* toLeaf() const {
        if (active_.isOff()) return nullptr;
        using Value = typename GridType::ValueType;
        auto* const leaf = new Leaf(origin_, openvdb::zeroVal<Value>());
        for (auto on = active_.beginOn(); on; ++on) leaf->setValueOn(on.pos(), Value(sums_[on.pos()]));
        return leaf;
    }

  private:
    /// Adds a box of fine voxels of one value.
    void addBox(const Span& x, const Span& y, const Span& z, const typename GridType::ValueType& value) {
        for (int i = x.first; i <= x.last; ++i)
            for (int j = y.first; j <= y.last; ++j)
                for (int k = z.first; k <= z.last; ++k) {
                    const openvdb::Index offset = Leaf::coordToOffset(Coord(i, j, k));
                    sums_[offset] += inDouble(value) * (x.share(i) * y.share(j) * z.share(k));
                    active_.setOn(offset);
                }
    }

    /// Fine voxels along an axis, no further than this leaf reaches.
    Span spanOf(int axis, int from, int to) const {
        Span span(from, to, resolution_);
        span.first = std::max(span.first, origin_[axis]);
        span.last = std::min(span.last, origin_[axis] + kLeafEdge - 1);
        return span;
    }

    Coord origin_;
    double resolution_;
    decltype(inDouble(typename GridType::ValueType())) sums_[kLeafVoxels] = {};
    LeafMask active_;
};

/// The coarse leaf at `meeting.leaf` lies in a single tile: it becomes one too.
template <class GridType>
bool isInTile(const Meeting& meeting, const Block<GridType>& block, double resolution) {
    if (!block.tile) return false;
    for (int axis = 0; axis < 3; ++axis) {
        const Span span(block.box.min()[axis], block.box.max()[axis], resolution);
        if (span.low > meeting.leaf[axis] || span.high < meeting.leaf[axis] + kLeafEdge) return false;
    }
    return true;
}

/// x_fine = x_coarse / resolution + (1 / resolution - 1) / 2 along each axis, since voxels reach half a unit around
/// their coordinates.
openvdb::math::Transform::Ptr coarseTransform(const openvdb::math::Transform& fine, double resolution) {
    const openvdb::math::Transform::Ptr coarse = fine.copy();
    coarse->preTranslate(Vec3d((1 / resolution - 1) / 2));
    coarse->preScale(1 / resolution);
    return coarse;
}

template <class GridType>
openvdb::GridBase::Ptr coarsenedGrid(const GridType& fine, double resolution) {
    const std::vector<Block<GridType>> blocks = activeBlocks(fine);
    const std::vector<Meeting> all = meetings(blocks, resolution);
    std::vector<std::size_t> starts;  // of the coarse leaves, in `all`
    for (std::size_t m = 0; m < all.size(); ++m)
        if (m == 0 || all[m].leaf != all[m - 1].leaf) starts.push_back(m);
    const std::size_t count = starts.size();
    starts.push_back(all.size());

    std::vector<typename GridType::TreeType::LeafNodeType*> leaves(count, nullptr);
    parallelFor(count, [&](std::size_t i) {
        if (isInTile(all[starts[i]], blocks[all[starts[i]].block], resolution)) return;
        LeafSums<GridType> sums(all[starts[i]].leaf, resolution);
        for (std::size_t m = starts[i]; m < starts[i + 1]; ++m) sums.add(blocks[all[m].block]);
        leaves[i] = sums.toLeaf();
    });

    const auto coarse = GridType::create();
    for (std::size_t i = 0; i < count; ++i) {
        const Meeting& first = all[starts[i]];
        if (leaves[i])
            coarse->tree().addLeaf(leaves[i]);
        else if (isInTile(first, blocks[first.block], resolution))
            coarse->tree().addTile(1, first.leaf, *blocks[first.block].tile, true);
    }
    coarse->setTransform(coarseTransform(fine.transform(), resolution));
    coarse->setName(fine.getName());
    coarse->setGridClass(fine.getGridClass());
    return coarse;
}

}  // namespace

openvdb::GridBase::Ptr coarsened(const openvdb::GridBase& grid, double resolution) {
    requireArguments(grid, resolution);
    return withTypedGrid(grid,
                         [&](const auto& typed) -> openvdb::GridBase::Ptr { return coarsenedGrid(typed, resolution); });
}

}  // namespace raysweep
