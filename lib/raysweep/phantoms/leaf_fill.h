/// Filling a grid with what is a function of position, leaf by leaf, several at a time.
#pragma once

#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

#include <cmath>
#include <memory>
#include <vector>

namespace raysweep {

/// Half the diagonal of a leaf, voxels: nothing in it is further from its centre.
const double kLeafRadius = 3.5 * std::sqrt(3.0);

/// Where voxels are looked for, and the point, in index space, that they are described relative to.
struct FillRegion {
    openvdb::CoordBBox box;
    Vec3 middle{0};
};

/// Checks that there is memory for a list of so many leaves, and what becomes of each. @throw InvalidArgument
inline void requireLeafIndex(double count) {
    requireBytes(count * double(sizeof(openvdb::Coord) + 2 * sizeof(void*)), "a list of the volume's blocks needs",
                 "make it smaller");
}

/// Checks that there is memory for those of `count` leaves that `used(n)` says something is in, by looking at some.
/// @throw InvalidArgument
template <class Used>
void requireRoomForLeaves(std::size_t count, std::size_t bytesPerVoxel, const Used& used) {
    constexpr std::size_t kSamples = 40009;  // a prime, so that they follow no edge of the volume
    const std::size_t stride = count < kSamples ? 1 : count / kSamples * 2 + 1, samples = (count + stride - 1) / stride;
    const auto hits = orderedSum<std::size_t>(
        samples, [&](std::size_t n) { return used(n * stride % count) ? std::size_t(1) : std::size_t(0); });
    requireMemory(samples > 0 ? double(hits) / double(samples) * double(count) : 0, bytesPerVoxel);
}

/// Activates the voxels of `region` for which `valueAt(position, leafData)` is above 0, or is a vector that is not 0;
/// `position` is the voxel's index relative to the middle. `prepare(centre, leafData)` is called before, once per leaf;
/// where it returns false the leaf is empty.
/// @param bytesPerVoxel memory that there must be for what becomes of the grid
/// @throw InvalidArgument if there is not enough memory
template <class LeafData, class GridType, class Prepare, class ValueAt>
void fillLeaves(GridType& grid, const FillRegion& region, const Prepare& prepare, const ValueAt& valueAt,
                std::size_t bytesPerVoxel = sizeof(typename GridType::ValueType)) {
    using Leaf = typename GridType::TreeType::LeafNodeType;
    using Value = typename GridType::ValueType;
    const Value none = openvdb::zeroVal<Value>();
    const auto fromMiddle = [&](const openvdb::Coord& ijk) { return Vec3(ijk.x(), ijk.y(), ijk.z()) - region.middle; };
    std::vector<openvdb::Coord> origins;
    const openvdb::Coord first = region.box.min() & ~7, last = region.box.max() & ~7;
    const openvdb::Coord blocks = ((last - first) >> 3) + openvdb::Coord(1);
    requireLeafIndex(double(blocks.x()) * blocks.y() * blocks.z());
    for (int x = first.x(); x <= last.x(); x += 8)
        for (int y = first.y(); y <= last.y(); y += 8)
            for (int z = first.z(); z <= last.z(); z += 8) origins.emplace_back(x, y, z);
    requireRoomForLeaves(origins.size(), bytesPerVoxel, [&](std::size_t n) {
        LeafData data;
        return prepare(fromMiddle(origins[n]) + Vec3(3.5), data);
    });
    std::vector<std::unique_ptr<Leaf>> made(origins.size());
    parallelFor(origins.size(), [&](std::size_t n) {
        LeafData data;
        if (!prepare(fromMiddle(origins[n]) + Vec3(3.5), data)) return;
        auto leaf = std::make_unique<Leaf>(origins[n], none);
        for (openvdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const openvdb::Coord ijk = leaf->offsetToGlobalCoord(offset);
            if (!region.box.isInside(ijk)) continue;
            const Value value(valueAt(fromMiddle(ijk), data));
            if constexpr (openvdb::VecTraits<Value>::IsVec) {
                if (value != none) leaf->setValueOn(offset, value);
            } else if (value > none) {
                leaf->setValueOn(offset, value);
            }
        }
        if (!leaf->isEmpty()) made[n] = std::move(leaf);
    });
    for (auto& leaf : made)
        if (leaf) grid.tree().addLeaf(leaf.release());
}

}  // namespace raysweep
