/// Linear interpolation between voxel centres, made for points that follow a ray.
#pragma once

#include "raysweep/volume/grids.h"

#include <openvdb/tree/ValueAccessor.h>

namespace raysweep {

/// Largest integer not above x. A call to std::floor costs as much as the rest of a lookup on plain x86-64.
inline int floorToInt(double x) {
    const int truncated = int(x);
    return truncated - (x < truncated);
}

/// Samples one grid. It remembers the leaf and the cell of eight voxels that it was in last, so keep one per thread and
/// per ray bundle. Inactive voxels and tiles take part with the values they hold.
template <class Grid>
class LinearSampler {
  public:
    using Value = typename Grid::ValueType;

    explicit LinearSampler(const Grid& grid) : accessor_(grid.tree()) {}

    /// Value at `p`, in index space.
    Value operator()(const openvdb::Vec3d& p) {
        const openvdb::Coord cell(floorToInt(p.x()), floorToInt(p.y()), floorToInt(p.z()));
        if (cell != cell_) load(cell);
        const float x = float(p.x() - cell.x()), y = float(p.y() - cell.y()), z = float(p.z() - cell.z());
        const Value z00 = mix(v_[0], v_[1], z), z01 = mix(v_[2], v_[3], z);
        const Value z10 = mix(v_[4], v_[5], z), z11 = mix(v_[6], v_[7], z);
        return mix(mix(z00, z01, y), mix(z10, z11, y), x);
    }

  private:
    using Leaf = typename Grid::TreeType::LeafNodeType;

    static Value mix(const Value& a, const Value& b, float t) { return a + (b - a) * t; }

    void load(const openvdb::Coord& cell) {
        cell_ = cell;
        const openvdb::Coord leafOrigin = cell & ~7;
        if (leafOrigin != leafOrigin_) {
            leafOrigin_ = leafOrigin;
            const Leaf* leaf = accessor_.probeConstLeaf(cell);
            data_ = leaf ? leaf->buffer().data() : nullptr;
        }
        const int x = cell.x() & 7, y = cell.y() & 7, z = cell.z() & 7;
        if (data_ && x < 7 && y < 7 && z < 7)
            loadWithinLeaf(data_ + (x << 6 | y << 3 | z));
        else
            loadAcrossNodes();
    }

    void loadWithinLeaf(const Value* corner) {
        static constexpr int kOffset[8] = {0, 1, 8, 9, 64, 65, 72, 73};
        for (int i = 0; i < 8; ++i) v_[i] = corner[kOffset[i]];
    }

    void loadAcrossNodes() {
        for (int i = 0; i < 8; ++i) v_[i] = accessor_.getValue(cell_.offsetBy(i >> 2, (i >> 1) & 1, i & 1));
    }

    // Not registered with the tree: nobody changes it while it is rendered.
    openvdb::tree::ValueAccessor<const typename Grid::TreeType, false> accessor_;
    openvdb::Coord cell_ = openvdb::Coord::max(), leafOrigin_ = openvdb::Coord::max();
    const Value* data_ = nullptr;
    Value v_[8];
};

}  // namespace raysweep
