#include "raysweep/image/matte_picture.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"
#include "raysweep/image/image_io.h"

#include <algorithm>
#include <string>

namespace raysweep {
namespace {

constexpr int kSquare = 8;  ///< pixels along a side of the checkerboard's
constexpr float kDark = 0.13f, kBright = 0.32f;

void requireRgba(const Image& picture) {
    if (picture.channels != 4 || picture.pixels.empty() ||
        picture.pixels.size() != std::size_t(picture.width) * std::size_t(picture.height) * 4)
        throw InvalidArgument("a matte has four channels, this picture has " + std::to_string(picture.channels));
}

float clip(float value) {
    return value > 0 ? std::min(value, 1.0f) : 0.0f;
}

}  // namespace

Image mattePicture(const Image& matte, const std::vector<char>& inconsistent) {
    requireRgba(matte);
    const std::size_t width = std::size_t(matte.width);
    if (!inconsistent.empty() && inconsistent.size() != width * std::size_t(matte.height))
        throw InvalidArgument("the mask of inconsistent pixels has " + std::to_string(inconsistent.size()) +
                              " values, the matte " + std::to_string(width * std::size_t(matte.height)) + " pixels");
    Image picture(2 * matte.width, matte.height, 3);
    for (int y = 0; y < matte.height; ++y)
        for (int x = 0; x < matte.width; ++x) {
            const float* const from = matte.at(x, y);
            const float board = (x / kSquare + y / kSquare) % 2 == 0 ? kBright : kDark;
            float* const over = picture.at(x, y);
            for (int c = 0; c < 3; ++c) over[c] = from[c] + (1 - from[3]) * board;
            float* const alpha = picture.at(matte.width + x, y);
            std::fill_n(alpha, 3, linearFromSrgb(clip(from[3])));
            if (!inconsistent.empty() && inconsistent[std::size_t(y) * width + std::size_t(x)])
                alpha[0] = 1, alpha[1] = 0, alpha[2] = 0;
        }
    return picture;
}

Image shownBefore(const Image& picture, float backdrop) {
    requireRgba(picture);
    requireField(backdrop >= 0 && backdrop <= 1, "backdrop", backdrop, "in [0,1]");
    Image shown(picture.width, picture.height, 3);
    for (std::size_t p = 0; p < picture.pixels.size() / 4; ++p) {
        const float* const from = &picture.pixels[4 * p];
        const float alpha = clip(from[3]);
        for (std::size_t c = 0; c < 3; ++c) {
            const float own = alpha > 0 ? srgbFromLinear(clip(from[c] / alpha)) : 0.0f;
            shown.pixels[3 * p + c] = own * alpha + (1 - alpha) * backdrop;
        }
    }
    return shown;
}

Image reduced(const Image& picture, int factor) {
    requireField(factor >= 1 && factor <= std::min(picture.width, picture.height), "reduction factor", factor,
                 "at least 1 and at most the picture's smaller side");
    Image result(picture.width / factor, picture.height / factor, picture.channels);
    std::vector<double> sums(std::size_t(picture.channels));
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x) {
            std::fill(sums.begin(), sums.end(), 0.0);
            for (int j = 0; j < factor; ++j) {
                const float* from = picture.at(x * factor, y * factor + j);
                for (int i = 0; i < factor; ++i)
                    for (double& sum : sums) sum += double(*from++);
            }
            for (std::size_t c = 0; c < sums.size(); ++c)
                result.at(x, y)[c] = float(sums[c] / (double(factor) * factor));
        }
    return result;
}

}  // namespace raysweep
