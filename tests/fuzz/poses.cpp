/// Files of poses: transforms.json, and lists of matrices.
#include "raysweep/camera/poses.h"
#include "fuzzed_file.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    return fuzz::accepts([&] { readPoses(file.path()); });
}
