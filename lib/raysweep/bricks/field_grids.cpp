#include "raysweep/bricks/field_grids.h"

#include "raysweep/bricks/brick_map.h"
#include "raysweep/core/parallel.h"

#include <algorithm>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::Vec3s;

// Channels of a value, alike for scalars and colours.
void setChannel(float& value, int, float x) {
    value = x;
}
void setChannel(Vec3s& value, int c, float x) {
    value[c] = x;
}
template <class ValueType>
constexpr int channelCount() {
    return std::is_same<ValueType, float>::value ? 1 : 3;
}

template <class GridType>
using LeafOf = typename GridType::TreeType::LeafNodeType;

/// A grid of the leaves that `leafOf(n)` gives, several at a time; null for those that are not needed.
template <class GridType, class LeafOfNumber>
typename GridType::Ptr gridOfLeaves(const openvdb::FloatGrid& topology, std::size_t count, const LeafOfNumber& leafOf) {
    using Value = typename GridType::ValueType;
    auto grid = GridType::create(Value(0.0f));
    grid->setTransform(topology.transform().copy());
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

template <class GridType>
typename GridType::Ptr plainGrid(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                 const std::vector<BrickField>& fields) {
    constexpr int kChannels = channelCount<typename GridType::ValueType>();
    return gridOfLeaves<GridType>(topology, layout.brickCount(), [&](std::size_t b) -> LeafOf<GridType>* {
        const BrickMask mask = activeMask(layout, topology, b);
        if (mask.isOff()) return nullptr;
        auto* const leaf = makeLeaf<GridType>(layout.origins[b], mask);
        auto* const values = leaf->buffer().data();
        for (auto on = mask.beginOn(); on; ++on)
            for (int c = 0; c < kChannels; ++c)
                setChannel(values[on.pos()], c, fields[std::size_t(c)].brick(b)[on.pos()]);
        return leaf;
    });
}

/// Voxels of a brick, along an axis, that touch its neighbour on `side` (-1, 0, 1).
int firstTouching(int side) {
    return side > 0 ? kBrickEdge - 1 : 0;
}
int lastTouching(int side) {
    return side < 0 ? 0 : kBrickEdge - 1;
}

/// True if a voxel that is on touches the brick's neighbour on `side`.
bool touches(const BrickMask& mask, const Index3& side) {
    for (int x = firstTouching(side.x); x <= lastTouching(side.x); ++x)
        for (int y = firstTouching(side.y); y <= lastTouching(side.y); ++y)
            for (int z = firstTouching(side.z); z <= lastTouching(side.z); ++z)
                if (mask.isOn(openvdb::Index(offsetInBrick(Index3(x, y, z))))) return true;
    return false;
}

template <class Visit>
void forEachSide(const Visit& visit) {
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
            for (int k = -1; k <= 1; ++k) visit(Index3(i, j, k));
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
                const std::uint32_t own = map.find(origin);
                if ((side == Index3(0) || own == kNoBrick || active[own].isOff()) && touches(active[b], side))
                    origins.push_back(origin);
            });
        std::sort(origins.begin(), origins.end(), lessOrigin);
        origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
        return origins;
    }
};

/// Voxels of a leaf and those around it: the number of active ones, of known ones, and the known values, each first of
/// the voxel itself and then summed over it and its 26 neighbours.
template <int kChannels>
class Neighbourhood {
  public:
    Neighbourhood(const Known& known, const Index3& origin) {
        forEachSide([&](const Index3& side) {
            const std::uint32_t b = known.map.find(origin + side * kBrickEdge);
            if (b != kNoBrick) copyFrom(known, b, side);
        });
        for (auto& plane : sum_) addNeighbours(plane);
    }

    bool isOn(int x, int y, int z) const { return sum_[kActive][x][y][z] > 0; }

    /// The mean of the known values around; 0 if there are none.
    float mean(int channel, int x, int y, int z) const {
        const float count = sum_[kIsKnown][x][y][z];
        return count > 0 ? sum_[kValue + channel][x][y][z] / count : 0.0f;
    }

  private:
    enum { kActive, kIsKnown, kValue };
    static constexpr int kEdge = kBrickEdge + 2;
    using Cube = float[kEdge][kEdge][kEdge];

    void copyFrom(const Known& known, std::uint32_t b, const Index3& side) {
        const BrickMask& active = known.active[b];
        const Index3 to = side * kBrickEdge + Index3(1);
        for (int x = firstTouching(-side.x); x <= lastTouching(-side.x); ++x)
            for (int y = firstTouching(-side.y); y <= lastTouching(-side.y); ++y)
                for (int z = firstTouching(-side.z); z <= lastTouching(-side.z); ++z) {
                    const std::size_t i = offsetInBrick(Index3(x, y, z));
                    if (!active.isOn(openvdb::Index(i))) continue;
                    sum_[kActive][x + to.x][y + to.y][z + to.z] = 1;
                    if (known.fields[0].brick(b)[i] < 0) continue;
                    sum_[kIsKnown][x + to.x][y + to.y][z + to.z] = 1;
                    for (int c = 0; c < kChannels; ++c)
                        sum_[kValue + c][x + to.x][y + to.y][z + to.z] = known.fields[std::size_t(c)].brick(b)[i];
                }
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

    Cube sum_[2 + kChannels] = {};
};

template <class GridType>
LeafOf<GridType>* filledLeaf(const Known& known, std::uint32_t b) {
    auto* const leaf = makeLeaf<GridType>(known.layout.origins[b], known.active[b]);
    auto* const values = leaf->buffer().data();
    for (int i = 0; i < kBrickVoxels; ++i)
        for (int c = 0; c < channelCount<typename GridType::ValueType>(); ++c)
            setChannel(values[i], c, known.fields[std::size_t(c)].brick(b)[i]);
    return leaf;
}

template <class GridType>
LeafOf<GridType>* extendedLeaf(const Known& known, const Index3& origin) {
    constexpr int kChannels = channelCount<typename GridType::ValueType>();
    const std::uint32_t b = known.map.find(origin);
    if (known.isComplete(b)) return filledLeaf<GridType>(known, b);
    const Neighbourhood<kChannels> around(known, origin);
    auto* const leaf = makeLeaf<GridType>(origin, BrickMask());
    auto* const values = leaf->buffer().data();
    for (int i = 0; i < kBrickVoxels; ++i) {
        const int x = i >> 6, y = (i >> 3) & 7, z = i & 7;
        if (!around.isOn(x, y, z)) continue;
        leaf->setValueOn(openvdb::Index(i));
        const bool own = known.isKnown(b, i);
        for (int c = 0; c < kChannels; ++c)
            setChannel(values[i], c, own ? known.fields[std::size_t(c)].brick(b)[i] : around.mean(c, x, y, z));
    }
    return leaf;
}

template <class GridType>
typename GridType::Ptr extendedGrid(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                    const std::vector<BrickField>& fields) {
    const Known known(layout, topology, fields);
    const std::vector<Index3> origins = known.leafOrigins();
    return gridOfLeaves<GridType>(topology, origins.size(),
                                  [&](std::size_t n) { return extendedLeaf<GridType>(known, origins[n]); });
}

}  // namespace

openvdb::GridBase::Ptr gridFromFields(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                      const std::vector<BrickField>& fields) {
    if (fields.size() == 1) return plainGrid<openvdb::FloatGrid>(layout, topology, fields);
    return plainGrid<openvdb::Vec3SGrid>(layout, topology, fields);
}

openvdb::GridBase::Ptr extendedGridFromFields(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                              const std::vector<BrickField>& fields) {
    if (fields.size() == 1) return extendedGrid<openvdb::FloatGrid>(layout, topology, fields);
    return extendedGrid<openvdb::Vec3SGrid>(layout, topology, fields);
}

}  // namespace raysweep
