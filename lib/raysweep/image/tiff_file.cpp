// libtiff, not OpenImageIO: that takes pictures to be looked at, so it scales 10 and 12 bits to 16, inverts bytes (but
// not words) where small numbers are white, takes bits for bytes where a file leaves BitsPerSample to its default, and
// reads floats of 24 bits as zeros.
#include "raysweep/image/tiff_file.h"

#include "raysweep/core/claimed_room.h"
#include "raysweep/core/memory.h"

#include <half.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

namespace raysweep {
namespace {

constexpr std::uint32_t kLargest = 1 << 20;  ///< pixels along an edge; more is a damaged header

/// What one directory says.
struct Directory {
    std::uint64_t offset = 0;
    std::uint32_t width = 0, height = 0;
    std::uint16_t bits = 1, format = SAMPLEFORMAT_UINT, samples = 1, planes = PLANARCONFIG_CONTIG, photometric = 1;
    std::uint16_t orientation = ORIENTATION_TOPLEFT, compression = COMPRESSION_NONE;
    bool tiled = false, extra = false;
    float columnsPerUnit = 0, rowsPerUnit = 0;
};

int keepMessage(TIFF*, void* to, const char*, const char* format, va_list arguments) {
    char text[1000];
    std::vsnprintf(text, sizeof text, format, arguments);
    auto& message = *static_cast<std::string*>(to);
    if (message.empty()) message = text;  // the first is the cause
    return 1;
}

int dropMessage(TIFF*, void*, const char*, const char*, va_list) {
    return 1;
}

std::optional<SampleType> typeOf(const Directory& d) {
    const bool whole = d.bits == 8 || d.bits == 16 || d.bits == 32 || d.bits == 64;
    switch (d.format) {
        case SAMPLEFORMAT_UINT:
        case SAMPLEFORMAT_VOID:
            if (d.bits <= 8) return SampleType::uint8;
            if (d.bits <= 16) return SampleType::uint16;
            if (d.bits <= 32) return SampleType::uint32;
            if (d.bits == 64) return SampleType::uint64;
            return {};
        case SAMPLEFORMAT_INT:
            if (!whole) return {};
            return d.bits == 8    ? SampleType::int8
                   : d.bits == 16 ? SampleType::int16
                   : d.bits == 32 ? SampleType::int32
                                  : SampleType::int64;
        case SAMPLEFORMAT_IEEEFP:
            if (d.bits == 16 || d.bits == 32) return SampleType::float32;
            if (d.bits == 64) return SampleType::float64;
            return {};
        default:
            return {};
    }
}

/// Number `index` of those that are packed into `bits` bits each, the highest bit first.
std::uint32_t packed(const std::uint8_t* row, std::size_t index, int bits) {
    std::uint32_t value = 0;
    for (std::size_t bit = index * std::size_t(bits), end = bit + std::size_t(bits); bit < end; ++bit)
        value = value << 1 | (row[bit / 8] >> (7 - bit % 8) & 1);
    return value;
}

/// One sample of each of `count` pixels of a row, which has `stride` side by side, as libtiff leaves them: in this
/// machine's byte order where they are whole words, else packed.
void unpack(const std::uint8_t* row, std::size_t first, std::size_t stride, std::size_t count, const Directory& d,
            SampleType type, std::byte* to) {
    const std::size_t size = sizeOf(type);
    for (std::size_t n = 0; n < count; ++n, to += size) {
        const std::size_t index = first + n * stride;
        if (d.format == SAMPLEFORMAT_IEEEFP && d.bits == 16) {
            half number;
            std::uint16_t bits;
            std::memcpy(&bits, row + 2 * index, 2);
            number.setBits(bits);
            const float value = number;
            std::memcpy(to, &value, size);
        } else if (d.bits == 8 * size) {
            std::memcpy(to, row + index * size, size);
        } else if (d.bits == 24) {
            const std::uint32_t value = std::uint32_t(row[3 * index]) | std::uint32_t(row[3 * index + 1]) << 8 |
                                        std::uint32_t(row[3 * index + 2]) << 16;
            std::memcpy(to, &value, size);
        } else {
            const std::uint32_t value = packed(row, index, d.bits);
            std::memcpy(to, &value, size);  // little endian
        }
    }
}

/// The number behind "KEY=" in what ImageJ says of a file; 0 if there is none.
std::int64_t imageJNumber(const std::string& description, const std::string& key) {
    if (description.rfind("ImageJ=", 0) != 0) return 0;
    const std::size_t at = description.find("\n" + key + "=");
    return at == std::string::npos ? 0 : std::strtoll(description.c_str() + at + key.size() + 2, nullptr, 10);
}

class TiffFile : public PictureFile {
  public:
    explicit TiffFile(const std::string& path) : path_(path), file_(nullptr, TIFFClose) {
        TIFFOpenOptions* const options = TIFFOpenOptionsAlloc();
        TIFFOpenOptionsSetErrorHandlerExtR(options, keepMessage, &message_);
        TIFFOpenOptionsSetWarningHandlerExtR(options, dropMessage, nullptr);
        file_.reset(TIFFOpenExt(path.c_str(), "rm", options));  // m: a file that is cut meanwhile is no signal
        TIFFOpenOptionsFree(options);
        if (!file_) fail("it is no TIFF, or damaged");
        std::ifstream in(path, std::ios::binary | std::ios::ate);
        fileBytes_ = double(in.tellg());
        constexpr std::size_t kMostPages = 1 << 20;
        do {
            directories_.push_back(current());
            if (directories_.size() > kMostPages) fail("it has more pages than there can be");
        } while (TIFFReadDirectory(file_.get()));
        TIFFSetDirectory(file_.get(), 0);
        const char* text = nullptr;
        if (TIFFGetField(file_.get(), TIFFTAG_IMAGEDESCRIPTION, &text) && text) description_ = text;
        findSlices();
    }

    int pages() override { return int(slices_ > 0 ? slices_ : directories_.size()); }
    std::string description() override { return description_; }

    PicturePage page(int number) override {
        const Directory& d = directory(number);
        if (d.width < 1 || d.height < 1 || d.width > kLargest || d.height > kLargest)
            fail("it claims to have " + std::to_string(d.width) + "x" + std::to_string(d.height) +
                 " pixels; it is damaged");
        requireRoom(path_, double(d.width) * d.height * d.samples * d.bits / 8, fileBytes_);
        PicturePage page;
        page.width = int(d.width);
        page.height = int(d.height);
        page.channels = d.samples;
        page.extra = d.extra;
        page.type = typeOf(d);
        page.typeName = std::to_string(d.bits) + " bits";
        if (d.format == SAMPLEFORMAT_IEEEFP) page.typeName = "floats of " + page.typeName;
        if (d.format == SAMPLEFORMAT_COMPLEXINT || d.format == SAMPLEFORMAT_COMPLEXIEEEFP)
            page.typeName = "complex numbers";
        if (page.type && !isFloatingPoint(*page.type) && d.bits < 8 * sizeOf(*page.type))
            page.highest = std::exp2(d.bits) - 1;
        if (d.photometric == PHOTOMETRIC_RGB) page.channelNames = {"red", "green", "blue"};
        page.columnsPerUnit = d.columnsPerUnit;
        page.rowsPerUnit = d.rowsPerUnit;
        return page;
    }

    void readFloats(int, float*) override { fail("it is open for its numbers, not as a picture"); }

    void readSamples(int number, int channel, std::byte* to) override {
        const Directory& d = directory(number);
        requireNumbers(d);
        if (slices_ > 0)
            readSlice(number, to);
        else if (d.tiled)
            readTiles(d, std::uint16_t(channel), to);
        else
            readRows(d, std::uint16_t(channel), to);
        turn(d, to);
    }

  private:
    [[noreturn]] void fail(const std::string& why) const {
        failToRead(path_, message_.empty() ? why : why + " (" + message_ + ")");
    }

    const Directory& directory(int number) const { return directories_[slices_ > 0 ? 0 : std::size_t(number)]; }

    Directory current() {
        TIFF* const file = file_.get();
        Directory d;
        std::uint32_t kind = 0;
        std::uint16_t oldKind = 0;
        d.offset = TIFFCurrentDirOffset(file);
        TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &d.width);
        TIFFGetField(file, TIFFTAG_IMAGELENGTH, &d.height);
        TIFFGetFieldDefaulted(file, TIFFTAG_BITSPERSAMPLE, &d.bits);
        TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLEFORMAT, &d.format);
        TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLESPERPIXEL, &d.samples);
        TIFFGetFieldDefaulted(file, TIFFTAG_PLANARCONFIG, &d.planes);
        TIFFGetFieldDefaulted(file, TIFFTAG_ORIENTATION, &d.orientation);
        TIFFGetFieldDefaulted(file, TIFFTAG_COMPRESSION, &d.compression);
        TIFFGetField(file, TIFFTAG_PHOTOMETRIC, &d.photometric);
        TIFFGetField(file, TIFFTAG_XRESOLUTION, &d.columnsPerUnit);
        TIFFGetField(file, TIFFTAG_YRESOLUTION, &d.rowsPerUnit);
        d.tiled = TIFFIsTiled(file) != 0;
        if (TIFFGetField(file, TIFFTAG_SUBFILETYPE, &kind)) d.extra = kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK);
        if (TIFFGetField(file, TIFFTAG_OSUBFILETYPE, &oldKind)) d.extra = d.extra || oldKind == OFILETYPE_REDUCEDIMAGE;
        return d;
    }

    /// ImageJ writes stacks of more than 4 GB with one directory: the slices follow each other behind the first.
    void findSlices() {
        const std::int64_t images = imageJNumber(description_, "images");
        if (images <= 1 || directories_.size() > 1) return;
        const Directory& d = directories_[0];
        const std::uint64_t* offsets = nullptr;
        TIFFGetField(file_.get(), d.tiled ? TIFFTAG_TILEOFFSETS : TIFFTAG_STRIPOFFSETS, &offsets);
        const auto size = std::uint64_t(fileBytes_);
        sliceBytes_ = std::uint64_t(d.width) * d.height * (d.bits / 8u) * d.samples;
        const bool plain = d.compression == COMPRESSION_NONE && !d.tiled && offsets && d.bits % 8 == 0 &&
                           d.samples == 1 && typeOf(d) && sliceBytes_ > 0;
        if (plain) firstSlice_ = offsets[0];
        if (!plain || firstSlice_ > size || (size - firstSlice_) / sliceBytes_ < std::uint64_t(images))
            fail("ImageJ's description promises " + std::to_string(images) +
                 " images, but there is one, and no room for "
                 "the others behind it; the file is cut, or was changed by another program");
        slices_ = std::size_t(images);
    }

    /// What would be other numbers than those stored, or none.
    void requireNumbers(const Directory& d) const {
        const auto refuse = [&](const std::string& why) {
            throw InvalidArgument("cannot use '" + path_ + "': " + why);
        };
        const bool grey = d.photometric == PHOTOMETRIC_MINISBLACK || d.photometric == PHOTOMETRIC_MINISWHITE;
        const bool byImageJ = description_.rfind("ImageJ=", 0) == 0;  // which stores its colours for grey so
        if (d.photometric == PHOTOMETRIC_PALETTE && !byImageJ)
            refuse("its samples are places in a palette of colours; convert it to grey first");
        if (!grey && d.photometric != PHOTOMETRIC_RGB && d.photometric != PHOTOMETRIC_PALETTE)
            refuse("its colours are neither grey nor RGB (PhotometricInterpretation " + std::to_string(d.photometric) +
                   "); convert it to grey first");
        if (d.orientation < ORIENTATION_TOPLEFT || d.orientation > ORIENTATION_BOTLEFT)
            refuse("its rows are to be shown as columns (Orientation " + std::to_string(d.orientation) +
                   "); turn it first");
    }

    void open(const Directory& d) {
        message_.clear();
        if (!TIFFSetSubDirectory(file_.get(), d.offset)) fail("a page cannot be read");
    }

    /// For a row or a tile. @param bytes as libtiff counts them @param least what is needed of them
    std::vector<std::uint8_t> memoryFor(tmsize_t bytes, std::size_t least, const std::string& what) const {
        if (bytes < 0 || std::size_t(bytes) < least) fail(what + " are smaller than its header says");
        requireRoom(path_, double(bytes), fileBytes_);
        requireBytes(double(bytes), "'" + path_ + "': each of " + what + " needs", "save it in smaller ones first");
        return std::vector<std::uint8_t>(std::size_t(bytes));
    }

    void readRows(const Directory& d, std::uint16_t channel, std::byte* to) {
        open(d);
        const bool apart = d.planes == PLANARCONFIG_SEPARATE;
        const std::size_t stride = apart ? 1 : d.samples, size = sizeOf(*typeOf(d));
        const std::size_t least = (std::size_t(d.width) * stride * d.bits + 7) / 8;
        std::vector<std::uint8_t> row = memoryFor(TIFFScanlineSize(file_.get()), least, "its rows");
        for (std::uint32_t y = 0; y < d.height; ++y, to += d.width * size) {
            if (TIFFReadScanline(file_.get(), row.data(), y, apart ? channel : std::uint16_t(0)) < 0)
                fail("row " + std::to_string(y) + " cannot be read");
            unpack(row.data(), apart ? 0 : channel, stride, d.width, d, *typeOf(d), to);
        }
    }

    void readTiles(const Directory& d, std::uint16_t channel, std::byte* to) {
        open(d);
        const bool apart = d.planes == PLANARCONFIG_SEPARATE;
        const std::size_t stride = apart ? 1 : d.samples, size = sizeOf(*typeOf(d));
        std::uint32_t width = 0, height = 0;
        TIFFGetField(file_.get(), TIFFTAG_TILEWIDTH, &width);
        TIFFGetField(file_.get(), TIFFTAG_TILELENGTH, &height);
        if (width < 1 || height < 1 || width > kLargest || height > kLargest) fail("its tiles have no size");
        const std::size_t rowBytes = (std::size_t(width) * stride * d.bits + 7) / 8;
        std::vector<std::uint8_t> tile = memoryFor(TIFFTileSize(file_.get()), rowBytes * height, "its tiles");
        for (std::uint32_t y = 0; y < d.height; y += height)
            for (std::uint32_t x = 0; x < d.width; x += width) {
                if (TIFFReadTile(file_.get(), tile.data(), x, y, 0, apart ? channel : std::uint16_t(0)) < 0)
                    fail("the tile at " + std::to_string(x) + ", " + std::to_string(y) + " cannot be read");
                for (std::uint32_t row = 0; row < std::min(height, d.height - y); ++row)
                    unpack(tile.data() + row * rowBytes, apart ? 0 : channel, stride, std::min(width, d.width - x), d,
                           *typeOf(d), to + (std::size_t(y + row) * d.width + x) * size);
            }
    }

    void readSlice(int number, std::byte* to) {
        const Directory& d = directories_[0];
        std::ifstream in(path_, std::ios::binary);
        in.seekg(std::streamoff(firstSlice_ + std::uint64_t(number) * sliceBytes_));
        std::vector<std::uint8_t> slice(sliceBytes_);
        if (!in.read(reinterpret_cast<char*>(slice.data()), std::streamsize(sliceBytes_)))
            fail("image " + std::to_string(number) + " cannot be read");
        const std::size_t bytes = d.bits / 8;
        if (TIFFIsByteSwapped(file_.get()))
            for (std::size_t at = 0; at + bytes <= slice.size(); at += bytes)
                std::reverse(slice.begin() + std::ptrdiff_t(at), slice.begin() + std::ptrdiff_t(at + bytes));
        unpack(slice.data(), 0, 1, std::size_t(d.width) * d.height, d, *typeOf(d), to);
    }

    /// Row 0 to the top, column 0 to the left.
    void turn(const Directory& d, std::byte* samples) const {
        const std::size_t size = sizeOf(*typeOf(d)), row = d.width * size;
        const bool columns = d.orientation == ORIENTATION_TOPRIGHT || d.orientation == ORIENTATION_BOTRIGHT;
        const bool rows = d.orientation == ORIENTATION_BOTRIGHT || d.orientation == ORIENTATION_BOTLEFT;
        for (std::uint32_t y = 0; columns && y < d.height; ++y)
            for (std::uint32_t x = 0; x < d.width / 2; ++x)
                std::swap_ranges(samples + y * row + x * size, samples + y * row + (x + 1) * size,
                                 samples + y * row + (d.width - 1 - x) * size);
        for (std::uint32_t y = 0; rows && y < d.height / 2; ++y)
            std::swap_ranges(samples + y * row, samples + (y + 1) * row, samples + (d.height - 1 - y) * row);
    }

    std::string path_, message_, description_;
    std::unique_ptr<TIFF, decltype(&TIFFClose)> file_;
    std::vector<Directory> directories_;
    std::size_t slices_ = 0;  ///< of a stack with one directory; 0: pages are directories
    std::uint64_t firstSlice_ = 0, sliceBytes_ = 0;
    double fileBytes_ = 0;
};

}  // namespace

bool isTiff(const std::string& path) {
    char magic[4] = {};
    std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
    const bool little = magic[0] == 'I' && magic[1] == 'I' && magic[3] == 0;
    const bool big = magic[0] == 'M' && magic[1] == 'M' && magic[2] == 0;
    const char version = little ? magic[2] : magic[3];
    return (little || big) && (version == 42 || version == 43);  // 43: BigTIFF
}

std::unique_ptr<PictureFile> openTiff(const std::string& path) {
    return std::make_unique<TiffFile>(path);
}

}  // namespace raysweep
