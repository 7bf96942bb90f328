/// The bricks that a sweep meets, cut into a table of cells: slabs of layers by strips of brick rows, both in the order
/// of travel, and each with about as many bricks as the next, wherever they are. What a ray meets in a cell comes after
/// what it met in the slab before and in the strip before, so cells can be worked off as a wavefront
/// (parallelWavefront), each by itself.
#pragma once

#include "raysweep/sweep/exchange.h"

#include <vector>

namespace raysweep {

struct SweepVolume;

class Wavefront {
  public:
    /// @param front of a beam whose way along the columns that of visits is to be  @param index with margins, if
    /// `withNeighbours`
    Wavefront(const SweepVolume& volume, const RayFront& front, const BrickIndex& index, bool withNeighbours);

    int slabs() const { return int(slabs_.size()) - 1; }
    int strips() const { return int(strips_.size()) - 1; }
    /// The bricks of a cell in the order of travel: layers, rows, columns. A row of bricks is whole.
    std::vector<BrickVisit> visits(int slab, int strip) const;

  private:
    void addRow(const BrickIndex::Row& row, int image, int slice, std::vector<BrickVisit>& to) const;
    BrickVisit visitOf(const BrickIndex::Entry& entry, const BrickIndex::Row& row, int columnImage, int rowImage,
                       int slice) const;

    const SweepVolume& volume_;
    const RayFront& front_;
    const BrickIndex& index_;
    bool withNeighbours_;
    bool rowsUp_, columnsUp_;
    // Where pieces begin, and the end; voxel coordinates, ascending.
    std::vector<int> slabs_, strips_;
};

}  // namespace raysweep
