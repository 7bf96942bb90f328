#include "raysweep/image/matte_builder.h"

#include "raysweep/core/error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace raysweep {
namespace {

std::string placeOf(const Image& picture, std::size_t pixel) {
    return "(" + std::to_string(pixel % std::size_t(picture.width)) + "," +
           std::to_string(pixel / std::size_t(picture.width)) + ")";
}

/// The pixels that hang together with `first` by their sides, of those with alpha < 1 that are not `seen` yet.
/// @param found them, as scratch and result @return whether one of them is at the border
bool collect(const std::vector<float>& alpha, int width, int height, std::size_t first, std::vector<char>& seen,
             std::vector<std::size_t>& found) {
    bool atBorder = false;
    const auto add = [&](std::size_t pixel) {
        if (seen[pixel] || alpha[pixel] >= 1) return;
        seen[pixel] = 1;
        found.push_back(pixel);
    };
    found.clear();
    add(first);
    for (std::size_t next = 0; next < found.size(); ++next) {
        const std::size_t pixel = found[next], row = std::size_t(width);
        const int x = int(pixel % row), y = int(pixel / row);
        atBorder |= x == 0 || y == 0 || x == width - 1 || y == height - 1;
        if (x > 0) add(pixel - 1);
        if (x < width - 1) add(pixel + 1);
        if (y > 0) add(pixel - row);
        if (y < height - 1) add(pixel + row);
    }
    return atBorder;
}

}  // namespace

void requirePicture(const Image& picture, const char* what) {
    const std::size_t pixels = std::size_t(std::max(0, picture.width)) * std::size_t(std::max(0, picture.height));
    if (pixels == 0 || picture.channels <= 0 || picture.pixels.size() != pixels * std::size_t(picture.channels))
        throw InvalidArgument(std::string(what) + " is empty or inconsistent; give a picture with pixels");
    if (picture.channels > 4)
        throw InvalidArgument(std::string(what) + " has " + std::to_string(picture.channels) +
                              " channels; give grey or RGB, with or without alpha");
    for (std::size_t i = 0; i < picture.pixels.size(); ++i)
        if (!std::isfinite(picture.pixels[i]))
            throw InvalidArgument(std::string(what) + " has a value that is not finite, at pixel " +
                                  placeOf(picture, i / std::size_t(picture.channels)) + "; repair the picture");
}

void requireOpaquePicture(const Image& picture, const char* what) {
    requirePicture(picture, what);
    if (picture.channels % 2 != 0) return;
    for (std::size_t i = std::size_t(picture.channels) - 1; i < picture.pixels.size();
         i += std::size_t(picture.channels))
        if (picture.pixels[i] < 1)
            throw InvalidArgument(std::string(what) + " has alpha below 1, at pixel " +
                                  placeOf(picture, i / std::size_t(picture.channels)) +
                                  ", so its backdrop is gone already; take the matte from its alpha");
}

Color freed(const Color& colour, float alpha, const Color& backdrop) {
    const auto clamped = [alpha](float value) { return std::min(std::max(value, 0.0f), alpha); };
    const Color own = colour - backdrop * (1 - alpha);
    return Color(clamped(own.x), clamped(own.y), clamped(own.z));
}

void countCoverage(Matte& matte) {
    MatteReport& report = matte.report;
    report.pixels = matte.image.pixels.size() / 4;
    for (std::size_t p = 0; p < report.pixels; ++p) {
        const float alpha = matte.image.pixels[4 * p + 3];
        report.covered += alpha > 0;
        report.opaque += alpha == 1;
        report.coverage += double(alpha);
    }
}

void fillHoles(std::vector<float>& alpha, int width, int height, double largest, MatteReport& report) {
    std::vector<char> seen(alpha.size(), 0);
    std::vector<std::size_t> found;
    for (std::size_t first = 0; first < alpha.size(); ++first) {
        if (seen[first] || alpha[first] >= 1) continue;
        const bool atBorder = collect(alpha, width, height, first, seen, found);
        if (atBorder || double(found.size()) > largest) continue;
        for (const std::size_t pixel : found) alpha[pixel] = 1;
        ++report.holes;
        report.holePixels += found.size();
    }
}

}  // namespace raysweep
