#include "raysweep/image/image_io.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/output_file.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
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

/// sRGB with alpha apart, in memory linear and premultiplied.
void decode(Image& image) {
    const int colours = hasAlpha(image) ? image.channels - 1 : image.channels;
    for (std::size_t p = 0; p < image.pixels.size(); p += image.channels) {
        float* pixel = image.pixels.data() + p;
        const float alpha = hasAlpha(image) ? pixel[colours] : 1.0f;
        for (int c = 0; c < colours; ++c) pixel[c] = linearFromSrgb(pixel[c]) * alpha;
    }
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

void writePixels(const std::string& path, const std::string& temporary, const Image& image, OIIO::TypeDesc type,
                 const void* data) {
    const auto fail = [&](const std::string& why) { throw IoError("cannot write '" + path + "': " + why); };
    auto output = OIIO::ImageOutput::create(temporary);
    if (!output) fail(OIIO::geterror());
    OIIO::ImageSpec spec(image.width, image.height, image.channels, type);
    if (image.channels == 1) spec.channelnames = {"Y"};
    // The bytes are sRGB with alpha apart already: nothing for the library to convert.
    spec.attribute("oiio:ColorSpace", type == OIIO::TypeDesc::FLOAT ? "Linear" : "sRGB");
    if (type != OIIO::TypeDesc::FLOAT) spec.attribute("oiio:UnassociatedAlpha", 1);
    if (!output->open(temporary, spec) || !output->write_image(type, data) || !output->close())
        fail(output->geterror());
}

SampleType sampleTypeOf(const OIIO::TypeDesc& format, const std::string& path) {
    switch (format.basetype) {
        case OIIO::TypeDesc::INT8:
            return SampleType::int8;
        case OIIO::TypeDesc::UINT8:
            return SampleType::uint8;
        case OIIO::TypeDesc::INT16:
            return SampleType::int16;
        case OIIO::TypeDesc::UINT16:
            return SampleType::uint16;
        case OIIO::TypeDesc::INT32:
            return SampleType::int32;
        case OIIO::TypeDesc::UINT32:
            return SampleType::uint32;
        case OIIO::TypeDesc::HALF:
        case OIIO::TypeDesc::FLOAT:
            return SampleType::float32;
        case OIIO::TypeDesc::DOUBLE:
            return SampleType::float64;
        default:
            throw InvalidArgument("cannot read '" + path + "': samples of the type " + format.c_str() +
                                  " are not known; convert the picture first");
    }
}

OIIO::TypeDesc formatOf(SampleType type) {
    constexpr OIIO::TypeDesc::BASETYPE kFormats[] = {
        OIIO::TypeDesc::INT8,  OIIO::TypeDesc::UINT8,  OIIO::TypeDesc::INT16, OIIO::TypeDesc::UINT16,
        OIIO::TypeDesc::INT32, OIIO::TypeDesc::UINT32, OIIO::TypeDesc::INT64, OIIO::TypeDesc::UINT64,
        OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::DOUBLE};
    return kFormats[int(type)];
}

std::unique_ptr<OIIO::ImageInput> openPicture(const std::string& path, const OIIO::ImageSpec* how = nullptr) {
    const auto fail = [&](const std::string& why) { throw IoError("cannot read '" + path + "': " + why); };
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) fail("there is no such file");
    if (std::filesystem::is_directory(path, ignored)) fail("it is a folder; give a picture file");
    if (isVolume(path)) fail("it is an OpenVDB volume; give an EXR, HDR, PNG, JPEG or TIFF picture");
    auto input = OIIO::ImageInput::open(path, how);
    if (!input) fail(OIIO::geterror() + "; give an EXR, HDR, PNG, JPEG or TIFF picture");
    return input;
}

int pagesOf(OIIO::ImageInput& input) {
    int pages = 1;
    while (input.seek_subimage(pages, 0)) ++pages;
    static_cast<void>(input.geterror());  // the last seek failed, as it should
    input.seek_subimage(0, 0);
    return pages;
}

/// Checks one page of a stack whose first page made `stack`.
void requireSlice(const OIIO::ImageSpec& spec, const PictureStack& stack, const std::string& path, int page) {
    const auto fail = [&](const std::string& why) {
        throw InvalidArgument("cannot use '" + path + "'" + (page > 0 ? ", page " + std::to_string(page + 1) : "") +
                              ": " + why);
    };
    if (spec.depth > 1) fail("it has a depth of its own; a stack is made of flat pictures");
    if (spec.nchannels != 1)
        fail("it has " + std::to_string(spec.nchannels) +
             " channels, but a volume needs one number per voxel; convert the pictures to grey first");
    const auto size = [](int w, int h) { return std::to_string(w) + "x" + std::to_string(h); };
    if (spec.width != stack.width || spec.height != stack.height)
        fail("its size is " + size(spec.width, spec.height) + ", but the first picture's is " +
             size(stack.width, stack.height) + "; all slices must have one size");
    const SampleType type = sampleTypeOf(spec.format, path);
    if (type != stack.type)
        fail("its samples are " + nameOf(type) + ", but the first picture's are " + nameOf(stack.type) +
             "; all slices must have one type");
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
    OIIO::ImageSpec asStored;
    asStored.attribute("oiio:UnassociatedAlpha", 1);  // else colours are multiplied by alpha before they are decoded
    const auto input = openPicture(path, &asStored);
    const OIIO::ImageSpec& spec = input->spec();
    Image image(spec.width, spec.height, spec.nchannels);
    const bool linear = spec.format.is_floating_point();
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.pixels.data()))
        throw IoError("cannot read '" + path + "': " + input->geterror());
    if (!linear) decode(image);
    return image;
}

PictureStack readPictureStack(const std::vector<std::string>& files, const ProgressCallback& progress) {
    PictureStack stack;
    std::vector<int> pages;
    for (const std::string& file : files) {
        const auto input = openPicture(file);
        const OIIO::ImageSpec& spec = input->spec();
        if (pages.empty()) {
            stack.width = spec.width;
            stack.height = spec.height;
            stack.type = sampleTypeOf(spec.format, file);
        }
        requireSlice(spec, stack, file, 0);
        pages.push_back(pagesOf(*input));
        stack.slices += pages.back();
    }
    const std::size_t sliceBytes = std::size_t(stack.width) * stack.height * sizeOf(stack.type);
    stack.samples.reset(new std::byte[sliceBytes * stack.slices]);
    std::byte* to = stack.samples.get();
    for (std::size_t f = 0; f < files.size(); ++f) {
        const auto input = openPicture(files[f]);
        for (int page = 0; page < pages[f]; ++page, to += sliceBytes) {
            stack.complete = report(progress, "reading", double(to - stack.samples.get()) / sliceBytes / stack.slices);
            if (!stack.complete) return stack;
            if (!input->seek_subimage(page, 0)) throw IoError("cannot read '" + files[f] + "': " + input->geterror());
            requireSlice(input->spec(), stack, files[f], page);
            if (!input->read_image(page, 0, 0, 1, formatOf(stack.type), to))
                throw IoError("cannot read '" + files[f] + "': " + input->geterror());
        }
    }
    return stack;
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
    if (format == ImageFormat::Exr)
        writePixels(path, file.temporary(), image, OIIO::TypeDesc::FLOAT, image.pixels.data());
    else
        writePixels(path, file.temporary(), image, OIIO::TypeDesc::UINT8, encode(image).data());
    file.commit();
}

}  // namespace raysweep
