/// COLMAP's models. The first byte says if they are binary; cameras, images and points follow, apart by four bytes
/// 0xff.
#include "fuzzed_file.h"
#include "raysweep/camera/poses.h"

#include <stdlib.h>

#include <filesystem>
#include <fstream>

using namespace raysweep;
namespace fs = std::filesystem;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fs::path folder = [] {
        std::string name = (fs::temp_directory_path() / "raysweep-fuzz-XXXXXX").string();
        if (!::mkdtemp(name.data())) std::abort();
        return fs::path(name);
    }();
    if (size == 0) return 0;
    const std::string extension = data[0] & 1 ? ".bin" : ".txt", end = "\xff\xff\xff\xff";
    std::string rest(reinterpret_cast<const char*>(data) + 1, size - 1);
    for (const char* name : {"cameras", "images", "points3D"}) {
        const std::size_t at = rest.find(end);
        std::ofstream(folder / (name + extension), std::ios::binary) << rest.substr(0, at);
        rest = at == std::string::npos ? "" : rest.substr(at + end.size());
    }
    const int result = fuzz::accepts([&] { readPoses(folder.string()); });
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    fs::create_directory(folder, ignored);
    return result;
}
