/// The solver's own storage: the 8x8x8 blocks of voxels ("bricks") that hold active voxels, in flat arrays laid out for
/// the sweep. Memory is proportional to the bricks, whatever the bounding box.
#pragma once

#include "raysweep/core/types.h"

#include <array>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

namespace raysweep {

constexpr int kBrickEdge = 8;      ///< voxels along a brick's edge, as in an OpenVDB leaf
constexpr int kBrickVoxels = 512;  ///< voxels in a brick; offset (x<<6)|(y<<3)|z, as in an OpenVDB leaf

/// The order of a layout's bricks.
inline bool lessOrigin(const Index3& a, const Index3& b) {
    return a.x != b.x ? a.x < b.x : (a.y != b.y ? a.y < b.y : a.z < b.z);
}

/// Where the bricks are.
struct BrickLayout {
    std::vector<Index3> origins;  ///< low corner of each brick, voxel coordinates, ascending in (x,y,z)
    Index3 low{0}, high{0};       ///< bounding box of the bricks, voxel coordinates, high exclusive
    Matrix3 worldFromIndex;       ///< linear part of the grid's transform: world = index * worldFromIndex
    double voxelVolume = 1;       ///< world unit^3
    std::size_t activeVoxels = 0;

    std::size_t brickCount() const { return origins.size(); }
};

/// One float for every voxel of every brick, zero at first; bricks follow each other in the layout's order.
class BrickField {
  public:
    BrickField() = default;
    explicit BrickField(std::size_t brickCount);
    BrickField(BrickField&& other) noexcept
        : data_(std::move(other.data_)), brickCount_(std::exchange(other.brickCount_, 0)) {}
    BrickField& operator=(BrickField&& other) noexcept {
        data_ = std::move(other.data_);
        brickCount_ = std::exchange(other.brickCount_, 0);
        return *this;
    }

    float* brick(std::size_t b) { return data_.get() + b * kBrickVoxels; }
    const float* brick(std::size_t b) const { return data_.get() + b * kBrickVoxels; }
    std::size_t brickCount() const { return brickCount_; }
    bool empty() const { return brickCount_ == 0; }

  private:
    struct Free {
        void operator()(float* p) const { std::free(p); }
    };
    std::unique_ptr<float[], Free> data_;
    std::size_t brickCount_ = 0;
};

}  // namespace raysweep
