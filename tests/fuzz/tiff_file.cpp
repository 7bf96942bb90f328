/// TIFF as numbers.
#include "raysweep/image/tiff_file.h"
#include "fuzzed_file.h"

#include <algorithm>
#include <memory>

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    return fuzz::accepts([&] {
        const std::unique_ptr<PictureFile> tiff = openTiff(file.path());
        constexpr int kMostPages = 4;
        constexpr std::uint64_t kMostPixels = 1 << 24;  // what is allocated here, not by the reader
        for (int page = 0; page < std::min(tiff->pages(), kMostPages); ++page) {
            const PicturePage is = tiff->page(page);
            const std::uint64_t pixels = std::uint64_t(is.width) * std::uint64_t(is.height);
            if (!is.type || is.channels < 1 || pixels > kMostPixels) continue;
            const std::unique_ptr<std::byte[]> samples(new std::byte[pixels * sizeOf(*is.type)]);
            tiff->readSamples(page, is.channels - 1, samples.get());
        }
    });
}
