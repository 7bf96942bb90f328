/// Our geometry files (docs/ct.md).
#include "fuzzed_file.h"
#include "raysweep/camera/projection_geometry.h"
#include "raysweep/scan/geometry_json.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return fuzz::accepts([&] { geometryFromJson(std::string(reinterpret_cast<const char*>(data), size)); });
}
