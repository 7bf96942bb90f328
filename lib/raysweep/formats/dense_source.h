/// A box of a grid's voxels as files of dense volumes hold them.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/formats/stored_volume.h"
#include "raysweep/volume/grids.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// Where samples are: (i,j,k) at origin + i steps[0] + j steps[1] + k steps[2], world units.
struct DenseLayout {
    Index3 dims{0};
    Vec3 origin{0};
    std::array<Vec3, 3> steps{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};

    std::uint64_t samples() const { return std::uint64_t(dims.x) * std::uint64_t(dims.y) * std::uint64_t(dims.z); }
    Vec3 spacing() const { return Vec3(steps[0].length(), steps[1].length(), steps[2].length()); }
};

/// False if axes are sheared by more than what rounding makes of directions.
bool hasRightAngles(const DenseLayout& layout);

/// What of a grid is meant.
struct DenseChoice {
    std::optional<IndexBox> denseBox;  ///< voxels, both ends included; not given: the box around the active ones
    std::optional<int> channel;        ///< of a grid of vectors or colours, counted from 0
};

/// Gives the voxels of a box, inactive ones too, slice by slice: no more than eight slices are in memory.
class DenseSource {
  public:
    /// @param grid FloatGrid or Vec3SGrid, which must stay as it is
    /// @throw InvalidArgument if there is no active voxel and no box, if the grid holds several numbers per voxel and
    /// none is chosen, if its transform is not linear, or if its slices do not fit in memory
    explicit DenseSource(openvdb::GridBase::ConstPtr grid, const DenseChoice& choice = {});

    const DenseLayout& layout() const { return layout_; }
    /// The grid's index of sample (0,0,0).
    const Index3& corner() const { return box_.low; }
    std::string name() const { return grid_->getName(); }

    /// Slice k, i fastest: dims.x * dims.y samples, valid until the next call. Quickest in order.
    /// @throw InvalidArgument naming the first voxel of it, or of slices beside it, that is NaN or infinite
    const float* slice(int k);

  private:
    using Fill = std::function<void(const IndexBox&, float*)>;

    openvdb::GridBase::ConstPtr grid_;
    IndexBox box_;
    DenseLayout layout_;
    Fill fill_;
    IndexBox held_;  ///< voxels in samples_
    std::vector<float> samples_;
};

}  // namespace raysweep
