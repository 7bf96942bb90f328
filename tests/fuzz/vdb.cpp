/// OpenVDB files, with all that is looked at when they are shown.
#include "fuzzed_file.h"
#include "raysweep/volume/statistics.h"
#include "raysweep/volume/vdb_io.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    return fuzz::accepts([&] {
        for (const auto& grid : surveyVdb(file.path()).file.grids) {
            grid->activeVoxelCount();
            if (hasKnownValues(*grid)) valueRange(*grid);
        }
    });
}
