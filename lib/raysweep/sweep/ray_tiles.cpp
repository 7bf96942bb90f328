#include "raysweep/sweep/ray_tiles.h"

#include <algorithm>
#include <unordered_map>

namespace raysweep {
namespace {

/// The lattice along one lateral axis, cut into pieces of 2^bits rays.
struct Cut {
    RayRange extent;
    int bits;

    int count() const { return ((extent.size() - 1) >> bits) + 1; }
    int pieceOf(int ray) const { return (ray - extent.begin) >> bits; }
    RayRange piece(int i) const {
        const int begin = extent.begin + (i << bits);
        return {begin, i + 1 < count() ? begin + (1 << bits) : extent.end};
    }
};

/// With `linear` a periodic axis needs an even number of full pieces, or one, for neighbours across the border to
/// differ in colour.
Cut cutLateral(const RayFront& front, const Lateral& lateral, int bits) {
    constexpr int kOnePiece = 30;
    const RayRange extent = rayExtent(front, lateral);
    const bool onePiece = lateral.periodic && front.reach > 0 && extent.size() % (2 << bits) != 0;
    return {extent, onePiece ? kOnePiece : bits};
}

/// Rays that a brick at lateral coordinate 0 meets in the eight slices of its layer.
struct LayerReach {
    int step;
    RayRange columns, rows;

    LayerReach(const RayFront& front, int firstStep)
        : step(firstStep), columns(of(front, front.column)), rows(of(front, front.row)) {}

    RayRange of(const RayFront& front, const Lateral& lateral) const {
        const auto [least, most] = std::minmax({lateral.shift(step), lateral.shift(step + kBrickEdge - 1)});
        return {-front.reach - most, kBrickEdge - least};
    }
};

/// Pieces [first, last] of a cut that meet rays [low + reach.begin, low + reach.end).
struct Pieces {
    int first, last;
    Pieces(const Cut& cut, const RayRange& reach, int low)
        : first(cut.pieceOf(std::max(low + reach.begin, cut.extent.begin))),
          last(cut.pieceOf(std::min(low + reach.end, cut.extent.end) - 1)) {}
};

struct TileVisit {
    std::uint32_t tile;
    BrickVisit visit;
};

/// Numbers the tiles in the order in which they are first met.
class TileNumbers {
  public:
    TileNumbers(const Cut& columns, const Cut& rows) : columns_(columns), rows_(rows) {
        const std::uint64_t all = std::uint64_t(columns.count()) * std::uint64_t(rows.count());
        if (all <= kDenseLimit) dense_.assign(all, kNone);
    }

    std::uint32_t number(int column, int row) {
        const std::uint64_t key = std::uint64_t(row) * std::uint64_t(columns_.count()) + std::uint64_t(column);
        std::uint32_t& slot = dense_.empty() ? sparse_.try_emplace(key, kNone).first->second : dense_[key];
        if (slot == kNone) {
            slot = std::uint32_t(tiles_.size());
            tiles_.push_back({columns_.piece(column), rows_.piece(row), nullptr, nullptr});
            colour_.push_back((column % 2) + 2 * (row % 2));
        }
        return slot;
    }

    const std::vector<RayTile>& tiles() const { return tiles_; }
    int colour(std::uint32_t tile) const { return colour_[tile]; }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr std::uint64_t kDenseLimit = 1u << 16;
    Cut columns_, rows_;
    std::vector<std::uint32_t> dense_;
    std::unordered_map<std::uint64_t, std::uint32_t> sparse_;
    std::vector<RayTile> tiles_;
    std::vector<int> colour_;
};

/// Calls `meet(low)` for the brick coordinate `low`, or in a periodic volume for each of its images, that meets rays of
/// `cut`.
template <class Meet>
void forEachImage(const Lateral& lateral, const Cut& cut, const RayRange& reach, int low, const Meet& meet) {
    if (!lateral.periodic) return meet(low);
    const int period = lateral.size();
    const auto floorDivide = [](int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); };
    // Upwind images first: a ray that leaves on one side comes in again on the other.
    const int first = floorDivide(cut.extent.begin - (low + reach.end), period) + 1;
    const int last = floorDivide(cut.extent.end - 1 - (low + reach.begin), period);
    for (int i = first; i <= last; ++i) meet(low + i * period);
}

/// Visits in a periodic volume are found brick by brick; a ray must meet them upwind to downwind.
void sortPeriodic(const RayFront& front, std::vector<TileVisit>& pairs) {
    const int u = front.column.slope < 0 ? -1 : 1, v = front.row.slope < 0 ? -1 : 1;
    std::stable_sort(pairs.begin(), pairs.end(), [&](const TileVisit& a, const TileVisit& b) {
        if (a.visit.step != b.visit.step) return a.visit.step < b.visit.step;
        if (a.visit.row != b.visit.row) return v * a.visit.row < v * b.visit.row;
        return u * a.visit.column < u * b.visit.column;
    });
}

/// Gathers each tile's visits, tiles ordered by colour.
RayTiles groupByTile(const TileNumbers& numbers, const std::vector<TileVisit>& pairs) {
    const std::size_t count = numbers.tiles().size();
    std::vector<std::uint32_t> order;
    RayTiles result;
    for (int colour = 0; colour < 4; ++colour) {
        result.colours.push_back(order.size());
        for (std::uint32_t t = 0; t < count; ++t)
            if (numbers.colour(t) == colour) order.push_back(t);
    }
    result.colours.push_back(order.size());

    std::vector<std::size_t> next(count, 0);
    for (const TileVisit& pair : pairs) ++next[pair.tile];
    std::size_t sum = 0;
    std::vector<std::size_t> begins;
    for (const std::uint32_t t : order) {
        begins.push_back(sum);
        const std::size_t size = next[t];
        next[t] = sum;
        sum += size;
    }
    result.visits.resize(pairs.size());
    for (const TileVisit& pair : pairs) result.visits[next[pair.tile]++] = pair.visit;
    for (std::size_t i = 0; i < count; ++i) {
        RayTile tile = numbers.tiles()[order[i]];
        tile.begin = result.visits.data() + begins[i];
        tile.end = result.visits.data() + next[order[i]];
        result.tiles.push_back(tile);
    }
    return result;
}

}  // namespace

RayTiles cutIntoTiles(const RayFront& front, const BrickLayout& layout, const TileIndex& index) {
    const Cut columns = cutLateral(front, front.column, kTileColumnBits);
    const Cut rows = cutLateral(front, front.row, kTileRowBits);
    TileNumbers numbers(columns, rows);
    std::vector<TileVisit> pairs;
    pairs.reserve(2 * layout.brickCount());

    LayerReach reach(front, 0);
    index.forEach(front.ascending, front.row.slope >= 0, front.column.slope >= 0, [&](std::uint32_t b) {
        const Index3& origin = layout.origins[b];
        const int step = front.firstStep(origin[front.axis.major]);
        if (step != reach.step) reach = LayerReach(front, step);
        forEachImage(front.row, rows, reach.rows, origin[front.axis.row], [&](int row) {
            forEachImage(front.column, columns, reach.columns, origin[front.axis.column], [&](int column) {
                const Pieces v(rows, reach.rows, row), u(columns, reach.columns, column);
                for (int r = v.first; r <= v.last; ++r)
                    for (int c = u.first; c <= u.last; ++c)
                        pairs.push_back({numbers.number(c, r), {b, column, row, step}});
            });
        });
    });
    // Rays that come from another repetition are there whether they meet a brick or not.
    for (int r = 0; front.periodic && r < rows.count(); ++r)
        for (int c = 0; c < columns.count(); ++c) numbers.number(c, r);
    if (front.column.periodic || front.row.periodic) sortPeriodic(front, pairs);
    return groupByTile(numbers, pairs);
}

}  // namespace raysweep
