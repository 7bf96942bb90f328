/// How much two pictures differ.
#pragma once

#include "raysweep/image/image.h"

#include <optional>

namespace raysweep {

/// Differences over all pixels and channels.
struct ImageDifference {
    double rmse = 0;           ///< root of the mean squared difference
    double relativeRmse = 0;   ///< rmse / root mean square of the reference; infinite when that is 0 and rmse is not
    double psnr = 0;           ///< 20 log10(peak / rmse), dB; infinite for equal pictures
    double ssim = 0;           ///< structural similarity, mean over pixels and channels; 1 for equal pictures
    double maxDifference = 0;  ///< largest absolute difference
};

/// Compares `image` with `reference`. SSIM is that of Wang, Bovik, Sheikh, Simoncelli, "Image quality assessment: from
/// error visibility to structural similarity", 2004: Gaussian window of 11 x 11 pixels with sigma 1.5, K1 = 0.01,
/// K2 = 0.03, over the pixels whose window lies inside the picture; smaller pictures get the largest odd window that
/// fits. A NaN anywhere makes every figure NaN, so that no threshold passes.
/// @param peak value that counts as full scale in PSNR and SSIM.
/// @throw InvalidArgument if the pictures are empty or differ in width, height or channels, or peak is not positive.
ImageDifference compareImages(const Image& image, const Image& reference, double peak = 1);

/// Of pictures of two or four channels, the last of which is alpha, or of which one has an alpha that the other lacks
/// (it counts as 1).
struct PictureDifference {
    ImageDifference color;
    std::optional<ImageDifference> alpha;  ///< none if neither has alpha
};

/// Compares colours, and apart from them alpha. @throw InvalidArgument as compareImages does
PictureDifference comparePictures(const Image& image, const Image& reference, double peak = 1);

/// The figures by which pictures that are to look alike are judged: of RGB pictures in display-encoded values (see
/// shownBefore), as is usual. `ssim` is the mean over channels. NaN and errors as compareImages; so is what one of them
/// costs, ask that for both.
double psnr(const Image& image, const Image& reference, double peak = 1);
double ssim(const Image& image, const Image& reference, double peak = 1);

}  // namespace raysweep
