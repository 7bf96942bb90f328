/// Records of runs (docs/record.md), without the volumes beside them.
#include "cube4/record.h"
#include "fuzzed_file.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    return fuzz::accepts([&] {
        constexpr double kMostVoxels = 1e6;
        const std::string kind = cube4::recordKind(file.path());
        if (kind == "illuminate") cube4::readIlluminationRecord(file.path(), kMostVoxels);
        if (kind == "reconstruct") cube4::readReconstructionRecord(file.path(), kMostVoxels);
    });
}
