/// A file to read from that is told how long it is.
#pragma once

#include <cstdint>
#include <fstream>
#include <streambuf>
#include <string>
#include <vector>

namespace raysweep {

/// Differs from std::filebuf in two ways. OpenVDB asks for the position and moves it a little for every leaf, which
/// here are no calls of the system and keep what was read ahead. And a damaged size makes OpenVDB ask for more bytes
/// than there are, into memory that does not hold them: such a read ends before anything is copied.
class InputFile : public std::streambuf {
  public:
    InputFile(const std::string& path, std::uintmax_t size)
        : size_(static_cast<std::streamoff>(size)), ahead_(std::size_t(1) << 18) {
        file_.pubsetbuf(nullptr, 0);
        file_.open(path, std::ios::in | std::ios::binary);
        setg(ahead_.data(), ahead_.data(), ahead_.data());
    }

    bool isOpen() const { return file_.is_open(); }

  protected:
    int_type underflow() override {
        readFrom(position());
        return gptr() == egptr() ? traits_type::eof() : traits_type::to_int_type(*gptr());
    }

    std::streamsize xsgetn(char* to, std::streamsize count) override {
        constexpr std::streamsize kSmall = 1 << 14;  // below it what there is may be taken
        if (count > kSmall && count > size_ - position()) return 0;
        return std::streambuf::xsgetn(to, count);
    }

    pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode) override {
        const off_type to = offset + (from == std::ios::beg ? 0 : from == std::ios::cur ? position() : size_);
        return seekpos(to, std::ios::in);
    }

    pos_type seekpos(pos_type to, std::ios::openmode) override {
        const std::streamoff within = to - pos_type(start_);
        if (within >= 0 && within <= egptr() - eback()) {
            setg(eback(), eback() + within, egptr());
            return to;
        }
        if (file_.pubseekpos(to, std::ios::in) == pos_type(off_type(-1))) return pos_type(off_type(-1));
        start_ = to;
        setg(ahead_.data(), ahead_.data(), ahead_.data());
        return to;
    }

  private:
    std::streamoff position() const { return start_ + (gptr() - eback()); }

    void readFrom(std::streamoff position) {
        start_ = position;
        const std::streamsize count = file_.sgetn(ahead_.data(), std::streamsize(ahead_.size()));
        setg(ahead_.data(), ahead_.data(), ahead_.data() + count);
    }

    std::filebuf file_;  // stands at the end of what was read ahead
    std::streamoff size_, start_ = 0;
    std::vector<char> ahead_;  // the bytes from start_ on
};

}  // namespace raysweep
