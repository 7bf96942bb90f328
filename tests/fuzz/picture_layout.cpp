/// What ImageJ and OME-XML say of a TIFF's pages.
#include "raysweep/formats/picture_layout.h"
#include "fuzzed_file.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string description(reinterpret_cast<const char*>(data), size);
    return fuzz::accepts([&] {
        const PictureLayout layout = pictureLayout("a.tif", description, 2, 0);
        const int last = layout.page(layout.channels - 1, layout.slices - 1, layout.frames - 1);
        if (last + 1 != layout.channels * layout.slices * layout.frames) std::abort();
    });
}
