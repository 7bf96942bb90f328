/// The module `raysweep_pictures`: all of OpenImageIO, and the hundreds of libraries behind it. Loaded when a picture
/// is read or written that is no EXR (picture_formats.h). It uses nothing of the library but headers.
#include "raysweep/core/error.h"
#include "raysweep/image/picture_formats.h"

#include <OpenImageIO/imageio.h>

namespace raysweep {
namespace {

std::optional<SampleType> sampleTypeOf(const OIIO::TypeDesc& format) {
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
            return {};
    }
}

OIIO::TypeDesc formatOf(SampleType type) {
    constexpr OIIO::TypeDesc::BASETYPE kFormats[] = {
        OIIO::TypeDesc::INT8,  OIIO::TypeDesc::UINT8,  OIIO::TypeDesc::INT16, OIIO::TypeDesc::UINT16,
        OIIO::TypeDesc::INT32, OIIO::TypeDesc::UINT32, OIIO::TypeDesc::INT64, OIIO::TypeDesc::UINT64,
        OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::DOUBLE};
    return kFormats[int(type)];
}

/// Messages of several lines as one line.
std::string oneLine(std::string text) {
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos;) text.replace(at, 1, "; ");
    return text;
}

class OiioFile : public PictureFile {
  public:
    OiioFile(const std::string& path, Alpha alpha) : path_(path) {
        OIIO::ImageSpec how;
        if (alpha == Alpha::asStored) how.attribute("oiio:UnassociatedAlpha", 1);
        input_ = OIIO::ImageInput::open(path, &how);
        if (!input_) failToRead(path, oneLine(OIIO::geterror()) + kGivePicture);
    }

    int pages() override {
        int pages = 1;
        while (input_->seek_subimage(pages, 0)) ++pages;
        static_cast<void>(input_->geterror());  // the last seek failed, as it should
        return pages;
    }

    PicturePage page(int number) override {
        if (!input_->seek_subimage(number, 0)) fail();
        const OIIO::ImageSpec& spec = input_->spec();
        const bool isMultiplied = spec.alpha_channel >= 0 && !spec.get_int_attribute("oiio:UnassociatedAlpha");
        const bool isStraight = (spec.nchannels == 2 || spec.nchannels == 4) && !isMultiplied;
        return {spec.width,          spec.height, spec.depth, spec.nchannels, sampleTypeOf(spec.format),
                spec.format.c_str(), isStraight};
    }

    void readFloats(int number, float* to) override {
        const int channels = page(number).channels;
        requireLight();
        if (!input_->read_image(number, 0, 0, channels, OIIO::TypeDesc::FLOAT, to)) fail();
    }

    void readSamples(int number, std::byte* to) override {
        const OIIO::TypeDesc format = formatOf(page(number).type.value());
        if (!input_->read_image(number, 0, 0, 1, format, to)) fail();
    }

  private:
    /// What OpenImageIO makes of inks is no more than a rule of thumb: how they look is up to paper and profile.
    void requireLight() const {
        const std::string jpeg = input_->spec().get_string_attribute("jpeg:ColorSpace");
        const std::string tiff = input_->spec().get_string_attribute("tiff:ColorSpace");
        if (jpeg == "CMYK" || jpeg == "YCbCrK" || tiff == "CMYK" || tiff == "color separated")
            failToRead(path_, "its colours are inks (CMYK); convert the picture to RGB first");
    }

    [[noreturn]] void fail() const { failToRead(path_, oneLine(input_->geterror())); }

    std::string path_;
    std::unique_ptr<OIIO::ImageInput> input_;
};

std::unique_ptr<PictureFile> open(const std::string& path, Alpha alpha) {
    return std::make_unique<OiioFile>(path, alpha);
}

void write(const std::string& path, const std::string& temporary, const EncodedPicture& picture) {
    auto output = OIIO::ImageOutput::create(temporary);
    if (!output) failToWrite(path, oneLine(OIIO::geterror()));
    OIIO::ImageSpec spec(picture.width, picture.height, picture.channels, OIIO::TypeDesc::UINT8);
    if (picture.channels == 1) spec.channelnames = {"Y"};
    // The bytes are sRGB with alpha apart already: nothing for OpenImageIO to convert.
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    if (!output->open(temporary, spec) || !output->write_image(OIIO::TypeDesc::UINT8, picture.bytes) ||
        !output->close())
        failToWrite(path, oneLine(output->geterror()));
}

}  // namespace
}  // namespace raysweep

extern "C" const raysweep::PictureFormats* raysweepPictureFormats() {
    static constexpr raysweep::PictureFormats kFormats{raysweep::kPictureFormatsVersion, raysweep::open,
                                                       raysweep::write};
    return &kFormats;
}
