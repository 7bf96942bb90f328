/// Our geometry files (docs/ct.md).
#include "raysweep/scan/geometry_json.h"
#include "fuzzed_file.h"
#include "raysweep/camera/projection_geometry.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return fuzz::accepts([&] { geometryFromJson(std::string(reinterpret_cast<const char*>(data), size)); });
}
