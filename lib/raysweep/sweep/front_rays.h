/// The rays of one beam while they go through the volume.
#pragma once

#include "raysweep/core/zeroed_array.h"
#include "raysweep/sweep/beam.h"
#include "raysweep/sweep/brick_index.h"
#include "raysweep/sweep/ray_sums.h"

#include <cstddef>
#include <vector>

namespace raysweep {

constexpr float kLongAgo = -1e9f;  ///< a slice long before the first

/// Powers of the rays that may meet a brick, lattice row by lattice row: of each row there is room for the stretch from
/// the first to the last one that does. In a periodic volume they are all there. With the local furnace there are two
/// more planes. Memory is taken for rays near bricks only: rays in a wide gap, which would come out as they went in,
/// are not held, whatever the bounding box.
class FrontRays {
  public:
    FrontRays() = default;  ///< no rays
    /// @param margin rays next to the lattice that kernels touch too; they stay dark
    FrontRays(const Beam& beam, const BrickIndex& index, int margin, int channels, bool furnace);

    /// Ray u of lattice row v is at `power() + rowStarts()[v] + u`; the next channel's are `planeStride` on.
    float* power() { return rays_.data(); }
    const std::ptrdiff_t* rowStarts() const { return starts_.data() - rows_.begin; }
    std::size_t planeStride() const { return plane_; }
    /// Planes of f, and of the slice in which a ray was in a solid last.
    float* furnace() { return power() + std::size_t(channels_) * plane_; }
    float* lastSlice() { return furnace() + plane_; }
    /// `Lateral::shift` of slice k.
    int columnShift(int k) const { return column_.shift(k); }
    int rowShift(int k) const { return row_.shift(k); }

    /// Gives every ray that enters the volume its power.
    /// @param arriving rays from the repetition before, in a volume that is periodic along the sweep's axis, or null
    void enter(const Beam& beam, CrossingRays* arriving);
    /// Sums what the rays carry at the end. @param leaving takes those that go on to the next repetition, or null
    RaySums leave(const Beam& beam, CrossingRays* leaving);

  private:
    float* row(int v) { return power() + rowStarts()[v]; }
    RayRange& span(int v) { return spans_[std::size_t(v - rows_.begin)]; }
    void spanBricks(const RayFront& front, const BrickIndex& index);
    void makeRoom();
    /// Calls `visit(v, range)` for the rays that are held, row by row.
    template <class Visit>
    void forEachStretch(const Visit& visit);
    void arrive(const RayFront& front, CrossingRays& arriving);
    void goOn(const RayFront& front, CrossingRays& leaving);

    int channels_ = 0;
    bool furnace_ = false;
    RayRange rows_, columns_;
    Lateral column_, row_;
    std::vector<RayRange> usedRows_, usedColumns_;  ///< near bricks: ascending, apart
    ZeroedArray<RayRange> spans_;                   ///< of each row
    ZeroedArray<std::ptrdiff_t> starts_;
    std::size_t plane_ = 0;
    double entered_ = 0;  ///< rays that are held here and enter the volume
    ZeroedArray<float> rays_;
};

}  // namespace raysweep
