/// Pictures that the library reads itself: OpenEXR, and the check of JPEGs.
#include "fuzzed_file.h"
#include "raysweep/image/exr.h"
#include "raysweep/image/image_io.h"
#include "raysweep/image/jpeg_check.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    return fuzz::accepts([&] {
        isCutJpeg(file.path());
        if (isExr(file.path())) readImage(file.path());
    });
}
