/// The pixels that a fit of photographs takes its rays from.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/photo_fit.h"
#include "raysweep/reconstruct/photo_level.h"
#include "raysweep/reconstruct/photo_loss.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace raysweep {

/// All pixels of all pictures, numbered picture after picture, row after row.
class PhotoPixels {
  public:
    /// @param photographs kept by reference @throw InvalidArgument for 2^32 pixels and more
    explicit PhotoPixels(const std::vector<Photograph>& photographs);

    std::uint32_t count() const { return count_; }

    struct Place {
        const Photograph* photograph;
        int view, x, y;
    };
    Place place(std::uint32_t pixel) const;
    int view(std::uint32_t pixel) const;
    CompositeRay ray(std::uint32_t pixel, const PhotoLevel& level, int perSlice) const;
    PixelTarget target(std::uint32_t pixel) const;

  private:
    const std::vector<Photograph>& photographs_;
    std::vector<std::uint32_t> firsts_;
    std::uint32_t count_ = 0;
};

/// Pixels whose rays meet something. Those that are compared with but not fitted are left out in blocks, because
/// neighbours know each other.
struct PixelSets {
    std::vector<std::uint32_t> fitted, leftOut;
};
PixelSets pixelsMeeting(const PhotoPixels& pixels, const PhotoLevel& level, const PhotoFitOptions& options);

/// Rays of some pixels, in the order of their axes, and what they should see.
struct PhotoBatch {
    std::vector<std::uint32_t> pixels;
    std::vector<CompositeRay> rays;
    std::vector<PixelTarget> targets;
    std::vector<float> errors;  ///< losses

    void set(const PhotoPixels& all, const std::uint32_t* chosen, std::size_t count, const PhotoLevel& level,
             int perSlice);

    /// Sum of the errors.
    double error() const;

  private:
    std::vector<CompositeRay> unsorted_;
    std::vector<std::size_t> order_;
};

}  // namespace raysweep
