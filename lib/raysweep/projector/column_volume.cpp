#include "raysweep/projector/column_volume.h"

#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

namespace raysweep {
namespace {

int roundedUp(int voxels) {
    return (voxels + kColumnChunk - 1) / kColumnChunk * kColumnChunk;
}

std::vector<ColumnRange> allOf(const ColumnLattice& lattice) {
    const std::size_t blocks = std::size_t(blocksFor(lattice.dims.x)) * blocksFor(lattice.dims.y);
    return std::vector<ColumnRange>(blocks, ColumnRange{0, roundedUp(lattice.dims.z)});
}

Vec3 vec3(const openvdb::Vec3d& v) {
    return Vec3(v.x(), v.y(), v.z());
}

/// Calls `use(x, y, z, gridIndex)` for each voxel of a block that lies in the lattice.
template <class Use>
void forEachVoxel(const ColumnVolume& volume, std::size_t block, const Use& use) {
    const ColumnLattice& lattice = volume.lattice();
    const int firstX = volume.firstX(block), firstY = volume.firstY(block);
    const ColumnRange range = volume.ranges()[block];
    for (int x = firstX; x < std::min(firstX + kBlockEdge, lattice.dims.x); ++x)
        for (int y = firstY; y < std::min(firstY + kBlockEdge, lattice.dims.y); ++y)
            for (int z = range.low; z < std::min(range.high, lattice.dims.z); ++z)
                use(x, y, z, lattice.gridIndex(x, y, z));
}

}  // namespace

ColumnLattice columnLattice(const openvdb::CoordBBox& box, const openvdb::math::Transform& transform, int columnAxis) {
    if (!transform.isLinear())
        throw InvalidArgument("the volume's transform is not linear; resample it to a grid with a linear one");
    ColumnLattice lattice;
    lattice.axes = {columnAxis == 0 ? 1 : 0, columnAxis == 2 ? 1 : 2, columnAxis};
    lattice.low = box.min();
    const openvdb::Coord dims = box.dim();
    const Vec3 origin = vec3(transform.indexToWorld(openvdb::Coord(0, 0, 0)));
    lattice.origin = vec3(transform.indexToWorld(box.min()));
    for (int axis = 0; axis < 3; ++axis) {
        lattice.dims[axis] = dims[lattice.axes[axis]];
        openvdb::Coord one(0, 0, 0);
        one[lattice.axes[axis]] = 1;
        const Vec3 step = vec3(transform.indexToWorld(one)) - origin;
        for (int c = 0; c < 3; ++c) lattice.worldFromVoxel[axis][c] = step[c];
    }
    const Matrix3& m = lattice.worldFromVoxel;
    const double edges = Vec3(m[0][0], m[0][1], m[0][2]).length() * Vec3(m[1][0], m[1][1], m[1][2]).length() *
                         Vec3(m[2][0], m[2][1], m[2][2]).length();
    if (!(std::abs(m.determinant()) > 1e-9 * edges))
        throw InvalidArgument("the volume's transform is singular: its voxels have no volume");
    return lattice;
}

ColumnVolume::ColumnVolume(const ColumnLattice& lattice) : ColumnVolume(lattice, allOf(lattice)) {}

ColumnVolume::ColumnVolume(const ColumnLattice& lattice, std::vector<ColumnRange> kept)
    : lattice_(lattice), blocksY_(blocksFor(lattice.dims.y)), ranges_(std::move(kept)), offsets_(ranges_.size() + 1) {
    for (std::size_t t = 0; t < ranges_.size(); ++t)
        offsets_[t + 1] = offsets_[t] + std::size_t(ranges_[t].length()) * kBlockColumns;
    const std::size_t bytes = storedVoxels() * sizeof(float);
    requireBytes(double(bytes),
                 "a volume of " + std::to_string(lattice.dims.x) + "x" + std::to_string(lattice.dims.y) + "x" +
                     std::to_string(lattice.dims.z) + " voxels needs",
                 "use larger voxels");
    constexpr std::size_t kCacheLine = 64, kAround = kReadable * sizeof(float);
    data_.reset(static_cast<float*>(std::aligned_alloc(kCacheLine, kAround + bytes + kAround)));
    if (!data_) throw std::bad_alloc();
    std::memset(data_.get(), 0, kAround);
    std::memset(data_.get() + kReadable + storedVoxels(), 0, kAround);
    parallelFor(ranges_.size(),
                [&](std::size_t t) { std::memset(block(t), 0, (offsets_[t + 1] - offsets_[t]) * sizeof(float)); });
}

void ColumnVolume::copyFrom(const ColumnVolume& other) {
    parallelFor(blockCount(), [&](std::size_t t) { std::copy_n(other.block(t), voxelsOf(t), block(t)); });
}

void ColumnVolume::clampAll(float lower, float upper) {
    parallelFor(blockCount(), [&](std::size_t t) {
        for (std::size_t i = 0; i < voxelsOf(t); ++i) block(t)[i] = std::clamp(block(t)[i], lower, upper);
    });
}

float ColumnVolume::value(int x, int y, int z) const {
    if (x < 0 || y < 0 || x >= lattice_.dims.x || y >= lattice_.dims.y) return 0;
    const std::size_t t = blockOf(x, y);
    if (z < ranges_[t].low || z >= ranges_[t].high) return 0;
    return column(t, x, y)[z - ranges_[t].low];
}

void fillColumns(ColumnVolume& volume, const openvdb::FloatGrid& grid, const openvdb::Coord& shift) {
    parallelFor(volume.blockCount(), [&](std::size_t t) {
        if (volume.ranges()[t].length() == 0) return;
        openvdb::FloatGrid::ConstUnsafeAccessor values(grid.tree());
        forEachVoxel(volume, t, [&](int x, int y, int z, const openvdb::Coord& index) {
            float value = 0;
            if (!values.probeValue(index + shift, value)) return;
            volume.column(t, x, y)[z - volume.ranges()[t].low] = value;
        });
    });
}

ColumnVolume columnsOf(const openvdb::FloatGrid& grid, const ColumnLattice& lattice) {
    std::vector<ColumnRange> kept(std::size_t(blocksFor(lattice.dims.x)) * blocksFor(lattice.dims.y));
    const int blocksY = blocksFor(lattice.dims.y);
    for (auto value = grid.cbeginValueOn(); value; ++value) {
        openvdb::CoordBBox box;
        value.getBoundingBox(box);
        openvdb::Coord low, high;
        for (int axis = 0; axis < 3; ++axis) {
            const int first = lattice.low[lattice.axes[axis]];
            low[axis] = std::max(box.min()[lattice.axes[axis]] - first, 0);
            high[axis] = std::min(box.max()[lattice.axes[axis]] - first, lattice.dims[axis] - 1);
        }
        if (low.z() > high.z()) continue;
        const int from = low.z() / kColumnChunk * kColumnChunk, to = roundedUp(high.z() + 1);
        for (int x = low.x() / kBlockEdge; x <= high.x() / kBlockEdge && low.x() <= high.x(); ++x)
            for (int y = low.y() / kBlockEdge; y <= high.y() / kBlockEdge && low.y() <= high.y(); ++y) {
                ColumnRange& range = kept[std::size_t(x) * blocksY + y];
                range = range.length() == 0 ? ColumnRange{from, to}
                                            : ColumnRange{std::min(range.low, from), std::max(range.high, to)};
            }
    }
    ColumnVolume volume(lattice, std::move(kept));
    fillColumns(volume, grid);
    return volume;
}

openvdb::FloatGrid::Ptr gridOf(const ColumnVolume& volume, const openvdb::math::Transform& transform, float tolerance) {
    using Leaf = openvdb::FloatTree::LeafNodeType;
    const ColumnLattice& lattice = volume.lattice();
    const openvdb::Coord first = lattice.low & ~7;
    const openvdb::Coord last = lattice.gridIndex(lattice.dims.x - 1, lattice.dims.y - 1, lattice.dims.z - 1) & ~7;
    std::vector<openvdb::Coord> corners;
    for (int i = first.x(); i <= last.x(); i += 8)
        for (int j = first.y(); j <= last.y(); j += 8)
            for (int k = first.z(); k <= last.z(); k += 8) corners.emplace_back(i, j, k);

    std::vector<std::unique_ptr<Leaf>> leaves(corners.size());
    parallelFor(corners.size(), [&](std::size_t n) {
        auto leaf = std::make_unique<Leaf>(corners[n], 0.0f);
        for (openvdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const openvdb::Coord index = leaf->offsetToGlobalCoord(offset) - lattice.low;
            const float value = volume.value(index[lattice.axes[0]], index[lattice.axes[1]], index[lattice.axes[2]]);
            if (std::abs(value) > tolerance) leaf->setValueOn(offset, value);
        }
        if (!leaf->isEmpty()) leaves[n] = std::move(leaf);
    });
    const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0.0f);
    for (auto& leaf : leaves)
        if (leaf) grid->tree().addLeaf(leaf.release());
    grid->setTransform(transform.copy());
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

}  // namespace raysweep
