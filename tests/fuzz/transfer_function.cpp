/// Tables of --transfer.
#include "raysweep/volume/transfer_function.h"
#include "fuzzed_file.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    return fuzz::accepts([&] { evaluate(readTransferFunction(file.path()), 0.5); });
}
