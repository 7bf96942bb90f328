#include "raysweep/reconstruct/support.h"

#include "raysweep/core/parallel.h"
#include "raysweep/projector/footprint.h"

#include <algorithm>
#include <cstdint>

namespace raysweep {
namespace {

/// How many pixels of a rectangle see something, in a constant number of steps (F. C. Crow, "Summed-area tables",
/// 1984).
class SeenPixels {
  public:
    SeenPixels(const Projections& projections, int view, float threshold)
        : stride_(projections.width + 1), sums_(std::size_t(stride_) * (projections.height + 1)) {
        const float* values = projections.view(view);
        for (int y = 0; y < projections.height; ++y) {
            std::uint32_t row = 0;
            for (int x = 0; x < projections.width; ++x) {
                row += !(values[std::size_t(y) * projections.width + x] <= threshold);  // NaN counts
                sums_[at(x + 1, y + 1)] = sums_[at(x + 1, y)] + row;
            }
        }
    }

    /// Pixels [low, high).
    bool none(const PixelBox& box) const {
        return sums_[at(box.highColumn, box.highRow)] - sums_[at(box.lowColumn, box.highRow)] -
                   sums_[at(box.highColumn, box.lowRow)] + sums_[at(box.lowColumn, box.lowRow)] ==
               0;
    }

  private:
    std::size_t at(int x, int y) const { return std::size_t(y) * stride_ + x; }

    int stride_;
    std::vector<std::uint32_t> sums_;
};

/// Pixels as the detector counts them.
PixelBox onDetector(PixelBox pixels, const JosephView& view) {
    if (view.flipped)
        pixels = {pixels.lowColumn, pixels.highColumn, view.height - pixels.highRow, view.height - pixels.lowRow};
    if (view.onSide) pixels = {pixels.lowRow, pixels.highRow, pixels.lowColumn, pixels.highColumn};
    return pixels;
}

}  // namespace

std::vector<ColumnRange> visualHull(const Projections& projections, const ProjectionGeometry& geometry,
                                    const ColumnLattice& lattice, float threshold) {
    const int blocksX = blocksFor(lattice.dims.x), blocksY = blocksFor(lattice.dims.y);
    const int chunks = (lattice.dims.z + kColumnChunk - 1) / kColumnChunk;
    std::vector<std::uint8_t> empty(std::size_t(blocksX) * blocksY * chunks);
    for (int n = 0; n < int(geometry.views.size()); ++n) {
        const JosephView view = josephView(geometry, n, lattice);
        const SeenPixels seen(projections, n, threshold);
        parallelFor(
            empty.size(),
            [&](std::size_t i) {
                if (empty[i]) return;
                VoxelBox box;
                box.low = Index3(int(i / chunks) / blocksY * kBlockEdge, int(i / chunks) % blocksY * kBlockEdge,
                                 int(i % chunks) * kColumnChunk);
                box.high = Index3(std::min(box.low.x + kBlockEdge, lattice.dims.x),
                                  std::min(box.low.y + kBlockEdge, lattice.dims.y),
                                  std::min(box.low.z + kColumnChunk, lattice.dims.z));
                if (!isOnDetector(box, view)) return;
                empty[i] = seen.none(onDetector(footprintOf(box, view), view));
            },
            64);
    }
    std::vector<ColumnRange> kept(std::size_t(blocksX) * blocksY);
    for (std::size_t block = 0; block < kept.size(); ++block)
        for (int chunk = 0; chunk < chunks; ++chunk) {
            if (empty[block * chunks + chunk]) continue;
            ColumnRange& range = kept[block];
            if (range.length() == 0) range.low = chunk * kColumnChunk;
            range.high = (chunk + 1) * kColumnChunk;
        }
    return kept;
}

}  // namespace raysweep
