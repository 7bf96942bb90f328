#include "raysweep/image/exr.h"

#include "raysweep/core/claimed_room.h"
#include "raysweep/core/parallel.h"
#include "raysweep/image/exr_header.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfThreading.h>
#include <OpenEXR/ImfVersion.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <tuple>
#include <vector>

namespace raysweep {
namespace {

constexpr int kLargest = 1 << 20;  ///< pixels along an edge; more is a damaged header

/// OpenEXR has threads of its own. Several of ours may come here at a time.
void allowThreads() {
    static std::mutex one;
    const std::lock_guard<std::mutex> lock(one);
    if (Imf::globalThreadCount() < threadCount()) Imf::setGlobalThreadCount(threadCount());
}

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

/// A channel's name without and with its layer, "layer.name".
struct ChannelName {
    std::string layer, name, full;
    explicit ChannelName(const std::string& whole) : full(whole) {
        const std::size_t dot = whole.rfind('.');
        if (dot != std::string::npos) layer = whole.substr(0, dot);
        name = whole.substr(dot + 1);  // npos + 1 is 0
    }
};

/// The place of a name in the order that people expect; the last one for names that are not known.
int rankOf(const std::string& name, bool position) {
    static const char* const kColour[] = {"r",     "red", "g",  "green", "b",  "blue", "y",  "real", "imag",  "a",
                                          "alpha", "ar",  "ra", "ag",    "ga", "ab",   "ba", "z",    "depth", "zback"};
    static const char* const kPosition[] = {"r",  "red", "g",    "green", "b",  "blue",  "x",
                                            "y",  "z",   "real", "imag",  "a",  "alpha", "ar",
                                            "ra", "ag",  "ga",   "ab",    "ba", "depth", "zback"};
    return position ? int(std::find(std::begin(kPosition), std::end(kPosition), lower(name)) - kPosition)
                    : int(std::find(std::begin(kColour), std::end(kColour), lower(name)) - kColour);
}

/// Names in the order in which pixels hold them: alphabetical, but colour first, and positions as x, y, z.
std::vector<std::string> orderedChannels(const Imf::ChannelList& list) {
    std::vector<ChannelName> names;
    for (auto channel = list.begin(); channel != list.end(); ++channel) names.emplace_back(channel.name());
    const auto has = [&](const std::string& layer, const char* name) {
        return std::any_of(names.begin(), names.end(),
                           [&](const ChannelName& other) { return other.layer == layer && lower(other.name) == name; });
    };
    using Key = std::tuple<std::string, int, std::string, std::string>;
    std::vector<Key> keys;
    for (const ChannelName& n : names) {
        const bool position = has(n.layer, "x") && (has(n.layer, "y") || has(n.layer, "z"));
        keys.emplace_back(n.layer, rankOf(n.name, position), n.name, n.full);
    }
    std::sort(keys.begin(), keys.end());
    std::vector<std::string> ordered;
    for (const Key& key : keys) ordered.push_back(std::get<3>(key));
    return ordered;
}

bool isPlain(const Imf::Header& header) {
    if (header.hasType() && Imf::isDeepData(header.type())) return false;
    const Imf::ChannelList& channels = header.channels();
    for (auto channel = channels.begin(); channel != channels.end(); ++channel)
        if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) return false;
    return channels.begin() != channels.end();
}

class ExrFile : public PictureFile {
  public:
    explicit ExrFile(const std::string& path) : path_(path), file_(path.c_str()) {}

    bool isReadable() const {
        for (int part = 0; part < file_.parts(); ++part)
            if (!isPlain(file_.header(part))) return false;
        return true;
    }

    int pages() override { return file_.parts(); }

    PicturePage page(int number) override {
        const Imf::Header& header = file_.header(number);
        const Imath::Box2i& window = header.dataWindow();
        const auto lengthOf = [](int low, int high) { return (long long)high - low + 1; };
        const long long width = lengthOf(window.min.x, window.max.x), height = lengthOf(window.min.y, window.max.y);
        if (width > kLargest || height > kLargest)
            failToRead(path_, "it claims to have " + std::to_string(width) + "x" + std::to_string(height) +
                                  " pixels; it is damaged");
        PicturePage page;
        page.width = int(width);
        page.height = int(height);
        page.type = SampleType::uint32;
        page.typeName = "uint";
        for (auto c = header.channels().begin(); c != header.channels().end(); ++c, ++page.channels)
            if (c.channel().type != Imf::UINT) page.type = SampleType::float32, page.typeName = "float";
        requireRoomFor(header, page);
        page.channelNames = orderedChannels(header.channels());
        page.left = window.min.x;
        page.top = window.min.y;
        if (header.hasName()) page.name = header.name();
        return page;
    }

    void readFloats(int number, float* to) override {
        const PicturePage size = page(number);
        const Imf::ChannelList& channels = file_.header(number).channels();
        const std::vector<std::string> names = orderedChannels(channels);
        const std::size_t stride = names.size();
        Imf::FrameBuffer frame;
        for (std::size_t c = 0; c < stride; ++c)
            insert(frame, number, names[c], {whole(channels, names[c]) ? Imf::UINT : Imf::FLOAT, to + c, stride});
        read(number, frame);
        // Integers have been read into the floats' places.
        for (std::size_t c = 0; c < stride; ++c) {
            if (!whole(channels, names[c])) continue;
            for (std::size_t i = 0; i < std::size_t(size.width) * std::size_t(size.height); ++i) {
                std::uint32_t value;
                std::memcpy(&value, to + i * stride + c, sizeof value);
                to[i * stride + c] = float(double(value) / 4294967295.0);
            }
        }
    }

    void readSamples(int number, int channel, std::byte* to) override {
        const PicturePage size = page(number);
        Imf::FrameBuffer frame;
        insert(frame, number, size.channelNames[std::size_t(channel)],
               {size.type == SampleType::uint32 ? Imf::UINT : Imf::FLOAT, to, 1});
        read(number, frame);
    }

  private:
    /// OpenEXR takes the memory for a tile at once.
    void requireRoomFor(const Imf::Header& header, const PicturePage& page) const {
        const bool tiled = header.hasTileDescription();
        const double tile = tiled ? double(header.tileDescription().xSize) * header.tileDescription().ySize : 0;
        const double pixels = std::max(double(page.width) * page.height, tile);
        requireRoom(path_, 4 * pixels * page.channels, double(std::filesystem::file_size(path_)));
    }

    static bool whole(const Imf::ChannelList& channels, const std::string& name) {
        return channels[name.c_str()].type == Imf::UINT;
    }

    /// Where the samples of a channel go, four bytes each and `stride` samples apart.
    struct Target {
        Imf::PixelType type;
        void* to;
        std::size_t stride;
    };

    void insert(Imf::FrameBuffer& frame, int number, const std::string& name, const Target& target) {
        const Imath::Box2i& window = file_.header(number).dataWindow();
        const std::size_t width = std::size_t(std::int64_t(window.max.x) - window.min.x + 1);
        const std::size_t pixel = 4 * target.stride, row = pixel * width;
        frame.insert(name, Imf::Slice::Make(target.type, target.to, window, pixel, row));
    }

    void read(int number, const Imf::FrameBuffer& frame) {
        try {
            allowThreads();
            const Imath::Box2i& window = file_.header(number).dataWindow();
            Imf::InputPart part(file_, number);
            part.setFrameBuffer(frame);
            part.readPixels(window.min.y, window.max.y);
        } catch (const std::exception& e) {
            failToRead(path_, std::string("Failed OpenEXR read: ") + e.what());
        }
    }

    std::string path_;
    Imf::MultiPartInputFile file_;
};

/// As other programs expect them.
std::string channelName(int channel, int channels) {
    static const char* const kNames[] = {"R", "G", "B", "A"};
    if (channels == 1) return "Y";
    return channel < 4 ? kNames[channel] : "channel" + std::to_string(channel);
}

}  // namespace

bool isExr(const std::string& path) {
    char magic[4] = {0};
    std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
    return Imf::isImfMagic(magic);
}

std::unique_ptr<PictureFile> openExr(const std::string& path) {
    requireSoundExrHeader(path);
    try {
        auto file = std::make_unique<ExrFile>(path);
        if (!file->isReadable()) return nullptr;
        return file;
    } catch (const std::exception& e) {
        failToRead(path, e.what() + std::string(kGivePicture));
    }
}

void writeExr(const std::string& path, const std::string& temporary, const Image& image) {
    try {
        allowThreads();
        Imf::Header header(image.width, image.height);
        Imf::FrameBuffer frame;
        const std::size_t pixel = sizeof(float) * std::size_t(image.channels);
        for (int c = 0; c < image.channels; ++c) {
            const std::string name = channelName(c, image.channels);
            header.channels().insert(name, Imf::Channel(Imf::FLOAT));
            frame.insert(name, Imf::Slice::Make(Imf::FLOAT, image.pixels.data() + c, header.dataWindow(), pixel,
                                                pixel * std::size_t(image.width)));
        }
        Imf::OutputFile file(temporary.c_str(), header);
        file.setFrameBuffer(frame);
        file.writePixels(image.height);
    } catch (const std::exception& e) {
        failToWrite(path, std::string("Failed OpenEXR write: ") + e.what());
    }
}

}  // namespace raysweep
