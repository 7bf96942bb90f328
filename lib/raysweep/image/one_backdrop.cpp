// One picture before a backdrop whose colour is known: see matteOfKnownBackdrop and matteOfThreshold in matting.h.
#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"
#include "raysweep/image/matte_builder.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// The matte of alpha that `alphaOf(colour)` gives, without its holes, and with the backdrop's share taken out.
template <class AlphaOf>
Matte matteBefore(const Image& picture, const Color& backdrop, double largestHole, const AlphaOf& alphaOf) {
    requireOpaquePicture(picture, "the picture");
    const auto colour = [&](std::size_t p) {
        return colourOf(&picture.pixels[p * std::size_t(picture.channels)], picture.channels);
    };
    std::vector<float> alpha(std::size_t(picture.width) * std::size_t(picture.height));
    for (std::size_t p = 0; p < alpha.size(); ++p) alpha[p] = std::min(std::max(alphaOf(colour(p)), 0.0f), 1.0f);
    Matte matte;
    fillHoles(alpha, picture.width, picture.height, largestHole * double(alpha.size()), matte.report);
    matte.image = Image(picture.width, picture.height, 4);
    for (std::size_t p = 0; p < alpha.size(); ++p)
        setPixel(matte.image, p, freed(colour(p), alpha[p], backdrop), alpha[p]);
    countCoverage(matte);
    return matte;
}

}  // namespace

Matte matteOfKnownBackdrop(const Image& picture, const MattingOptions& options) {
    options.validate();
    const float nearest = float(options.nearest), span = float(options.farthest) - nearest;
    return matteBefore(picture, options.backdrop, options.largestHole, [&](const Color& colour) {
        const Color difference = colour - options.backdrop;
        return (std::sqrt(difference.dot(difference)) - nearest) / span;
    });
}

Matte matteOfThreshold(const Image& picture, const MattingOptions& options) {
    options.validate();
    const float threshold = float(options.threshold);
    if (options.matting == MattingOptions::Matting::black)
        return matteBefore(picture, grey(0), options.largestHole,
                           [&](const Color& colour) { return srgbFromLinear(maxComponent(colour)) / threshold - 1; });
    if (options.matting == MattingOptions::Matting::white)
        return matteBefore(picture, grey(1), options.largestHole, [&](const Color& colour) {
            return (1 - srgbFromLinear(std::min({colour.x, colour.y, colour.z}))) / threshold - 1;
        });
    throw InvalidArgument("matting by a threshold needs a black or a white backdrop");
}

}  // namespace raysweep
