// The emulator judges the library: it must not be built of what it judges.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "support/source_folder.h"

namespace fs = std::filesystem;

TEST(Cube4Layering, TakesCoreImageAndVolumeAlone) {
    const std::set<std::string> allowed = {"core", "image", "volume"};
    const std::string start = "#include \"raysweep/";
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(raysweep::test::sourceFolder()) / "hardware")) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".h" && extension != ".cpp") continue;
        ++files;
        std::ifstream source(entry.path());
        for (std::string line; std::getline(source, line);) {
            if (line.rfind(start, 0) != 0) continue;
            const std::string module = line.substr(start.size(), line.find('/', start.size()) - start.size());
            EXPECT_TRUE(allowed.count(module)) << entry.path() << ": " << line;
        }
    }
    EXPECT_GT(files, 40);
}
