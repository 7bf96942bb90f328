#include "raysweep/sweep/tile_index.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace raysweep {

TileIndex::TileIndex(const std::vector<Index3>& origins, const std::vector<Index3>& margins, const SweepAxis& axis) {
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
    }
}

std::pair<std::size_t, std::size_t> TileIndex::find(int layer, int rowLow, int rowHigh) const {
    const auto firstFrom = [&](int row) {
        const auto found = std::lower_bound(rows_.begin(), rows_.end(), row, [&](const Row& a, int b) {
            return a.layer != layer ? a.layer < layer : a.row < b;
        });
        return std::size_t(found - rows_.begin());
    };
    return {firstFrom(rowLow), firstFrom(rowHigh)};
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
    const auto key = [](const Index3& a) { return std::make_tuple(a.x, a.y, a.z); };
    std::sort(margins.begin(), margins.end(), [&](const Index3& a, const Index3& b) { return key(a) < key(b); });
    margins.erase(
        std::unique(margins.begin(), margins.end(), [&](const Index3& a, const Index3& b) { return key(a) == key(b); }),
        margins.end());
    return margins;
}

}  // namespace raysweep
