/// Views ready for backprojection, and the sum over them in the voxels of a block: the last step of eq. 3 and 4 of
/// fbp.h.
#pragma once

#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/reconstruct/view_matrix.h"

#include <array>
#include <cstddef>
#include <vector>

namespace raysweep {

/// A grid's voxels as columns, for detectors whose columns run the same way.
struct VoxelColumns {
    const ReconstructionGrid& where;
    std::array<int, 3> axes{0, 1, 2};  ///< the grid's; the last is that of the columns

    VoxelColumns(const ReconstructionGrid& where, int columnAxis)
        : where(where), axes{columnAxis == 0 ? 1 : 0, columnAxis == 2 ? 1 : 2, columnAxis} {}

    int dim(int axis) const { return where.dims[axes[std::size_t(axis)]]; }
    /// World position of the lowest voxel of column (a,b).
    Vec3 lowest(int a, int b) const {
        Index3 index(0);
        index[axes[0]] = a;
        index[axes[1]] = b;
        return where.voxel(index.x, index.y, index.z);
    }
};

/// One view's values: detector columns one after the other, as a column of voxels mostly falls on one. They have a rim
/// of zeros, one pixel before, two after, so that the four pixels about any place on the detector or one pixel beside
/// it are there.
struct FilteredView {
    int width = 0, height = 0;  ///< without the rim
    std::size_t offset = 0;     ///< of the view among the values
    std::size_t stride = 0;     ///< of columns
    bool reversed = false;      ///< rows from the last to the first, so that they ascend with a column's voxels
    ViewMatrix matrix;          ///< rows counted as they are kept
};

class FilteredViews {
  public:
    /// Makes room for a view; the first of its rows lies at `matrix.y` 0.
    void add(const ViewMatrix& matrix, int width, int height, int columnAxis);
    double bytes() const { return double(size_) * sizeof(float); }  ///< that `allocate` takes
    /// All values 0, after the last view was added.
    void allocate();

    const std::vector<FilteredView>& views() const { return views_; }
    /// Takes the rows of view n.
    void setRows(std::size_t n, const float* rows);

    const float* pixels(const FilteredView& view) const { return values_.data() + view.offset; }

  private:
    std::vector<FilteredView> views_;
    std::size_t size_ = 0;
    std::vector<float> values_;
};

constexpr int kFbpBlock = 8;   ///< columns along each edge of a block
constexpr int kFbpChunk = 16;  ///< a column's sums take up a multiple of it

inline int paddedColumn(int voxels) {
    return (voxels + kFbpChunk - 1) / kFbpChunk * kFbpChunk;
}

/// Adds what all views show at the voxels of the block of columns that begins at (a,b): interpolated between pixels
/// linearly, over depth². In the order of the views. @param sums 8 x 8 columns of paddedColumn(dim(2)) voxels
void addFilteredViews(const FilteredViews& views, const VoxelColumns& columns, int a, int b, float* sums);

}  // namespace raysweep
