#include "raysweep/sweep/brick_index.h"

#include <algorithm>
#include <numeric>

namespace raysweep {

BrickIndex::BrickIndex(const std::vector<Index3>& origins, const std::vector<Index3>& margins, const SweepAxis& axis) {
    const auto origin = [&](std::size_t i) -> const Index3& {
        return i < origins.size() ? origins[i] : margins[i - origins.size()];
    };
    std::vector<std::size_t> order(origins.size() + margins.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        for (const int key : {axis.major, axis.row, axis.column})
            if (origin(a)[key] != origin(b)[key]) return origin(a)[key] < origin(b)[key];
        return false;
    });
    entries_.reserve(order.size());
    for (const std::size_t i : order) {
        const Index3& here = origin(i);
        const int layer = here[axis.major], row = here[axis.row];
        if (rows_.empty() || rows_.back().layer != layer || rows_.back().row != row)
            rows_.push_back({layer, row, entries_.size(), entries_.size()});
        entries_.push_back({i < origins.size() ? std::uint32_t(i) : kNoBrick, here[axis.column]});
        rows_.back().end = entries_.size();
        if (layers_.empty() || layers_.back().layer != layer) layers_.push_back({layer, rows_.size() - 1, 0});
        layers_.back().end = rows_.size();
        ++countByLayer_[layer];
        ++countByRow_[row];
    }
}

namespace {

using Places = std::pair<std::size_t, std::size_t>;  // half-open

/// Which places of `items` among these, where items ascend by `key`, have a key in [low, high).
template <class Item>
Places findBetween(const std::vector<Item>& items, const Places& among, int Item::*key, int low, int high) {
    const auto firstFrom = [&](int value) {
        const auto at = [&](std::size_t i) { return items.begin() + std::ptrdiff_t(i); };
        return std::size_t(std::lower_bound(at(among.first), at(among.second), value,
                                            [&](const Item& item, int bound) { return item.*key < bound; }) -
                           items.begin());
    };
    return {firstFrom(low), firstFrom(high)};
}

}  // namespace

std::pair<std::size_t, std::size_t> BrickIndex::findLayers(int low, int high) const {
    return findBetween(layers_, {0, layers_.size()}, &Layer::layer, low, high);
}

std::pair<std::size_t, std::size_t> BrickIndex::findRows(const Layer& layer, int low, int high) const {
    return findBetween(rows_, {layer.first, layer.end}, &Row::row, low, high);
}

std::vector<Index3> marginsBelow(const BrickLayout& layout, const BrickMap& map, const Periodic& periodic,
                                 const SweepAxis& axis) {
    std::vector<Index3> margins;
    for (const Index3& origin : layout.origins)
        for (int sides = 1; sides < 4; ++sides) {
            Index3 below = origin;
            if (sides & 1) below[axis.row] -= kBrickEdge;
            if (sides & 2) below[axis.column] -= kBrickEdge;
            below = wrapped(layout, periodic, below);
            if (map.find(below) == kNoBrick) margins.push_back(below);
        }
    std::sort(margins.begin(), margins.end(), lessOrigin);
    margins.erase(std::unique(margins.begin(), margins.end()), margins.end());
    return margins;
}

}  // namespace raysweep
