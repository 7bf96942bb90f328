#include "raysweep/bricks/field_grids.h"

#include "raysweep/bricks/brick_map.h"
#include "raysweep/bricks/sides.h"
#include "raysweep/core/parallel.h"
#include "raysweep/volume/channels.h"

#include <algorithm>

namespace raysweep {
namespace {

using openvdb::Coord;

template <class GridType>
using LeafOf = typename GridType::TreeType::LeafNodeType;

template <class GridType>
constexpr int kGridChannels = kChannels<typename GridType::ValueType>;

/// A grid of the leaves that `leafOf(n)` gives, several at a time; null for those that are not needed.
template <class GridType, class LeafOfNumber>
typename GridType::Ptr gridOfLeaves(const openvdb::math::Transform& transform, std::size_t count,
                                    const LeafOfNumber& leafOf) {
    using Value = typename GridType::ValueType;
    auto grid = GridType::create(Value(0.0f));
    grid->setTransform(transform.copy());
    std::vector<LeafOf<GridType>*> leaves(count, nullptr);
    parallelFor(
        count, [&](std::size_t n) { leaves[n] = leafOf(n); }, 16);
    for (auto* leaf : leaves)
        if (leaf) grid->tree().addLeaf(leaf);
    return grid;
}

template <class GridType>
LeafOf<GridType>* makeLeaf(const Index3& origin, const BrickMask& on) {
    using Value = typename GridType::ValueType;
    auto* const leaf = new LeafOf<GridType>(Coord(origin.x, origin.y, origin.z), Value(0.0f));
    leaf->setValueMask(on);
    return leaf;
}

/// What the fields have at voxel `i` of brick `b`.
template <class GridType>
typename GridType::ValueType valueIn(const BrickField* fields, std::size_t b, std::size_t i) {
    typename GridType::ValueType value;
    for (int c = 0; c < kGridChannels<GridType>; ++c) channel(value, c) = fields[c].brick(b)[i];
    return value;
}

/// The leaf of brick `b` with the voxels of `mask`; null if there are none.
template <class GridType>
LeafOf<GridType>* filledLeaf(const BrickLayout& layout, std::size_t b, const BrickMask& mask,
                             const BrickField* fields) {
    if (mask.isOff()) return nullptr;
    auto* const leaf = makeLeaf<GridType>(layout.origins[b], mask);
    auto* const values = leaf->buffer().data();
    for (auto on = mask.beginOn(); on; ++on) values[on.pos()] = valueIn<GridType>(fields, b, on.pos());
    return leaf;
}

template <class GridType>
typename GridType::Ptr plainGrid(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                 const std::vector<BrickField>& fields) {
    return gridOfLeaves<GridType>(topology.transform(), layout.brickCount(), [&](std::size_t b) -> LeafOf<GridType>* {
        const BrickMask mask = activeMask(layout, topology, b);
        return filledLeaf<GridType>(layout, b, mask, fields.data());
    });
}

template <class GridType>
typename GridType::Ptr sparseGrid(const BrickLayout& layout, const openvdb::math::Transform& transform,
                                  const BrickField* fields) {
    return gridOfLeaves<GridType>(transform, layout.brickCount(), [&](std::size_t b) -> LeafOf<GridType>* {
        BrickMask mask;
        for (int c = 0; c < kGridChannels<GridType>; ++c)
            for (openvdb::Index i = 0; i < kBrickVoxels; ++i)
                if (fields[c].brick(b)[i] != 0) mask.setOn(i);
        return filledLeaf<GridType>(layout, b, mask, fields);
    });
}

/// True if a voxel that is on touches the brick's neighbour on `side`.
bool touches(const BrickMask& mask, const Index3& side) {
    bool any = false;
    forEachTouching(side, [&](const Index3& voxel) { any |= mask.isOn(openvdb::Index(offsetInBrick(voxel))); });
    return any;
}

/// Radiosity before it is extended: where voxels are active, and what is known of them.
struct Known {
    const BrickLayout& layout;
    const std::vector<BrickField>& fields;
    BrickMap map;
    std::vector<BrickMask> active;

    Known(const BrickLayout& bricks, const openvdb::FloatGrid& topology, const std::vector<BrickField>& radiosity)
        : layout(bricks), fields(radiosity), map(bricks), active(bricks.brickCount()) {
        parallelFor(
            active.size(), [&](std::size_t b) { active[b] = activeMask(layout, topology, b); }, 64);
    }

    /// `b` may be kNoBrick.
    bool isKnown(std::uint32_t b, int i) const {
        return b != kNoBrick && active[b].isOn(openvdb::Index(i)) && !(fields[0].brick(b)[i] < 0);
    }
    bool hasActive(std::uint32_t b) const { return b != kNoBrick && !active[b].isOff(); }
    bool isComplete(std::uint32_t b) const {
        if (b == kNoBrick || !active[b].isOn()) return false;
        const float* const values = fields[0].brick(b);
        return std::none_of(values, values + kBrickVoxels, [](float value) { return value < 0; });
    }

    /// Low corners of the leaves that hold a voxel within one of an active one.
    std::vector<Index3> leafOrigins() const {
        std::vector<Index3> origins;
        for (std::size_t b = 0; b < active.size(); ++b)
            forEachSide([&](const Index3& side) {
                const Index3 origin = layout.origins[b] + side * kBrickEdge;
                // Most neighbours hold active voxels of their own and add themselves.
                if (side == Index3(0) ? !active[b].isOff() : !hasActive(map.find(origin)) && touches(active[b], side))
                    origins.push_back(origin);
            });
        std::sort(origins.begin(), origins.end(), lessOrigin);
        origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
        return origins;
    }
};

/// Voxels of a leaf and those around it: the number of active ones, of known ones, and the known values, each first of
/// the voxel itself and then summed over it and its 26 neighbours.
template <int kChannelCount>
class Neighbourhood {
  public:
    Neighbourhood(const Known& known, const Index3& origin) {
        forEachSide([&](const Index3& side) {
            const std::uint32_t b = known.map.find(origin + side * kBrickEdge);
            if (b != kNoBrick) copyFrom(known, b, side);
        });
        for (auto& plane : sum_) addNeighbours(plane);
    }

    bool isOn(const Index3& v) const { return sum_[kActive][v.x][v.y][v.z] > 0; }

    /// The mean of the known values around; 0 if there are none.
    float mean(int channel, const Index3& v) const {
        const float count = sum_[kIsKnown][v.x][v.y][v.z];
        return count > 0 ? sum_[kValue + channel][v.x][v.y][v.z] / count : 0.0f;
    }

  private:
    enum { kActive, kIsKnown, kValue };
    static constexpr int kEdge = kBrickEdge + 2;
    using Cube = float[kEdge][kEdge][kEdge];

    void copyFrom(const Known& known, std::uint32_t b, const Index3& side) {
        const BrickMask& active = known.active[b];
        forEachTouching(side * -1, [&](const Index3& voxel) {
            const std::size_t i = offsetInBrick(voxel);
            if (!active.isOn(openvdb::Index(i))) return;
            const Index3 to = voxel + side * kBrickEdge + Index3(1);
            sum_[kActive][to.x][to.y][to.z] = 1;
            if (!known.isKnown(b, int(i))) return;
            sum_[kIsKnown][to.x][to.y][to.z] = 1;
            for (int c = 0; c < kChannelCount; ++c)
                sum_[kValue + c][to.x][to.y][to.z] = known.fields[std::size_t(c)].brick(b)[i];
        });
    }

    /// Axis by axis; what belongs to voxel (x,y,z) of the leaf then stands at [x][y][z].
    static void addNeighbours(Cube& cube) {
        for (int x = 0; x < kEdge; ++x)
            for (int y = 0; y < kEdge; ++y)
                for (int z = 0; z < kBrickEdge; ++z) cube[x][y][z] += cube[x][y][z + 1] + cube[x][y][z + 2];
        for (int x = 0; x < kEdge; ++x)
            for (int y = 0; y < kBrickEdge; ++y)
                for (int z = 0; z < kBrickEdge; ++z) cube[x][y][z] += cube[x][y + 1][z] + cube[x][y + 2][z];
        for (int x = 0; x < kBrickEdge; ++x)
            for (int y = 0; y < kBrickEdge; ++y)
                for (int z = 0; z < kBrickEdge; ++z) cube[x][y][z] += cube[x + 1][y][z] + cube[x + 2][y][z];
    }

    Cube sum_[2 + kChannelCount] = {};
};

template <class GridType>
LeafOf<GridType>* extendedLeaf(const Known& known, const Index3& origin) {
    const std::uint32_t b = known.map.find(origin);
    if (known.isComplete(b)) return filledLeaf<GridType>(known.layout, b, known.active[b], known.fields.data());
    const Neighbourhood<kGridChannels<GridType>> around(known, origin);
    auto* const leaf = makeLeaf<GridType>(origin, BrickMask());
    auto* const values = leaf->buffer().data();
    for (int i = 0; i < kBrickVoxels; ++i) {
        const Index3 voxel = voxelInBrick(i);
        if (!around.isOn(voxel)) continue;
        leaf->setValueOn(openvdb::Index(i));
        if (known.isKnown(b, i))
            values[i] = valueIn<GridType>(known.fields.data(), b, std::size_t(i));
        else
            for (int c = 0; c < kGridChannels<GridType>; ++c) channel(values[i], c) = around.mean(c, voxel);
    }
    return leaf;
}

template <class GridType>
typename GridType::Ptr extendedGrid(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                    const std::vector<BrickField>& fields) {
    const Known known(layout, topology, fields);
    const std::vector<Index3> origins = known.leafOrigins();
    return gridOfLeaves<GridType>(topology.transform(), origins.size(),
                                  [&](std::size_t n) { return extendedLeaf<GridType>(known, origins[n]); });
}

}  // namespace

openvdb::GridBase::Ptr gridFromFields(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                      const std::vector<BrickField>& fields) {
    if (fields.size() == 1) return plainGrid<openvdb::FloatGrid>(layout, topology, fields);
    return plainGrid<openvdb::Vec3SGrid>(layout, topology, fields);
}

openvdb::GridBase::Ptr sparseGridFromFields(const BrickLayout& layout, const openvdb::math::Transform& transform,
                                            const BrickField* fields, int count) {
    if (count == 1) return sparseGrid<openvdb::FloatGrid>(layout, transform, fields);
    return sparseGrid<openvdb::Vec3SGrid>(layout, transform, fields);
}

openvdb::GridBase::Ptr extendedGridFromFields(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                              const std::vector<BrickField>& fields) {
    if (fields.size() == 1) return extendedGrid<openvdb::FloatGrid>(layout, topology, fields);
    return extendedGrid<openvdb::Vec3SGrid>(layout, topology, fields);
}

}  // namespace raysweep
