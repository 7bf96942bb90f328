/// RTK's geometry files.
#include "fuzzed_file.h"
#include "raysweep/scan/rtk_geometry.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    RtkDetector detector;
    detector.width = detector.height = 16;
    detector.spacing = DetectorPair{1, 1};
    return fuzz::accepts([&] { geometryFromRtk(std::string(reinterpret_cast<const char*>(data), size), detector); });
}
