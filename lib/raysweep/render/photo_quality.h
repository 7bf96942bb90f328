/// How well a volume shows what photographs show.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/core/progress.h"
#include "raysweep/render/render.h"
#include "raysweep/render/shading.h"
#include "raysweep/volume/color_volume.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

struct PhotoQualityOptions {
    float backdrop = 1;                     ///< on which both are compared, display-encoded grey, in [0,1]; 1 is white
    Shading shading;                        ///< of the photographs, in world space
    std::optional<PhotoCamera> lampBeside;  ///< the lamp goes along with the camera, and `shading` is as for this one;
                                            ///< none: it stands still
    /// Takes the colours that a camera sees in place of the volume's, such as directional ones; none: they are the same
    /// from all sides. Without `shading`.
    std::function<openvdb::Vec3SGrid::ConstPtr(const PhotoCamera& camera)> colors;
    RenderOptions picture;  ///< sampling; its `background` is not looked at

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

struct ViewQuality {
    std::string name;     ///< of the photograph
    double psnr = 0;      ///< dB, full scale 1; infinite for equal pictures
    double ssim = 0;      ///< mean over channels
    double residual = 0;  ///< RMS difference over the pixels where photograph or render show anything, display-encoded;
                          ///< 0 if there are none
};

struct PhotoQuality {
    std::vector<ViewQuality> views;  ///< in the order of the photographs; less if it was stopped
    double psnr = 0, ssim = 0;       ///< means over views; NaN without any
    double seconds = 0;
    bool complete = true;  ///< false if `progress` asked to stop
};

/// Called with each photograph's render: RGBA, linear, premultiplied.
using SeeRender = std::function<void(std::size_t view, const Image& render)>;

/// Renders the volume as each photograph's camera sees it, and compares both as files with alpha are judged: straight
/// colours encoded for display, mixed with the backdrop in that encoding (`shownBefore`).
/// @throw InvalidArgument for invalid options, cameras and volumes, and photographs of another size than their cameras
PhotoQuality judge(const ColorVolume& volume, const std::vector<Photograph>& photographs,
                   const PhotoQualityOptions& options = {}, const SeeRender& see = {},
                   const ProgressCallback& progress = {});

/// The same pictures beside each other on the backdrop: photograph, render, and twice their difference, grey where
/// there is none. RGB, linear, three times as wide as the photograph.
/// @throw InvalidArgument unless both are RGBA and of one size
Image comparisonPicture(const Image& photograph, const Image& render, float backdrop = 1);

/// Views that the volume shows so much worse than the others that something must be wrong with them: a pose, a
/// backdrop, an object that has moved. With r a view's residual, those with
///
///     ln r > median + max(5 x 1.4826 MAD, ln 1.5),
///
/// medians over all views; ratios, as residuals are all small or all large. None if there are fewer than 5.
/// @return indices, the worst first
std::vector<std::size_t> viewsStandingOut(const std::vector<ViewQuality>& views);

}  // namespace raysweep
