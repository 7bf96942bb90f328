/// Text files of angles.
#include "raysweep/scan/view_angles.h"
#include "fuzzed_file.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    return fuzz::accepts([&] { viewAngles(readAngleFile(file.path()), "", {}); });
}
