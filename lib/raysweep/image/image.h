/// Pictures: floats in linear light.
#pragma once

#include <cstddef>
#include <vector>

namespace raysweep {

/// `channels` values per pixel, rows from top to bottom, pixels from left to right. Linear light; four channels mean
/// RGB and alpha, with RGB already multiplied by alpha.
struct Image {
    int width = 0;
    int height = 0;
    int channels = 0;
    std::vector<float> pixels;

    Image() = default;
    /// A picture with every value 0.
    Image(int width, int height, int channels)
        : width(width), height(height), channels(channels), pixels(std::size_t(width) * height * channels) {}

    /// First channel of the pixel in column x, row y (row 0 on top).
    float* at(int x, int y) { return pixels.data() + (std::size_t(y) * width + x) * channels; }
    const float* at(int x, int y) const { return pixels.data() + (std::size_t(y) * width + x) * channels; }
};

}  // namespace raysweep
