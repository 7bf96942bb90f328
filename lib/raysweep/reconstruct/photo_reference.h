/// Volumes that are known, in the bricks of a reconstruction: what it starts from, and what it should become.
#pragma once

#include "raysweep/projector/composite_volume.h"
#include "raysweep/reconstruct/photo_result.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/volume/color_volume.h"

#include <functional>
#include <vector>

namespace raysweep {

/// Opacity of a voxel's edge in place of extinction, and colour times it: what RMS differences are taken of.
CompositeVoxel matterOf(const CompositeVoxel& voxel);

/// Calls `body(voxel, extinction of its edge and colour)` for the active voxels of a volume that lie in the grid.
/// @param what the volume is, for the message @throw InvalidArgument unless its voxels are where those of the grid are
void forVoxelsIn(const ReconstructionGrid& grid, const ColorVolume& volume, const char* what,
                 const std::function<void(const Index3& at, const CompositeVoxel& voxel)>& body);

/// What a reconstruction is compared with.
class PhotoReference {
  public:
    /// @param layout kept by reference @throw InvalidArgument as forVoxelsIn
    PhotoReference(const ColorVolume& volume, const ReconstructionGrid& grid, const CompositeLayout& layout);

    /// Sets a point's RMS difference over all voxels of the grid.
    /// @param matter of the voxel at an index of the layout, as matterOf has it
    void compare(const std::function<CompositeVoxel(std::size_t voxel)>& matter, PhotoPoint& point) const;

  private:
    /// Sums of squares.
    struct Squares {
        double opacity = 0, color = 0;
        Squares& operator+=(const Squares& other);
    };
    static Squares squares(const CompositeVoxel& a, const CompositeVoxel& b);

    const CompositeLayout& layout_;
    std::vector<CompositeVoxel> matter_;
    Squares outside_;  ///< of what lies in no brick
    double total_;     ///< voxels of the grid
};

}  // namespace raysweep
