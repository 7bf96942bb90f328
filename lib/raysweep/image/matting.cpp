#include "raysweep/image/matting.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"
#include "raysweep/image/matte_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace raysweep {
namespace {

bool isWithin(const Color& colour, float lowest, float highest) {
    const auto holds = [&](float value) { return value >= lowest && value <= highest; };
    return holds(colour.x) && holds(colour.y) && holds(colour.z);
}

std::string sizeOf(const Image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height);
}

/// The mask in the picture's size.
Image fitted(const Image& mask, const Image& picture) {
    const int shrink = std::max(1, mask.width / picture.width), grow = std::max(1, picture.width / mask.width);
    if (mask.width * grow != picture.width * shrink || mask.height * grow != picture.height * shrink)
        throw InvalidArgument("the mask's size " + sizeOf(mask) + " does not fit the picture's, " + sizeOf(picture) +
                              "; it must be the same or a whole multiple or fraction");
    Image result(picture.width, picture.height, 1);
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x) {
            double sum = 0;
            for (int j = 0; j < shrink; ++j)
                for (int i = 0; i < shrink; ++i)
                    sum += double(*mask.at((x * shrink + i) / grow, (y * shrink + j) / grow));
            *result.at(x, y) = float(sum / (double(shrink) * shrink));
        }
    return result;
}

/// A pixel of a picture with alpha. @return what is wrong with it
struct Impossible {
    bool outOfRange, colourOfNothing;
};

Impossible setFromAlpha(Matte& matte, std::size_t p, const float* pixel, int channels, const MattingOptions& options) {
    const float tolerance = float(options.tolerance), stored = pixel[channels - 1];
    const float alpha = std::min(std::max(stored, 0.0f), 1.0f);
    Color colour = colourOf(pixel, channels);
    if (options.straightAlpha) colour *= alpha;
    const float lowest = std::min({colour.x, colour.y, colour.z});
    const Impossible found = {stored < -tolerance || stored > 1 + tolerance || lowest < -tolerance,
                              alpha == 0 && maxComponent(colour) > tolerance};
    colour = Color(std::max(colour.x, 0.0f), std::max(colour.y, 0.0f), std::max(colour.z, 0.0f));
    setPixel(matte.image, p, alpha > 0 ? colour : grey(0), alpha);
    return found;
}

}  // namespace

void MattingOptions::validate() const {
    const auto text = [](const Color& c) {
        return std::to_string(c.x) + "," + std::to_string(c.y) + "," + std::to_string(c.z);
    };
    constexpr float kMost = std::numeric_limits<float>::max();
    requireField(isWithin(backdrop, 0, 1), "backdrop", text(backdrop), "in [0,1]");
    requireField(isWithin(whiteBackdrop, 0, kMost), "whiteBackdrop", text(whiteBackdrop), "finite and not negative");
    requireField(isWithin(blackBackdrop, 0, kMost), "blackBackdrop", text(blackBackdrop), "finite and not negative");
    const Color difference = whiteBackdrop - blackBackdrop;
    requireField(difference.dot(difference) >= 1e-4f, "whiteBackdrop", text(whiteBackdrop),
                 "at least 0.01 away from blackBackdrop");
    requireField(nearest >= 0 && std::isfinite(nearest), "nearest", nearest, "finite and not negative");
    requireField(farthest > nearest && std::isfinite(farthest), "farthest", farthest, "finite and more than nearest");
    requireField(threshold > 0 && threshold <= 0.5, "threshold", threshold, "in (0,0.5]");
    requireField(largestHole >= 0 && largestHole <= 1, "largestHole", largestHole, "in [0,1]");
    requireField(tolerance > 0 && tolerance < 1, "tolerance", tolerance, "in (0,1)");
    requireField(searchRadius >= 0 && searchRadius <= 64, "searchRadius", searchRadius, "in [0,64]");
}

Matte matteOfAlpha(const Image& picture, const MattingOptions& options) {
    options.validate();
    requirePicture(picture, "the picture");
    if (picture.channels % 2 != 0)
        throw InvalidArgument(
            "the picture has no alpha; give one that has, or say how to tell the object from its backdrop");
    Matte matte;
    matte.image = Image(picture.width, picture.height, 4);
    matte.inconsistent.assign(matte.image.pixels.size() / 4, 0);
    for (std::size_t p = 0; p < matte.inconsistent.size(); ++p) {
        const float* const pixel = &picture.pixels[p * std::size_t(picture.channels)];
        const Impossible found = setFromAlpha(matte, p, pixel, picture.channels, options);
        matte.report.outOfRange += found.outOfRange;
        matte.report.disagreeing += found.colourOfNothing;
        matte.report.inconsistent += matte.inconsistent[p] = found.outOfRange || found.colourOfNothing;
    }
    countCoverage(matte);
    return matte;
}

Matte matteOfMask(const Image& picture, const Image& mask) {
    requirePicture(picture, "the picture");
    requirePicture(mask, "the mask");
    if (mask.channels != 1)
        throw InvalidArgument("the mask has " + std::to_string(mask.channels) + " channels; give one");
    if (std::any_of(mask.pixels.begin(), mask.pixels.end(), [](float value) { return value < 0 || value > 1; }))
        throw InvalidArgument("the mask has values outside [0,1]");
    const Image coverage = fitted(mask, picture);
    Matte matte;
    matte.image = Image(picture.width, picture.height, 4);
    for (std::size_t p = 0; p < coverage.pixels.size(); ++p) {
        const float* const pixel = &picture.pixels[p * std::size_t(picture.channels)];
        const float own = picture.channels % 2 == 0 ? pixel[picture.channels - 1] : 1.0f;
        const float alpha = coverage.pixels[p] * std::min(std::max(own, 0.0f), 1.0f);
        const Color colour = colourOf(pixel, picture.channels) * coverage.pixels[p];
        setPixel(matte.image, p, Color(std::max(colour.x, 0.0f), std::max(colour.y, 0.0f), std::max(colour.z, 0.0f)),
                 alpha);
    }
    countCoverage(matte);
    return matte;
}

Matte matteOf(const MattingInput& input, const MattingOptions& options) {
    using Matting = MattingOptions::Matting;
    options.validate();
    switch (options.matting) {
        case Matting::alpha:
            return matteOfAlpha(input.picture, options);
        case Matting::whiteBlack:
            return matteOfPair(input.picture, input.partner, options);
        case Matting::known:
            return matteOfKnownBackdrop(input.picture, options);
        case Matting::masks:
            return matteOfMask(input.picture, input.partner);
        default:
            return matteOfThreshold(input.picture, options);
    }
}

}  // namespace raysweep
