/// NRRD volumes.
#include "fuzzed_file.h"
#include "raysweep/formats/nrrd_volume.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    return fuzz::accepts([&] { readNrrd(file.path()); });
}
