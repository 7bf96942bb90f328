/// What the targets share. A target feeds what a fuzzer made, or a file of tests/fuzz/corpus, to one reader.
#pragma once

#include "raysweep/core/error.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace raysweep::fuzz {

/// Bytes as a file, in memory, for readers that take a path.
class FuzzedFile {
  public:
    FuzzedFile(const std::uint8_t* data, std::size_t size) : descriptor_(::memfd_create("fuzzed", 0)) {
        for (std::size_t done = 0; done < size;) {
            const ssize_t now = ::write(descriptor_, data + done, size - done);
            if (now <= 0) std::abort();
            done += std::size_t(now);
        }
    }
    ~FuzzedFile() { ::close(descriptor_); }
    FuzzedFile(const FuzzedFile&) = delete;
    FuzzedFile& operator=(const FuzzedFile&) = delete;

    std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

  private:
    int descriptor_;
};

/// Input that is refused is as good as input that is read; any other exception is a fault of the reader.
template <class Read>
int accepts(const Read& read) {
    try {
        read();
    } catch (const Error&) {
    }
    return 0;
}

}  // namespace raysweep::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
