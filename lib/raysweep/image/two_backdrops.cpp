// A pair of pictures before two backdrops: see matteOfPair in matting.h for equation and source.
#include "raysweep/core/error.h"
#include "raysweep/image/matte_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace raysweep {
namespace {

constexpr std::size_t kSamples = 8000;  ///< pixels at which shifts are tried: their mean is good to some percent
constexpr double kClearly = 0.75;       ///< a better shift leaves less than this share of the inconsistency
constexpr double kRounding = 1e-8;      ///< inconsistency that floats and nothing else leave, with room

/// What the six equations of a pixel say.
struct Triangulated {
    float uncovered;     ///< 1 - alpha by least squares, not clamped
    float outOfRange;    ///< how far alpha is outside [0,1]
    float disagreement;  ///< what the equation of the channel that fits worst is off by
    double square;       ///< of all that does not fit
};

struct Backdrops {
    Color white, black, difference;
    float square;  ///< |W - B|^2
    explicit Backdrops(const MattingOptions& options)
        : white(options.whiteBackdrop),
          black(options.blackBackdrop),
          difference(white - black),
          square(difference.dot(difference)) {}
};

Triangulated triangulate(const Color& onWhite, const Color& onBlack, const Backdrops& backdrops) {
    const Color change = onWhite - onBlack;
    Triangulated result;
    result.uncovered = change.dot(backdrops.difference) / backdrops.square;
    result.outOfRange = std::max({0.0f, -result.uncovered, result.uncovered - 1});
    const Color misfit = change - backdrops.difference * result.uncovered;
    result.disagreement = std::max({std::abs(misfit.x), std::abs(misfit.y), std::abs(misfit.z)});
    result.square =
        double(misfit.dot(misfit)) + double(result.outOfRange) * double(result.outOfRange) * double(backdrops.square);
    return result;
}

/// A rectangle of pixels, the ends not included.
struct Window {
    int left, top, right, bottom;
    std::size_t pixels() const { return std::size_t(right - left) * std::size_t(bottom - top); }
};

bool shows(const Image& picture, int x, int y, const Color& backdrop, float tolerance) {
    const Color difference = colourOf(picture.at(x, y), picture.channels) - backdrop;
    return std::max({std::abs(difference.x), std::abs(difference.y), std::abs(difference.z)}) <= tolerance;
}

/// Around all that is not backdrop in both pictures, and `reach` more, but `reach` away from their border.
Window windowAround(const Image& onWhite, const Image& onBlack, const MattingOptions& options, int reach) {
    Window window = {onWhite.width, onWhite.height, 0, 0};
    const float tolerance = float(options.tolerance);
    for (int y = 0; y < onWhite.height; ++y)
        for (int x = 0; x < onWhite.width; ++x) {
            if (shows(onWhite, x, y, options.whiteBackdrop, tolerance) &&
                shows(onBlack, x, y, options.blackBackdrop, tolerance))
                continue;
            window.left = std::min(window.left, x), window.right = std::max(window.right, x + 1);
            window.top = std::min(window.top, y), window.bottom = std::max(window.bottom, y + 1);
        }
    window.left = std::max(window.left - reach, reach), window.top = std::max(window.top - reach, reach);
    window.right = std::min(window.right + reach, onWhite.width - reach);
    window.bottom = std::min(window.bottom + reach, onWhite.height - reach);
    return window;
}

/// Every how manyth pixel of `window` is asked: odd and no divisor of the width, so that every column is come by soon.
std::size_t strideOf(const Window& window) {
    const std::size_t width = std::size_t(window.right - window.left);
    std::size_t stride = std::max<std::size_t>(1, window.pixels() / kSamples) | 1;
    while (stride > 1 && width % stride == 0) stride += 2;
    return stride;
}

/// Both pictures, and what is compared of them.
struct Pair {
    const Image &onWhite, &onBlack;
    Backdrops backdrops;
    Window window;
};

/// Mean of what does not fit if the black picture is moved back by (dx,dy); less than that, but above `limit`, if it is
/// above that.
double inconsistencyAt(const Pair& pair, int dx, int dy, double limit) {
    const Window& window = pair.window;
    const std::size_t width = std::size_t(window.right - window.left), pixels = window.pixels();
    const std::size_t stride = strideOf(window);
    const double count = double((pixels + stride - 1) / stride);
    double sum = 0;
    for (std::size_t i = 0; i < pixels && sum <= limit * count; i += stride) {
        const int x = window.left + int(i % width), y = window.top + int(i / width);
        sum += triangulate(colourOf(pair.onWhite.at(x, y), pair.onWhite.channels),
                           colourOf(pair.onBlack.at(x + dx, y + dy), pair.onBlack.channels), pair.backdrops)
                   .square;
    }
    return sum / count;
}

void requirePair(const Image& onWhite, const Image& onBlack) {
    requireOpaquePicture(onWhite, "the picture before white");
    requireOpaquePicture(onBlack, "the picture before black");
    const auto size = [](const Image& image) {
        return std::to_string(image.width) + "x" + std::to_string(image.height);
    };
    if (onWhite.width != onBlack.width || onWhite.height != onBlack.height)
        throw InvalidArgument("the pictures before white and black differ in size: " + size(onWhite) + " and " +
                              size(onBlack) + "; a pair is taken by one camera that does not move");
}

}  // namespace

std::optional<Misregistration> findMisregistration(const Image& onWhite, const Image& onBlack,
                                                   const MattingOptions& options) {
    const int reach = std::min(options.searchRadius, (std::min(onWhite.width, onWhite.height) - 1) / 4);
    if (reach <= 0) return {};
    const Pair pair = {onWhite, onBlack, Backdrops(options), windowAround(onWhite, onBlack, options, reach)};
    if (pair.window.left >= pair.window.right || pair.window.top >= pair.window.bottom) return {};
    const double atRest = inconsistencyAt(pair, 0, 0, std::numeric_limits<double>::infinity());
    if (atRest < kRounding) return {};
    Misregistration best = {0, 0, atRest, atRest};
    for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
            const double then = inconsistencyAt(pair, x, y, best.inconsistencyThen);
            if (then < best.inconsistencyThen) best = {x, y, atRest, then};
        }
    if (best.inconsistencyThen >= kClearly * atRest) return {};
    return best;
}

Matte matteOfPair(const Image& onWhite, const Image& onBlack, const MattingOptions& options) {
    options.validate();
    requirePair(onWhite, onBlack);
    const Backdrops backdrops(options);
    const float tolerance = float(options.tolerance);
    Matte matte;
    matte.image = Image(onWhite.width, onWhite.height, 4);
    matte.inconsistent.assign(matte.image.pixels.size() / 4, 0);
    for (std::size_t p = 0; p < matte.inconsistent.size(); ++p) {
        const Color white = colourOf(&onWhite.pixels[p * std::size_t(onWhite.channels)], onWhite.channels);
        const Color black = colourOf(&onBlack.pixels[p * std::size_t(onBlack.channels)], onBlack.channels);
        const Triangulated found = triangulate(white, black, backdrops);
        const float uncovered = std::min(std::max(found.uncovered, 0.0f), 1.0f);
        const Color colour = ((white + black) - (backdrops.white + backdrops.black) * uncovered) * 0.5f;
        const float lowest = std::min({colour.x, colour.y, colour.z});
        const bool outOfRange = found.outOfRange > tolerance || lowest < -tolerance;
        const bool disagreeing = found.disagreement > tolerance;
        matte.report.outOfRange += outOfRange;
        matte.report.disagreeing += disagreeing;
        matte.report.inconsistent += matte.inconsistent[p] = outOfRange || disagreeing;
        setPixel(matte.image, p, Color(std::max(colour.x, 0.0f), std::max(colour.y, 0.0f), std::max(colour.z, 0.0f)),
                 1 - uncovered);
    }
    countCoverage(matte);
    matte.report.misregistration = findMisregistration(onWhite, onBlack, options);
    return matte;
}

}  // namespace raysweep
