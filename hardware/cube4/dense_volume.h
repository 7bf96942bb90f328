/// Sparse grids made dense, as the machine's memory is, and back.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace raysweep::cube4 {

/// A box of voxels in index space.
struct DenseBox {
    Index3 low{0}, high{0};  ///< high exclusive
    Matrix3 worldFromIndex;  ///< linear part of the grids' transform: world = index * M

    Index3 size() const { return high - low; }
    std::size_t voxels() const { return std::size_t(size().x) * std::size_t(size().y) * std::size_t(size().z); }
    double voxelVolume() const { return std::abs(worldFromIndex.determinant()); }
    std::size_t indexOf(const Index3& at) const {
        const Index3 from = at - low;
        return (std::size_t(from.z) * std::size_t(size().y) + std::size_t(from.y)) * std::size_t(size().x) +
               std::size_t(from.x);
    }
};

/// One number for each voxel of a box, x fastest.
using DenseField = std::vector<float>;

/// 0 if it has no voxels.
inline double largestOf(const DenseField& field) {
    return field.empty() ? 0 : double(*std::max_element(field.begin(), field.end()));
}

/// In doubles.
inline double sumOf(const DenseField& field) {
    return std::accumulate(field.begin(), field.end(), 0.0,
                           [](double sum, float value) { return sum + double(value); });
}

/// The box around the active voxels of `grid`, whole blocks of 8.
/// @throw InvalidArgument for a transform that is not linear, a grid without active voxels, or one of more than
/// `mostVoxels` voxels
DenseBox boxAround(const openvdb::GridBase& grid, std::size_t mostVoxels);

/// @throw InvalidArgument if `box` has more than `mostVoxels` voxels
void requireAtMost(const DenseBox& box, std::size_t mostVoxels);

/// Component `channel` of the active values of a float or vec3s grid, 0 elsewhere.
DenseField denseField(const openvdb::GridBase& grid, const DenseBox& box, int channel = 0);

/// A grid of the voxels that are active in `topology`, and of those around them, which are the mean of their neighbours
/// among these: what is interpolated at an edge is not mixed with nothing.
openvdb::FloatGrid::Ptr extendedGrid(const DenseField& field, const DenseBox& box, const openvdb::FloatGrid& topology);

/// A grid of all voxels that are not 0.
openvdb::FloatGrid::Ptr sparseGrid(const DenseField& field, const DenseBox& box,
                                   const openvdb::math::Transform& transform);

}  // namespace raysweep::cube4
