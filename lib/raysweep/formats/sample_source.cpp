#include "raysweep/formats/sample_source.h"

#include "raysweep/core/run_outputs.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <fstream>

namespace raysweep {
namespace {

constexpr double kMostDeflated = 1040;  ///< deflate packs up to 1032 bytes into one; and there are ends of blocks

[[noreturn]] void failEarly(const DataPiece& piece) {
    failRead(piece.file, "its data end too early: " + std::to_string(piece.bytes) +
                             " bytes of samples are needed; the file is truncated, or the header is wrong");
}

std::ifstream openAt(const DataPiece& piece) {
    noteInput(piece.file);
    std::ifstream in(piece.file, std::ios::binary);
    if (!in || !in.seekg(std::streamoff(piece.skip))) failRead(piece.file, "it cannot be opened");
    return in;
}

/// What passes over bytes by reading them.
class Packed : public SampleSource {
  public:
    void skip(std::uint64_t bytes) override {
        std::array<std::byte, 1 << 14> some;
        for (std::uint64_t left = bytes; left > 0;) {
            const auto now = std::min<std::uint64_t>(left, some.size());
            read(some.data(), now);
            left -= now;
        }
    }
};

class RawSource : public SampleSource {
  public:
    explicit RawSource(const DataPiece& piece) : piece_(piece), in_(openAt(piece)), at_(piece.skip) {}

    void read(std::byte* to, std::uint64_t bytes) override {
        if (!in_.read(reinterpret_cast<char*>(to), std::streamsize(bytes))) failEarly(piece_);
        at_ += bytes;
    }

    void skip(std::uint64_t bytes) override {
        if (!in_.seekg(std::streamoff(bytes), std::ios::cur)) failEarly(piece_);
        at_ += bytes;
    }

    std::uint64_t rest() override {
        const std::uint64_t size = sizeOfFile(piece_.file);
        return size > at_ ? size - at_ : 0;
    }

  private:
    DataPiece piece_;
    std::ifstream in_;
    std::uint64_t at_;
};

class DeflateSource : public Packed {
  public:
    explicit DeflateSource(const DataPiece& piece) : piece_(piece), in_(openAt(piece)) {
        constexpr int kGzipOrZlib = 15 + 32;
        if (inflateInit2(&stream_, kGzipOrZlib) != Z_OK) failRead(piece.file, "zlib cannot be used");
        skip(piece.skipUnpacked);
    }
    ~DeflateSource() override { inflateEnd(&stream_); }
    DeflateSource(const DeflateSource&) = delete;
    DeflateSource& operator=(const DeflateSource&) = delete;

    void read(std::byte* to, std::uint64_t bytes) override {
        for (std::uint64_t done = 0; done < bytes;) {
            const std::size_t got = some(to + done, std::min<std::uint64_t>(bytes - done, 1 << 30));
            if (got == 0) failEarly(piece_);
            done += got;
        }
    }

    std::uint64_t rest() override {
        std::byte one;
        return some(&one, 1);
    }

  private:
    /// @return bytes unpacked; 0 at the end
    std::size_t some(std::byte* to, std::uint64_t bytes) {
        stream_.next_out = reinterpret_cast<Bytef*>(to);
        stream_.avail_out = uInt(bytes);
        while (stream_.avail_out == bytes && !ended_) {
            if (stream_.avail_in == 0) refill();
            const bool starved = stream_.avail_in == 0;
            const int result = inflate(&stream_, Z_NO_FLUSH);
            if (result == Z_STREAM_END)
                startNext();
            else if (result == Z_BUF_ERROR && starved)
                failEarly(piece_);
            else if (result != Z_OK && result != Z_BUF_ERROR)
                failRead(piece_.file, std::string("its compressed data are damaged") +
                                          (stream_.msg ? std::string(" (") + stream_.msg + ")" : ""));
        }
        return std::size_t(bytes - stream_.avail_out);
    }

    void refill() {
        in_.read(reinterpret_cast<char*>(buffer_.data()), std::streamsize(buffer_.size()));
        stream_.next_in = buffer_.data();
        stream_.avail_in = uInt(in_.gcount());
    }

    /// Gzip files may be several, one behind the other. What follows and is none of them does not count.
    void startNext() {
        if (stream_.avail_in == 0) refill();
        ended_ = stream_.avail_in == 0 || *stream_.next_in != 0x1f;
        if (!ended_) inflateReset(&stream_);
    }

    DataPiece piece_;
    std::ifstream in_;
    z_stream stream_ = {};
    std::array<Bytef, 1 << 16> buffer_;
    bool ended_ = false;
};

class TextSource : public Packed {
  public:
    TextSource(const DataPiece& piece, SampleType type) : piece_(piece), in_(openAt(piece)), type_(type) {}

    void read(std::byte* to, std::uint64_t bytes) override {
        withSampleType(type_, [&](auto zero) {
            for (std::uint64_t n = 0; n < bytes; n += sizeof zero) {
                const auto value = number<decltype(zero)>();
                std::memcpy(to + n, &value, sizeof value);
            }
        });
    }

    std::uint64_t rest() override { return word().empty() ? 0 : 1; }

  private:
    static bool separates(int c) { return std::isspace(c) || c == ','; }

    std::string word() {
        constexpr std::size_t kLongest = 400;
        std::string text;
        int c = 0;
        while ((c = in_.get()) != std::ifstream::traits_type::eof() && separates(c)) {
        }
        for (; c != std::ifstream::traits_type::eof() && !separates(c); c = in_.get()) {
            if (text.size() >= kLongest) failRead(piece_.file, "its data are no text");
            text.push_back(char(c));
        }
        return text;
    }

    template <class Sample>
    Sample number() {
        const std::string text = word();
        if (text.empty()) failEarly(piece_);
        double real = 0;
        std::int64_t whole = 0;
        if constexpr (std::is_floating_point_v<Sample>) {
            if (toNumber(text, real)) return Sample(real);
        } else {
            if (toWhole(text, whole) && double(whole) >= lowestOf(type_) && double(whole) <= highestOf(type_))
                return Sample(whole);
        }
        failRead(piece_.file, "in its data: '" + text.substr(0, 40) + "' is no " + nameOf(type_));
    }

    DataPiece piece_;
    std::ifstream in_;
    SampleType type_;
};

class HexSource : public Packed {
  public:
    explicit HexSource(const DataPiece& piece) : piece_(piece), in_(openAt(piece)) {}

    void read(std::byte* to, std::uint64_t bytes) override {
        for (std::uint64_t n = 0; n < bytes; ++n) {
            const int high = digit();
            to[n] = std::byte(high << 4 | digit());
        }
    }

    std::uint64_t rest() override {
        const int c = next();
        return c == std::ifstream::traits_type::eof() ? 0 : 1;
    }

  private:
    int next() {
        int c = 0;
        while (std::isspace(c = in_.get())) {
        }
        return c;
    }

    int digit() {
        const int c = next();
        if (c == std::ifstream::traits_type::eof()) failEarly(piece_);
        if (!std::isxdigit(c)) failRead(piece_.file, "in its data: there is a byte that is no hexadecimal digit");
        return std::isdigit(c) ? c - '0' : std::tolower(c) - 'a' + 10;
    }

    DataPiece piece_;
    std::ifstream in_;
};

}  // namespace

void requirePieces(const std::vector<DataPiece>& pieces, SampleCoding coding, SampleType type) {
    for (const DataPiece& piece : pieces) {
        const std::uint64_t size = sizeOfFile(piece.file);
        const double there = double(size) - double(piece.skip),
                     needed = double(piece.bytes) + double(piece.skipUnpacked);
        double least = needed;
        if (coding == SampleCoding::deflate) least = needed / kMostDeflated;
        if (coding == SampleCoding::hex) least = 2 * needed;
        if (coding == SampleCoding::text) least = 2 * needed / double(sizeOf(type)) - 1;
        if (there < least)
            failRead(piece.file, "its data end too early: " + std::to_string(piece.bytes) +
                                     " bytes of samples are needed, there are " +
                                     (coding == SampleCoding::raw ? "" : "packed ") +
                                     std::to_string(std::uint64_t(std::max(0.0, there))) +
                                     "; the file is truncated, or the header is wrong");
    }
}

std::unique_ptr<SampleSource> openPiece(const DataPiece& piece, SampleCoding coding, SampleType type) {
    switch (coding) {
        case SampleCoding::deflate:
            return std::make_unique<DeflateSource>(piece);
        case SampleCoding::text:
            return std::make_unique<TextSource>(piece, type);
        case SampleCoding::hex:
            return std::make_unique<HexSource>(piece);
        case SampleCoding::raw:
            break;
    }
    return std::make_unique<RawSource>(piece);
}

}  // namespace raysweep
