#include "raysweep/image/image_io.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/module.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/regular_file.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/image/exr.h"
#include "raysweep/image/jpeg_check.h"
#include "raysweep/image/picture_formats.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <fstream>

namespace raysweep {
namespace {

/// Two and four channels: the last one is alpha. Others have none.
bool hasAlpha(const Image& image) {
    return image.channels == 2 || image.channels == 4;
}

float clip(float value) {
    return value > 0 ? std::min(value, 1.0f) : 0.0f;
}  // NaN too becomes 0

void requireImage(const Image& image) {
    if (image.width <= 0 || image.height <= 0 || image.channels <= 0)
        throw InvalidArgument("image: size " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                              " with " + std::to_string(image.channels) +
                              " channels is empty; all three must be positive");
    if (image.pixels.size() != std::size_t(image.width) * image.height * image.channels)
        throw InvalidArgument("image: " + std::to_string(image.pixels.size()) +
                              " values do not match width x height x channels");
}

/// The image library's own reader of volumes ends the process with an invalid pointer (2.4.7).
bool isVolume(const std::string& path) {
    char magic[4] = {0};
    std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
    return std::string(magic, sizeof magic) == " BDV";
}

/// sRGB, in memory linear and premultiplied. What is encoded is always the colour without alpha.
void decode(Image& image, bool straightAlpha) {
    const int colours = hasAlpha(image) ? image.channels - 1 : image.channels;
    for (std::size_t p = 0; p < image.pixels.size(); p += image.channels) {
        float* pixel = image.pixels.data() + p;
        const float alpha = hasAlpha(image) ? pixel[colours] : 1.0f;
        const float divisor = straightAlpha || alpha == 0 ? 1.0f : alpha;
        for (int c = 0; c < colours; ++c) pixel[c] = linearFromSrgb(pixel[c] / divisor) * alpha;
    }
}

void multiplyByAlpha(Image& image) {
    const int colours = image.channels - 1;
    for (std::size_t p = 0; p < image.pixels.size(); p += image.channels)
        for (int c = 0; c < colours; ++c) image.pixels[p + c] *= image.pixels[p + colours];
}

std::vector<std::uint8_t> encode(const Image& image) {
    const auto byte = [](float value) { return std::uint8_t(std::lround(255 * clip(value))); };
    const int colours = hasAlpha(image) ? image.channels - 1 : image.channels;
    std::vector<std::uint8_t> bytes(image.pixels.size());
    for (std::size_t p = 0; p < bytes.size(); p += image.channels) {
        const float alpha = hasAlpha(image) ? clip(image.pixels[p + colours]) : 1.0f;
        for (int c = 0; c < colours; ++c)
            bytes[p + c] = alpha > 0 ? byte(srgbFromLinear(clip(image.pixels[p + c] / alpha))) : std::uint8_t(0);
        if (hasAlpha(image)) bytes[p + colours] = byte(alpha);
    }
    return bytes;
}

/// The module that knows the formats which are no EXR. @return null if there is none; `problem` then says why
const PictureFormats* pictureFormats(std::string& problem) {
    static const ModuleFunction function = moduleFunction("raysweep_pictures", "raysweepPictureFormats");
    problem = "only EXR pictures can be used: " + function.problem;
    if (!function.address) return nullptr;
    const PictureFormats* const formats = reinterpret_cast<const PictureFormats* (*)()>(function.address)();
    problem = "the module 'raysweep_pictures.so' belongs to another build; build or install it again";
    return formats->version == kPictureFormatsVersion ? formats : nullptr;
}

template <class OpenByModule>
std::unique_ptr<PictureFile> open(const std::string& path, const OpenByModule& openByModule) {
    if (const std::string why = whyNotRegular(path, "a picture file"); !why.empty()) failToRead(path, why);
    noteInput(path);
    if (isVolume(path)) failToRead(path, std::string("it is an OpenVDB volume") + kGivePicture);
    if (isExr(path))
        if (auto file = openExr(path)) return file;
    std::string problem;
    const PictureFormats* const formats = pictureFormats(problem);
    if (!formats) failToRead(path, problem);
    return openByModule(*formats);
}

std::unique_ptr<PictureFile> openPicture(const std::string& path, Alpha alpha = Alpha::multiplied) {
    return open(path, [&](const PictureFormats& formats) { return formats.open(path, alpha); });
}

/// Readers of JPEGs do not say that a file ends early. This takes reading it once more.
void requireWhole(const std::string& path) {
    if (isCutJpeg(path)) failToRead(path, "it ends early: the JPEG's end mark is missing");
}

/// The first page as it is, in floats. @param page is set to what it is
Image readStored(const std::string& path, PicturePage& page) {
    // Else colours are multiplied by alpha before they are decoded.
    const auto file = openPicture(path, Alpha::asStored);
    page = file->page(0);
    if (page.depth > 1) failToRead(path, std::string("it has a depth of its own") + kGivePicture);
    requireWhole(path);
    requireBytes(double(page.width) * page.height * page.channels * sizeof(float), "'" + path + "': the picture needs",
                 "take a smaller one");
    Image image(page.width, page.height, page.channels);
    file->readFloats(0, image.pixels.data());
    return image;
}

/// Alpha that is 1 in every pixel says nothing: programs add it to any picture.
bool saysSomething(const Image& image, int channel) {
    for (std::size_t p = 0; p < image.pixels.size(); p += image.channels)
        if (image.pixels[p + channel] != 1) return true;
    return false;
}

bool isGrey(const Image& image) {
    for (std::size_t p = 0; p < image.pixels.size(); p += image.channels)
        if (image.pixels[p] != image.pixels[p + 1] || image.pixels[p] != image.pixels[p + 2]) return false;
    return true;
}

}  // namespace

ImageFormat imageFormat(const std::string& path) {
    const std::string extension = lowerExtension(path);
    return extension == ".exr" ? ImageFormat::Exr : extension == ".png" ? ImageFormat::Png : ImageFormat::Unknown;
}

float srgbFromLinear(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float linearFromSrgb(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

Image toneMap(const Image& image, double exposure) {
    requireImage(image);
    if (!std::isfinite(exposure)) throw InvalidArgument("exposure must be a finite number of stops");
    const float gain = float(std::exp2(exposure));
    Image shown(image.width, image.height, hasAlpha(image) ? image.channels - 1 : image.channels);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            for (int c = 0; c < shown.channels; ++c) shown.at(x, y)[c] = clip(gain * image.at(x, y)[c]);
    return shown;
}

Image readImage(const std::string& path) {
    PicturePage page;
    Image image = readStored(path, page);
    if (!page.type || !isFloatingPoint(*page.type))
        decode(image, page.straightAlpha);
    else if (page.straightAlpha)
        multiplyByAlpha(image);
    return image;
}

Image readCoverage(const std::string& path) {
    PicturePage page;
    const Image stored = readStored(path, page);
    if (stored.channels > 4)
        throw InvalidArgument("cannot use '" + path + "' as a mask: it has " + std::to_string(stored.channels) +
                              " channels; give a grey picture or one with alpha");
    const int last = stored.channels - 1;
    const bool byAlpha = hasAlpha(stored) && saysSomething(stored, last);
    if (!byAlpha && stored.channels > 2 && !isGrey(stored))
        throw InvalidArgument("cannot use '" + path +
                              "' as a mask: it has colours, but no alpha; give a grey picture or one with alpha");
    Image coverage(stored.width, stored.height, 1);
    for (std::size_t p = 0; p < coverage.pixels.size(); ++p) {
        const float value = stored.pixels[p * stored.channels + (byAlpha ? last : 0)];
        if (!(value >= 0 && value <= 1))
            throw InvalidArgument("cannot use '" + path + "' as a mask: " + std::to_string(value) +
                                  " is no part of a pixel; values must be in [0,1]");
        coverage.pixels[p] = value;
    }
    return coverage;
}

PictureSize pictureSize(const std::string& path) {
    const PicturePage page = openPicture(path)->page(0);
    return {page.width, page.height};
}

bool pictureHasAlpha(const std::string& path) {
    const int channels = openPicture(path)->page(0).channels;
    return channels == 2 || channels == 4;
}

std::unique_ptr<PictureFile> openStoredPicture(const std::string& path) {
    auto file = open(path, [&](const PictureFormats& formats) { return formats.openStored(path); });
    requireWhole(path);
    return file;
}

void writeImage(const std::string& path, const Image& image) {
    requireImage(image);
    const ImageFormat format = imageFormat(path);
    if (format == ImageFormat::Unknown)
        throw IoError("cannot write '" + path + "': the extension '" + lowerExtension(path) +
                      "' is not known; use .exr or .png");
    if (format == ImageFormat::Png && image.channels > 4)
        throw InvalidArgument("a PNG holds at most 4 channels, the image has " + std::to_string(image.channels) +
                              "; write an .exr");
    OutputFile file(path);
    if (format == ImageFormat::Exr) {
        writeExr(path, file.temporary(), image);
    } else {
        std::string problem;
        const PictureFormats* const formats = pictureFormats(problem);
        if (!formats) failToWrite(path, problem);
        formats->write(path, file.temporary(), {image.width, image.height, image.channels, encode(image).data()});
    }
    file.commit();
}

}  // namespace raysweep
