/// A volume stored as columns of voxels, for rays that run across the columns: X-rays that turn about an axis meet a
/// whole column, or none of it, wherever they are. Memory is proportional to what is kept.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

#include <array>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <vector>

namespace raysweep {

constexpr int kBlockEdge = 8;                           ///< a block is 8x8 columns
constexpr int kBlockColumns = kBlockEdge * kBlockEdge;  ///< column (x,y) of a block has the number x * 8 + y
constexpr int kColumnChunk = 16;                        ///< columns begin and end at multiples of it, voxels
constexpr int kReadable = 64;                           ///< floats around a volume's voxels that may be read

/// Where voxels are. Voxel (x,y,z) counts along three axes of a grid's index space, of which `axes[2]` is that of the
/// columns.
struct ColumnLattice {
    Index3 dims{0};                    ///< voxels along x, y, z (the columns)
    std::array<int, 3> axes{0, 1, 2};  ///< the grid's index axis that x, y, z run along
    openvdb::Coord low{0, 0, 0};       ///< the grid's index of voxel (0,0,0)
    Matrix3 worldFromVoxel;            ///< linear part: world = voxel * worldFromVoxel + origin
    Vec3 origin{0};                    ///< world position of the middle of voxel (0,0,0)

    openvdb::Coord gridIndex(int x, int y, int z) const {
        openvdb::Coord index = low;
        index[axes[0]] += x;
        index[axes[1]] += y;
        index[axes[2]] += z;
        return index;
    }
};

/// The voxels of `box` (of index space of a grid with this transform), their columns along `columnAxis`.
/// @throw InvalidArgument if the transform is not linear or singular.
ColumnLattice columnLattice(const openvdb::CoordBBox& box, const openvdb::math::Transform& transform, int columnAxis);

/// The part of a block's columns that is kept: voxels [low, high), multiples of kColumnChunk; none if low == high. The
/// last chunk may reach beyond the lattice; voxels there are 0 and stay so.
struct ColumnRange {
    int low = 0, high = 0;
    int length() const { return high - low; }
};

/// Blocks along an axis of so many voxels.
constexpr int blocksFor(int voxels) {
    return (voxels + kBlockEdge - 1) / kBlockEdge;
}

/// One float per voxel that is kept, 0 at first.
class ColumnVolume {
  public:
    /// All voxels of `lattice`.
    explicit ColumnVolume(const ColumnLattice& lattice);
    /// @param kept for each block, blocks along y fastest
    ColumnVolume(const ColumnLattice& lattice, std::vector<ColumnRange> kept);

    const ColumnLattice& lattice() const { return lattice_; }
    std::size_t blockCount() const { return ranges_.size(); }
    const std::vector<ColumnRange>& ranges() const { return ranges_; }
    std::size_t storedVoxels() const { return offsets_.back(); }
    std::size_t voxelsOf(std::size_t block) const { return offsets_[block + 1] - offsets_[block]; }

    /// The columns of a block, one after the other, each as long as the block's range.
    /// Kernels may read up to kReadable floats before the first and behind the last.
    float* block(std::size_t t) { return data_.get() + kReadable + offsets_[t]; }
    const float* block(std::size_t t) const { return data_.get() + kReadable + offsets_[t]; }

    /// A block's columns begin at column (firstX, firstY).
    int firstX(std::size_t block) const { return int(block / std::size_t(blocksY_)) * kBlockEdge; }
    int firstY(std::size_t block) const { return int(block % std::size_t(blocksY_)) * kBlockEdge; }

    std::size_t blockOf(int x, int y) const { return std::size_t(x / kBlockEdge) * blocksY_ + y / kBlockEdge; }

    /// Column (x,y), its first voxel that of the block's range.
    const float* column(std::size_t block, int x, int y) const {
        const int number = (x % kBlockEdge) * kBlockEdge + y % kBlockEdge;
        return this->block(block) + std::size_t(number) * ranges_[block].length();
    }

    float* column(std::size_t block, int x, int y) {
        return const_cast<float*>(static_cast<const ColumnVolume*>(this)->column(block, x, y));
    }

    /// The voxels of another volume that keeps the same.
    void copyFrom(const ColumnVolume& other);

    /// Voxels beyond a bound get its value; 0 must lie within.
    void clampAll(float lower, float upper);

    /// The value of a voxel of the lattice; 0 where nothing is kept.
    float value(int x, int y, int z) const;

  private:
    struct Free {
        void operator()(float* p) const { std::free(p); }
    };
    ColumnLattice lattice_;
    int blocksY_;
    std::vector<ColumnRange> ranges_;
    std::vector<std::size_t> offsets_;  ///< of each block, and the end
    std::unique_ptr<float[], Free> data_;
};

/// Copies the active voxels and tiles of `grid` that lie in the volume. The lattice's index i is the grid's i + shift.
void fillColumns(ColumnVolume& volume, const openvdb::FloatGrid& grid,
                 const openvdb::Coord& shift = openvdb::Coord(0, 0, 0));

/// A volume that keeps the blocks of columns in which `grid` has active voxels, and their values.
ColumnVolume columnsOf(const openvdb::FloatGrid& grid, const ColumnLattice& lattice);

/// The voxels further than `tolerance` from 0, as a grid called "density" with the given transform.
openvdb::FloatGrid::Ptr gridOf(const ColumnVolume& volume, const openvdb::math::Transform& transform, float tolerance);

}  // namespace raysweep
