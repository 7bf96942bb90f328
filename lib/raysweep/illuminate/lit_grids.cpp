#include "raysweep/illuminate/lit_grids.h"

#include "raysweep/core/parallel.h"

#include <openvdb/tools/Morphology.h>
#include <openvdb/tree/LeafManager.h>

#include <cmath>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::Vec3s;

// Channels of a value, alike for scalars and colours.
float channel(float value, int) {
    return value;
}
float channel(const Vec3s& value, int c) {
    return value[c];
}
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

/// Radiosity is never negative, so the sign is free to say "not from the solver": unknown values are -infinity, and
/// those filled in from neighbours are kept negative until all are done, so that none is made from another.
template <class ValueType>
bool isKnown(const ValueType& value) {
    return !std::signbit(channel(value, 0));
}

template <class ValueType>
ValueType uniform(float x) {
    return ValueType(x);
}

template <class GridType>
typename GridType::Ptr makeGrid(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                const std::vector<BrickField>& fields, bool extended) {
    using ValueType = typename GridType::ValueType;
    using Leaf = typename GridType::TreeType::LeafNodeType;
    const ValueType inactive = uniform<ValueType>(extended ? -INFINITY : 0.0f);
    auto grid = GridType::create(inactive);
    grid->setTransform(topology.transform().copy());
    std::vector<Leaf*> leaves(layout.brickCount(), nullptr);
    parallelFor(
        layout.brickCount(),
        [&](std::size_t b) {
            const Index3& origin = layout.origins[b];
            const BrickMask mask = activeMask(layout, topology, b);
            if (mask.isOff()) return;
            leaves[b] = new Leaf(Coord(origin.x, origin.y, origin.z), inactive);
            leaves[b]->setValueMask(mask);
            ValueType* const values = leaves[b]->buffer().data();
            for (auto on = mask.beginOn(); on; ++on) {
                if (extended && fields[0].brick(b)[on.pos()] < 0) continue;
                for (int c = 0; c < channelCount<ValueType>(); ++c)
                    setChannel(values[on.pos()], c, fields[std::size_t(c)].brick(b)[on.pos()]);
            }
        },
        16);
    for (Leaf* leaf : leaves)
        if (leaf) grid->tree().addLeaf(leaf);
    return grid;
}

/// Minus the mean of the known neighbours; minus zero if there are none.
template <class Accessor>
typename Accessor::ValueType meanOfNeighbours(const Accessor& accessor, const Coord& at) {
    using ValueType = typename Accessor::ValueType;
    constexpr int kChannels = channelCount<ValueType>();
    double sum[kChannels] = {0};
    int count = 0;
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
            for (int k = -1; k <= 1; ++k) {
                const ValueType value = accessor.getValue(at.offsetBy(i, j, k));
                if (!isKnown(value)) continue;
                ++count;
                for (int c = 0; c < kChannels; ++c) sum[c] += double(channel(value, c));
            }
    ValueType mean = uniform<ValueType>(0.0f);
    for (int c = 0; c < kChannels; ++c) setChannel(mean, c, -float(count > 0 ? sum[c] / count : 0.0));
    return mean;
}

template <class GridType>
void extend(GridType& grid) {
    using ValueType = typename GridType::ValueType;
    using Manager = openvdb::tree::LeafManager<typename GridType::TreeType>;
    // The grid has no tiles and must not get any: keeping tiles would prune leaves of one value, which the loops below
    // do not see, to tiles.
    openvdb::tools::dilateActiveValues(grid.tree(), 1, openvdb::tools::NN_FACE_EDGE_VERTEX,
                                       openvdb::tools::IGNORE_TILES);
    Manager leaves(grid.tree());
    leaves.foreach ([&](auto& leaf, std::size_t) {
        const typename GridType::ConstUnsafeAccessor accessor(grid.tree());
        for (auto on = leaf.beginValueOn(); on; ++on)
            if (std::isinf(channel(*on, 0))) on.setValue(meanOfNeighbours(accessor, on.getCoord()));
    });
    leaves.foreach ([](auto& leaf, std::size_t) {
        ValueType* const values = leaf.buffer().data();
        for (openvdb::Index i = 0; i < Manager::LeafNodeType::SIZE; ++i)
            for (int c = 0; c < channelCount<ValueType>(); ++c)
                setChannel(values[i], c, leaf.isValueOn(i) ? std::abs(channel(values[i], c)) : 0.0f);
    });
    grid.tree().root().setBackground(uniform<ValueType>(0.0f), /*updateChildNodes=*/true);
}

template <class GridType>
typename GridType::Ptr makeExtended(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                    const std::vector<BrickField>& fields) {
    auto grid = makeGrid<GridType>(layout, topology, fields, true);
    extend(*grid);
    return grid;
}

}  // namespace

openvdb::GridBase::Ptr gridFromFields(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                      const std::vector<BrickField>& fields) {
    if (fields.size() == 1) return makeGrid<openvdb::FloatGrid>(layout, topology, fields, false);
    return makeGrid<openvdb::Vec3SGrid>(layout, topology, fields, false);
}

openvdb::GridBase::Ptr extendedGridFromFields(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                              const std::vector<BrickField>& fields) {
    if (fields.size() == 1) return makeExtended<openvdb::FloatGrid>(layout, topology, fields);
    return makeExtended<openvdb::Vec3SGrid>(layout, topology, fields);
}

}  // namespace raysweep
