#include "raysweep/formats/dense_source.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"
#include "raysweep/formats/volume_choice.h"
#include "raysweep/volume/grid_transform.h"
#include "raysweep/volume/vdb_io.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

namespace raysweep {
namespace {

using openvdb::Coord;

constexpr int kEdge = 8;  ///< of a leaf, voxels

int sizeAlong(const IndexBox& box, int axis) {
    return box.high[axis] - box.low[axis] + 1;
}

std::string nameOf(const openvdb::GridBase& grid) {
    return "grid '" + grid.getName() + "'";
}

IndexBox boxOf(const openvdb::GridBase& grid, const DenseChoice& choice) {
    if (choice.denseBox) {
        for (int axis = 0; axis < 3; ++axis) {
            const int low = choice.denseBox->low[axis], high = choice.denseBox->high[axis];
            if (low > high || low < -kFarthestVoxel || high > kFarthestVoxel)
                throw about("denseBox", InvalidArgument(std::to_string(low) + " to " + std::to_string(high) +
                                                        " along " + "ijk"[axis] +
                                                        " are no voxels: the first comes first, and both are within " +
                                                        std::to_string(kFarthestVoxel) + " of 0"));
        }
        return *choice.denseBox;
    }
    const openvdb::CoordBBox active = grid.evalActiveVoxelBoundingBox();
    if (active.empty())
        throw InvalidArgument(nameOf(grid) + " has no active voxels, so there is nothing to write; give `denseBox`");
    return {Index3(active.min().x(), active.min().y(), active.min().z()),
            Index3(active.max().x(), active.max().y(), active.max().z())};
}

DenseLayout layoutOf(const openvdb::GridBase& grid, const IndexBox& box) {
    requireLinear(grid);
    const openvdb::Mat4R m = grid.transform().baseMap()->getAffineMap()->getMat4();  // row vectors
    DenseLayout layout;
    layout.origin = Vec3(m(3, 0), m(3, 1), m(3, 2));
    for (int axis = 0; axis < 3; ++axis) {
        Vec3& step = layout.steps[std::size_t(axis)];
        step = Vec3(m(axis, 0), m(axis, 1), m(axis, 2));
        layout.dims[axis] = sizeAlong(box, axis);
        layout.origin += step * double(box.low[axis]);
    }
    return layout;
}

/// The part of one leaf, or of a tile, that is in `slab`.
template <class Accessor, class Pick>
void copyBlock(const Accessor& tree, const Coord& first, const IndexBox& slab, const Pick& pick, float* to) {
    const auto* const leaf = tree.probeConstLeaf(first);
    const float tile = pick(tree.getValue(first));
    const auto end = [&](int axis) { return std::min(first[axis] | (kEdge - 1), slab.high[axis]); };
    for (int z = first.z(); z <= end(2); ++z)
        for (int y = first.y(); y <= end(1); ++y) {
            const std::size_t row =
                std::size_t(z - slab.low.z) * std::size_t(sizeAlong(slab, 1)) + std::size_t(y - slab.low.y);
            float* const line = to + row * std::size_t(sizeAlong(slab, 0));
            for (int x = first.x(); x <= end(0); ++x)
                line[x - slab.low.x] = leaf ? pick(leaf->getValue(Coord(x, y, z))) : tile;
        }
}

/// All voxels of `slab`, which lies within one layer of leaves.
template <class GridType, class Pick>
void copySlab(const GridType& grid, const IndexBox& slab, const Pick& pick, float* to) {
    const int firstRow = slab.low.y & ~(kEdge - 1);
    const auto rows = std::size_t((slab.high.y - firstRow) / kEdge + 1);
    parallelFor(rows, [&](std::size_t n) {
        const auto tree = grid.getConstAccessor();
        const int y = std::max(firstRow + int(n) * kEdge, slab.low.y);
        for (int x = slab.low.x; x <= slab.high.x; x = (x | (kEdge - 1)) + 1)
            copyBlock(tree, Coord(x, y, slab.low.z), slab, pick, to);
    });
}

/// Which number of a voxel. Grids of vectors hold colours more often than not.
int channelOf(const openvdb::GridBase& grid, const DenseChoice& choice) {
    const bool several = grid.isType<openvdb::Vec3SGrid>();
    const auto name = [](int n) { return std::string(n == 0 ? "x or red" : n == 1 ? "y or green" : "z or blue"); };
    return chooseChannel(grid.getName(), {std::uint64_t(several ? 3 : 1), "channels", name},
                         {choice.channel, std::nullopt});
}

[[noreturn]] void failNotFinite(const openvdb::GridBase& grid, const Index3& voxel) {
    throw InvalidArgument(nameOf(grid) + " is NaN or infinite at voxel (" + std::to_string(voxel.x) + ", " +
                          std::to_string(voxel.y) + ", " + std::to_string(voxel.z) + "); repair it first");
}

}  // namespace

bool hasRightAngles(const DenseLayout& layout) {
    constexpr double kRounding = 1e-5;  // of directions in single precision, and products of three of them
    const auto cosine = [&](std::size_t a, std::size_t b) {
        return layout.steps[a].normalized().dot(layout.steps[b].normalized());
    };
    return std::abs(cosine(0, 1)) < kRounding && std::abs(cosine(1, 2)) < kRounding &&
           std::abs(cosine(2, 0)) < kRounding;
}

DenseSource::DenseSource(openvdb::GridBase::ConstPtr grid, const DenseChoice& choice) : grid_(std::move(grid)) {
    box_ = boxOf(*grid_, choice);
    layout_ = layoutOf(*grid_, box_);
    requireBytes(double(layout_.dims.x) * layout_.dims.y * kEdge * sizeof(float),
                 nameOf(*grid_) + ": eight slices of " + std::to_string(layout_.dims.x) + "x" +
                     std::to_string(layout_.dims.y) + " need",
                 "choose a smaller part by `denseBox`, or use a coarser grid");
    const int channel = channelOf(*grid_, choice);
    fill_ = withTypedGrid(*grid_, [channel](const auto& typed) -> Fill {
        return [&typed, channel](const IndexBox& slab, float* to) {
            const auto pick = [channel](const auto& value) {
                if constexpr (std::is_same_v<std::decay_t<decltype(value)>, float>) {
                    static_cast<void>(channel);
                    return value;
                } else {
                    return value[channel];
                }
            };
            copySlab(typed, slab, pick, to);
        };
    });
    held_.high.z = held_.low.z - 1;
}

const float* DenseSource::slice(int k) {
    const int z = box_.low.z + k;
    const std::size_t sliceSize = std::size_t(layout_.dims.x) * std::size_t(layout_.dims.y);
    if (z < held_.low.z || z > held_.high.z) {
        held_ = box_;
        held_.low.z = std::max(box_.low.z, z & ~(kEdge - 1));
        held_.high.z = std::min(box_.high.z, z | (kEdge - 1));
        samples_.resize(sliceSize * std::size_t(sizeAlong(held_, 2)));
        fill_(held_, samples_.data());
        const auto bad = std::find_if(samples_.begin(), samples_.end(), [](float v) { return !std::isfinite(v); });
        if (bad != samples_.end()) {
            const auto n = std::size_t(bad - samples_.begin()), in = n % sliceSize, width = std::size_t(layout_.dims.x);
            const Index3 voxel = held_.low + Index3(int(in % width), int(in / width), int(n / sliceSize));
            held_.high.z = held_.low.z - 1;
            failNotFinite(*grid_, voxel);
        }
    }
    return samples_.data() + std::size_t(z - held_.low.z) * sliceSize;
}

}  // namespace raysweep
