#include "raysweep/volume/deposit.h"

#include "raysweep/core/memory.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/channels.h"
#include "raysweep/volume/overlap.h"

namespace raysweep {
namespace {

constexpr std::size_t kChunks = 16;  ///< that are filled by themselves and added up in order
constexpr int kLeafVoxels = 512;

/// One amount for each channel.
struct Amount {
    double value[3] = {0, 0, 0};
    Amount& operator+=(const Amount& other) {
        for (int c = 0; c < 3; ++c) value[c] += other.value[c];
        return *this;
    }
};

template <class GridType>
Amount amountOf(const GridType& grid) {
    using Value = typename GridType::ValueType;
    return sumOverActive<Amount>(grid, [](Amount& sum, const Value& value, const openvdb::CoordBBox& box) {
        for (int c = 0; c < kChannels<Value>; ++c) sum.value[c] += double(channel(value, c)) * double(box.volume());
    });
}

template <class GridType>
void addTo(GridType& sum, const GridType& more) {
    auto to = sum.getAccessor();
    forEachActive(more, [&](const auto& value, const openvdb::CoordBBox& box) {
        to.setValueOn(box.min(), to.getValue(box.min()) + value);
    });
}

template <class GridType>
typename GridType::Ptr depositOf(const std::vector<ActiveBlock<const GridType>>& blocks, std::size_t first,
                                 std::size_t end, const Overlap& overlap) {
    using Value = typename GridType::ValueType;
    auto part = GridType::create(openvdb::zeroVal<Value>());
    auto to = part->getAccessor();
    for (std::size_t i = first; i < end; ++i)
        forEachActive(blocks[i], [&](const Value& value, const openvdb::CoordBBox& box) {
            if (value == openvdb::zeroVal<Value>()) return;
            const double amount = overlap.volumeRatio() * double(box.volume());
            overlap.forEachPart(box, [&](const openvdb::Coord& at, double share) {
                to.setValueOn(at, to.getValue(at) + value * float(amount * share));
            });
        });
    return part;
}

/// Takes back what rounding of many small parts has added or lost.
template <class GridType>
void scaleTo(GridType& grid, const Amount& whole) {
    const Amount now = amountOf(grid);
    forEachActive(grid, [&](auto& value, const openvdb::CoordBBox&) {
        for (int c = 0; c < kChannels<typename GridType::ValueType>; ++c)
            if (now.value[c] > 0) channel(value, c) = float(double(channel(value, c)) * whole.value[c] / now.value[c]);
    });
}

template <class GridType>
typename GridType::Ptr deposited(const GridType& grid, const openvdb::math::Transform& transform) {
    const Overlap overlap(grid, transform);
    requireMemory(double(grid.activeVoxelCount()) * overlap.volumeRatio() / kLeafVoxels,
                  sizeof(typename GridType::ValueType));
    const auto blocks = activeBlocks(grid);
    std::vector<typename GridType::Ptr> parts(kChunks);
    parallelFor(kChunks, [&](std::size_t n) {
        parts[n] = depositOf<GridType>(blocks, blocks.size() * n / kChunks, blocks.size() * (n + 1) / kChunks, overlap);
    });
    const typename GridType::Ptr sum = parts[0];
    for (std::size_t n = 1; n < kChunks; ++n) {
        addTo(*sum, *parts[n]);
        parts[n].reset();
    }
    Amount whole = amountOf(grid);
    for (double& value : whole.value) value *= overlap.volumeRatio();
    scaleTo(*sum, whole);
    sum->setName(grid.getName());
    sum->setTransform(transform.copy());
    return sum;
}

}  // namespace

openvdb::GridBase::ConstPtr depositedOnto(const openvdb::GridBase::ConstPtr& grid,
                                          const openvdb::math::Transform& transform) {
    if (grid->transform() == transform) return grid;
    return withTypedGrid(*grid,
                         [&](const auto& typed) -> openvdb::GridBase::ConstPtr { return deposited(typed, transform); });
}

}  // namespace raysweep
