#include "raysweep/sweep/wavefront.h"

#include "raysweep/core/parallel.h"
#include "raysweep/sweep/sweep_volume.h"

#include <algorithm>
#include <map>

namespace raysweep {
namespace {

// Cells per thread along the shorter side of the table: enough that all threads have work soon after the first cell and
// until shortly before the last, few enough that it is worth while to hand one out.
constexpr int kCellsPerThread = 8;

int floorDivide(int a, int b) {
    return a >= 0 ? a / b : -((b - 1 - a) / b);
}

/// Shifts of a lateral axis over the eight slices of a layer.
RayRange shiftsIn(const Lateral& lateral, int slice) {
    const auto [least, most] = std::minmax({lateral.shift(slice), lateral.shift(slice + kBrickEdge - 1)});
    return {least, most + 1};
}

/// Calls `visit(i)` for the images (by i periods) of the volume that rays meet along a lateral axis in the layer at
/// `slice`, upwind ones first; without a period that is image 0.
template <class Visit>
void forEachImage(const RayFront& front, const Lateral& lateral, int slice, const Visit& visit) {
    if (!lateral.periodic) return visit(0);
    const RayRange shifts = shiftsIn(lateral, slice);
    const int period = lateral.size();
    const int first = floorDivide(lateral.low - front.reach + shifts.begin - lateral.high, period) + 1;
    const int last = floorDivide(lateral.high + shifts.end - 2 - lateral.low, period);
    for (int i = 0; i <= last - first; ++i) visit(lateral.slope >= 0 ? first + i : last - i);
}

/// Rows of a periodic volume as often as rays may meet them.
std::map<int, std::size_t> withImages(const RayFront& front, const std::map<int, std::size_t>& rows) {
    const auto [least, most] = std::minmax({front.row.shift(0), front.row.shift(front.slices - 1)});
    const int period = front.row.size();
    std::map<int, std::size_t> all;
    for (int i = floorDivide(least, period) - 1; i <= floorDivide(most, period) + 1; ++i)
        for (const auto& [row, bricks] : rows) all[row + i * period] = bricks;
    return all;
}

/// Bounds of pieces with about as many bricks each. @param bricks by the coordinate where they begin, ascending
std::vector<int> cut(const std::map<int, std::size_t>& bricks) {
    std::size_t all = 0;
    for (const auto& [at, count] : bricks) all += count;
    const std::size_t perPiece = all / std::size_t(kCellsPerThread * threadCount()) + 1;
    std::vector<int> bounds;
    std::size_t inPiece = perPiece;
    for (const auto& [at, count] : bricks) {
        if (inPiece >= perPiece) {
            bounds.push_back(at);
            inPiece = 0;
        }
        inPiece += count;
    }
    bounds.push_back(bricks.empty() ? 0 : bricks.rbegin()->first + kBrickEdge);
    return bounds;
}

}  // namespace

Wavefront::Wavefront(const SweepVolume& volume, const RayFront& front, const BrickIndex& index, bool withNeighbours)
    : volume_(volume),
      front_(front),
      index_(index),
      withNeighbours_(withNeighbours),
      rowsUp_(front.rowsUp()),
      columnsUp_(front.columnsUp()) {
    slabs_ = cut(index.countByLayer());
    strips_ = cut(front.row.periodic ? withImages(front, index.countByRow()) : index.countByRow());
}

std::vector<BrickVisit> Wavefront::visits(int slab, int strip) const {
    std::vector<BrickVisit> result;
    const auto piece = [](const std::vector<int>& bounds, bool up, int i) {
        const std::size_t at = std::size_t(up ? i : int(bounds.size()) - 2 - i);
        return RayRange{bounds[at], bounds[at + 1]};
    };
    const RayRange layers = piece(slabs_, front_.ascending, slab);
    const RayRange range = piece(strips_, rowsUp_, strip);
    const auto [first, last] = index_.findLayers(layers.begin, layers.end);
    for (std::size_t n = 0; n < last - first; ++n) {
        const BrickIndex::Layer& layer = index_.layers()[front_.ascending ? first + n : last - 1 - n];
        const int slice = front_.sliceNumber(layer.layer);
        forEachImage(front_, front_.row, slice, [&](int image) {
            const int offset = image * front_.row.size();
            const auto [firstRow, endRow] = index_.findRows(layer, range.begin - offset, range.end - offset);
            for (std::size_t i = 0; i < endRow - firstRow; ++i)
                addRow(index_.rows()[rowsUp_ ? firstRow + i : endRow - 1 - i], image, slice, result);
        });
    }
    return result;
}

void Wavefront::addRow(const BrickIndex::Row& row, int image, int slice, std::vector<BrickVisit>& to) const {
    forEachImage(front_, front_.column, slice, [&](int columnImage) {
        for (std::size_t i = 0; i < row.end - row.first; ++i)
            to.push_back(visitOf(index_.entries()[columnsUp_ ? row.first + i : row.end - 1 - i], row, columnImage,
                                 image, slice));
    });
}

BrickVisit Wavefront::visitOf(const BrickIndex::Entry& entry, const BrickIndex::Row& row, int columnImage, int rowImage,
                              int slice) const {
    BrickVisit visit{entry.brick,
                     entry.column + columnImage * front_.column.size(),
                     row.row + rowImage * front_.row.size(),
                     slice,
                     kNoBrick,
                     kNoBrick,
                     kNoBrick};
    if (!withNeighbours_) return visit;
    const auto beyond = [&](int rows, int columns) {
        Index3 origin;
        origin[front_.axis.major] = row.layer;
        origin[front_.axis.row] = row.row + rows * kBrickEdge;
        origin[front_.axis.column] = entry.column + columns * kBrickEdge;
        return volume_.map.find(wrapped(volume_.layout, volume_.periodic, origin));
    };
    visit.beyondRow = beyond(1, 0);
    visit.beyondColumn = beyond(0, 1);
    visit.beyondBoth = beyond(1, 1);
    return visit;
}

}  // namespace raysweep
