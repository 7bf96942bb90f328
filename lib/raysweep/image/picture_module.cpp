/// The module `raysweep_pictures`: all of OpenImageIO, and the hundreds of libraries behind it. Loaded when a picture
/// is read or written that is no EXR (picture_formats.h). Of the library it uses headers, and memory.h.
#include "raysweep/core/claimed_room.h"
#include "raysweep/core/error.h"
#include "raysweep/image/picture_formats.h"
#include "raysweep/image/tiff_file.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>

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

/// The largest number that samples can be in formats where that need not be their type's: grey PNG of 1, 2 or 4 bits,
/// PGM. 0 for others.
double highestStored(const std::string& path) {
    char start[26] = {};
    std::ifstream in(path, std::ios::binary);
    in.read(start, sizeof start);
    constexpr char kGrey = 0;
    if (std::string(start + 1, 3) == "PNG" && start[25] == kGrey && start[24] < 8 && start[24] > 0)
        return std::exp2(start[24]) - 1;
    if (start[0] != 'P' || (start[1] != '2' && start[1] != '5')) return 0;
    in.clear();
    in.seekg(2);
    int fields[3] = {};  // width, height, largest
    for (int& field : fields) {
        while ((in >> std::ws).peek() == '#') in.ignore(1 << 16, '\n');
        in >> field;
    }
    const int full = fields[2] > 255 ? 65535 : 255;
    return in && fields[2] > 0 && fields[2] < full ? fields[2] : 0;
}

class OiioFile : public PictureFile {
  public:
    OiioFile(const std::string& path, Alpha alpha) : path_(path) {
        OIIO::ImageSpec how;
        if (alpha == Alpha::asStored) how.attribute("oiio:UnassociatedAlpha", 1);
        input_ = OIIO::ImageInput::open(path, &how);
        if (!input_) failToRead(path, oneLine(OIIO::geterror()) + kGivePicture);
        highest_ = highestStored(path);
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
        PicturePage page;
        page.width = spec.width;
        page.height = spec.height;
        page.depth = spec.depth;
        page.channels = spec.nchannels;
        page.type = sampleTypeOf(spec.format);
        page.typeName = spec.format.c_str();
        page.straightAlpha = isStraight;
        page.channelNames = spec.channelnames;
        page.highest = highest_;
        requireRoomFor(spec);
        return page;
    }

    void readFloats(int number, float* to) override {
        const int channels = page(number).channels;
        requireLight();
        if (!input_->read_image(number, 0, 0, channels, OIIO::TypeDesc::FLOAT, to)) fail();
    }

    void readSamples(int number, int channel, std::byte* to) override {
        const PicturePage size = page(number);
        requireLight();
        if (!input_->read_image(number, 0, channel, channel + 1, formatOf(size.type.value()), to)) fail();
        if (size.highest > 0) unscale(size, to);
    }

  private:
    /// OpenImageIO makes samples of fewer bits fill their type: back to what is stored.
    static void unscale(const PicturePage& page, std::byte* samples) {
        const auto all = std::uint64_t(page.width) * std::uint64_t(page.height);
        const auto top = std::uint64_t(page.highest);
        withSampleType(*page.type, [&](auto zero) {
            using Sample = decltype(zero);
            auto* const numbers = reinterpret_cast<Sample*>(samples);
            if constexpr (std::is_same_v<Sample, std::uint8_t> || std::is_same_v<Sample, std::uint16_t>)
                for (std::uint64_t n = 0; n < all; ++n) {  // it rounds down
                    constexpr std::uint64_t kFull = Sample(-1);
                    numbers[n] = Sample((numbers[n] * top + kFull - 1) / kFull);
                }
        });
    }

    /// OpenImageIO takes the memory for a tile at once.
    void requireRoomFor(const OIIO::ImageSpec& spec) const {
        const auto volumeOf = [](int x, int y, int z) { return double(x) * y * std::max(1, z); };
        const double pixels = std::max(volumeOf(spec.width, spec.height, spec.depth),
                                       volumeOf(spec.tile_width, spec.tile_height, spec.tile_depth));
        const int bits = spec.get_int_attribute("oiio:BitsPerSample", int(8 * spec.format.size()));
        std::error_code error;
        const double size = double(std::filesystem::file_size(path_, error));
        if (error) failToRead(path_, error.message());
        requireRoom(path_, pixels * spec.nchannels * bits / 8, size);
    }

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
    double highest_ = 0;
};

std::unique_ptr<PictureFile> open(const std::string& path, Alpha alpha) {
    return std::make_unique<OiioFile>(path, alpha);
}

std::unique_ptr<PictureFile> openStored(const std::string& path) {
    if (isTiff(path)) return openTiff(path);
    return std::make_unique<OiioFile>(path, Alpha::asStored);
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
                                                       raysweep::openStored, raysweep::write};
    return &kFormats;
}
