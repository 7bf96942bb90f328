#include "raysweep/sweep/wavefront.h"

#include "raysweep/core/parallel.h"
#include "raysweep/sweep/sweep.h"

#include <algorithm>

namespace raysweep {
namespace {

// Cells per thread along the shorter side of the table: enough that all threads have work soon after the first cell and
// until shortly before the last, few enough that it is worth while to hand one out.
constexpr int kCellsPerThread = 8;

int floorDivide(int a, int b) {
    return a >= 0 ? a / b : -((b - 1 - a) / b);
}

/// Shifts of a lateral axis over the eight slices of a layer.
RayRange shiftsIn(const Lateral& lateral, int step) {
    const auto [least, most] = std::minmax({lateral.shift(step), lateral.shift(step + kBrickEdge - 1)});
    return {least, most + 1};
}

/// Calls `visit(i)` for the images (by i periods) of coordinates [low, high) that rays meet in the layer at `step`,
/// upwind ones first; without a period that is image 0.
template <class Visit>
void forEachImage(const RayFront& front, const Lateral& lateral, int step, int low, int high, bool up,
                  const Visit& visit) {
    if (!lateral.periodic) return visit(0);
    const RayRange shifts = shiftsIn(lateral, step);
    const int period = lateral.size();
    const int first = floorDivide(lateral.low - front.reach + shifts.begin - high, period) + 1;
    const int last = floorDivide(lateral.high + shifts.end - 2 - low, period);
    for (int i = 0; i <= last - first; ++i) visit(up ? first + i : last - i);
}

}  // namespace

Wavefront::Wavefront(const SweepVolume& volume, const RayFront& front, const TileIndex& index, bool withNeighbours)
    : volume_(volume),
      front_(front),
      index_(index),
      withNeighbours_(withNeighbours),
      rowsUp_(front.row.slope >= 0),
      columnsUp_(front.column.slope >= 0) {
    const Lateral& row = front.row;
    rows_ = {row.low - (withNeighbours ? kBrickEdge : 0), row.high};
    if (row.periodic) {
        const auto [least, most] = std::minmax({row.shift(0), row.shift(front.slices - 1)});
        rows_ = {rows_.begin + std::min(0, floorDivide(least, kBrickEdge) * kBrickEdge),
                 rows_.end + std::max(0, floorDivide(most + kBrickEdge, kBrickEdge) * kBrickEdge)};
    }
    const int most = kCellsPerThread * threadCount();
    const auto cut = [&](int voxels, int& perPiece) {
        const int bricks = voxels / kBrickEdge;
        perPiece = std::max(1, (bricks + most - 1) / most) * kBrickEdge;
        return (voxels + perPiece - 1) / perPiece;
    };
    slabs_ = cut(front.slices, slabSlices_);
    strips_ = cut(rows_.size(), stripRows_);
}

std::vector<BrickVisit> Wavefront::visits(int slab, int strip) const {
    std::vector<BrickVisit> result;
    const int low =
        rowsUp_ ? rows_.begin + strip * stripRows_ : std::max(rows_.begin, rows_.end - (strip + 1) * stripRows_);
    const int high = rowsUp_ ? std::min(rows_.end, low + stripRows_) : rows_.end - strip * stripRows_;
    const int begin = slab * slabSlices_, end = std::min(front_.slices, begin + slabSlices_);
    const auto [first, last] = front_.ascending
                                   ? index_.findLayers(front_.firstSlice + begin, front_.firstSlice + end)
                                   : index_.findLayers(front_.firstSlice - end + 1, front_.firstSlice - begin + 1);
    for (std::size_t n = 0; n < last - first; ++n) {
        const TileIndex::Layer& layer = index_.layers()[front_.ascending ? first + n : last - 1 - n];
        const int step = front_.firstStep(layer.layer);
        forEachImage(front_, front_.row, step, front_.row.low, front_.row.high, rowsUp_, [&](int image) {
            const int offset = image * front_.row.size();
            const auto [firstRow, endRow] = index_.findRows(layer, low - offset, high - offset);
            for (std::size_t i = 0; i < endRow - firstRow; ++i)
                addRow(index_.rows()[rowsUp_ ? firstRow + i : endRow - 1 - i], image, step, result);
        });
    }
    return result;
}

void Wavefront::addRow(const TileIndex::Row& row, int image, int step, std::vector<BrickVisit>& to) const {
    forEachImage(front_, front_.column, step, front_.column.low, front_.column.high, columnsUp_, [&](int columnImage) {
        for (std::size_t i = 0; i < row.end - row.first; ++i)
            to.push_back(
                visitOf(index_.entries()[columnsUp_ ? row.first + i : row.end - 1 - i], row, columnImage, image, step));
    });
}

BrickVisit Wavefront::visitOf(const TileIndex::Entry& entry, const TileIndex::Row& row, int columnImage, int rowImage,
                              int step) const {
    BrickVisit visit{entry.brick,
                     entry.column + columnImage * front_.column.size(),
                     row.row + rowImage * front_.row.size(),
                     step,
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
