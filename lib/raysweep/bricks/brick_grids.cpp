#include "raysweep/bricks/brick_grids.h"

#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/channels.h"
#include "raysweep/volume/grid_transform.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

// Of the bounding box, voxels: so far coordinates of rays and bricks are safe from overflow.
constexpr std::int64_t kLongestEdge = 1 << 24;

openvdb::Coord coordOf(const Index3& i) {
    return {i.x, i.y, i.z};
}

std::size_t brickCountOf(const openvdb::CoordBBox& box) {
    const openvdb::Coord size = box.dim();
    return (std::size_t(size.x()) / kBrickEdge) * (std::size_t(size.y()) / kBrickEdge) *
           (std::size_t(size.z()) / kBrickEdge);
}

void addBricks(const openvdb::CoordBBox& box, std::vector<Index3>& origins) {
    for (int x = box.min().x(); x <= box.max().x(); x += kBrickEdge)
        for (int y = box.min().y(); y <= box.max().y(); y += kBrickEdge)
            for (int z = box.min().z(); z <= box.max().z(); z += kBrickEdge) origins.emplace_back(x, y, z);
}

/// Adds the bricks of every leaf with active voxels and of every active tile.
template <class GridType>
void addActiveBricks(const GridType& grid, std::size_t bytesPerVoxel, std::vector<Index3>& origins) {
    const auto blocks = activeBlocks(grid);
    std::size_t bricks = 0;
    for (const auto& block : blocks)
        if (!block.isEmpty()) bricks += brickCountOf(block.box);
    requireMemory(double(bricks), bytesPerVoxel);
    origins.reserve(origins.size() + bricks);
    for (const auto& block : blocks)
        if (!block.isEmpty()) addBricks(block.box, origins);
}

/// Sets the bounding box of bricks that are not none.
void setBounds(BrickLayout& layout) {
    layout.low = layout.high = layout.origins.front();
    for (const Index3& origin : layout.origins)
        for (int axis = 0; axis < 3; ++axis) {
            layout.low[axis] = std::min(layout.low[axis], origin[axis]);
            layout.high[axis] = std::max(layout.high[axis], origin[axis] + kBrickEdge);
        }
    for (int axis = 0; axis < 3; ++axis)
        if (std::int64_t(layout.high[axis]) - layout.low[axis] > kLongestEdge)
            throw InvalidArgument("the volume's active voxels are more than " + std::to_string(kLongestEdge) +
                                  " voxels apart; remove stray voxels or use a coarser grid");
}

Matrix3 linearPart(const openvdb::GridBase& grid) {
    requireLinear(grid);
    const openvdb::Mat4R m = grid.transform().baseMap()->getAffineMap()->getMat4();
    Matrix3 linear;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) linear[row][column] = m(row, column);
    const auto edge = [&](int i) { return Vec3(linear[i][0], linear[i][1], linear[i][2]).length(); };
    const double longest = std::max({edge(0), edge(1), edge(2)});
    if (!(std::abs(linear.determinant()) > 1e-9 * longest * longest * longest))
        throw InvalidArgument("grid '" + grid.getName() + "' has a singular transform: its voxels have no volume");
    return linear;
}

/// Reads the voxels of one brick after another, with a cached path to the last one.
template <class GridType>
class BrickReader {
  public:
    explicit BrickReader(const GridType& grid) : accessor_(grid.tree()) {}

    /// Calls `put(offset, value)` for each active voxel.
    template <class Put>
    void read(const Index3& origin, const Put& put) {
        const openvdb::Coord corner = coordOf(origin);
        if (const auto* leaf = accessor_.probeConstLeaf(corner)) {
            for (auto value = leaf->cbeginValueOn(); value; ++value) put(value.pos(), *value);
            return;
        }
        typename GridType::ValueType value;
        if (accessor_.probeValue(corner, value))
            for (openvdb::Index offset = 0; offset < kBrickVoxels; ++offset) put(offset, value);
    }

  private:
    typename GridType::ConstUnsafeAccessor accessor_;
};

template <class GridType>
BrickField gather(const BrickLayout& layout, const GridType& grid, int c, double scale) {
    BrickField field(layout.brickCount());
    constexpr std::size_t kChunk = 64;
    parallelFor((layout.brickCount() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        BrickReader<GridType> reader(grid);
        const std::size_t end = std::min(layout.brickCount(), (chunk + 1) * kChunk);
        for (std::size_t b = chunk * kChunk; b < end; ++b) {
            float* brick = field.brick(b);
            reader.read(layout.origins[b], [&](openvdb::Index offset, const auto& value) {
                brick[offset] = float(channel(value, c) * scale);
            });
        }
    });
    return field;
}

}  // namespace

BrickLayout layoutBricks(const std::vector<openvdb::GridBase::ConstPtr>& grids, std::size_t bytesPerVoxel) {
    BrickLayout layout;
    layout.worldFromIndex = linearPart(*grids.front());
    layout.voxelVolume = std::abs(layout.worldFromIndex.determinant());
    layout.activeVoxels = grids.front()->activeVoxelCount();
    for (const auto& grid : grids) {
        requireSameTransform(*grid, *grids.front());
        withTypedGrid(*grid, [&](const auto& typed) { addActiveBricks(typed, bytesPerVoxel, layout.origins); });
    }
    std::sort(layout.origins.begin(), layout.origins.end(), lessOrigin);
    layout.origins.erase(std::unique(layout.origins.begin(), layout.origins.end()), layout.origins.end());
    requireMemory(double(layout.origins.size()), bytesPerVoxel);
    if (!layout.origins.empty()) setBounds(layout);
    return layout;
}

BrickField gatherField(const BrickLayout& layout, const openvdb::FloatGrid& grid, double scale) {
    return gather(layout, grid, 0, scale);
}

BrickField gatherChannel(const BrickLayout& layout, const openvdb::GridBase& grid, int channel, double scale) {
    return withTypedGrid(grid, [&](const auto& typed) { return gather(layout, typed, channel, scale); });
}

BrickMask activeMask(const BrickLayout& layout, const openvdb::FloatGrid& topology, std::size_t b) {
    const openvdb::Coord corner = coordOf(layout.origins[b]);
    if (const auto* leaf = topology.tree().probeConstLeaf(corner)) return leaf->valueMask();
    return BrickMask(topology.tree().isValueOn(corner));
}

}  // namespace raysweep
