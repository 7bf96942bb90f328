// docs/units.md is the one list of quantities: each name that it gives is one that a reader finds in the code.
#include "support/files.h"
#include "support/source_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

namespace fs = std::filesystem;
using raysweep::test::contentsOf;

namespace {

/// Identifiers and --flags of a source file, those in comments aside.
std::set<std::string> namesIn(const fs::path& path) {
    static const std::regex kName("--[a-z][a-z0-9-]*|[A-Za-z_][A-Za-z0-9_]*");
    std::set<std::string> names;
    std::ifstream source(path);
    for (std::string line; std::getline(source, line);) {
        line.resize(std::min(line.size(), line.find("//")));
        for (std::sregex_iterator it(line.begin(), line.end(), kName), end; it != end; ++it) names.insert(it->str());
    }
    return names;
}

/// Names of every file of the library and the command, by the file's name.
std::map<std::string, std::set<std::string>> namesOfTheCode() {
    std::map<std::string, std::set<std::string>> names;
    for (const char* folder : {"lib", "apps"})
        for (const auto& entry : fs::recursive_directory_iterator(fs::path(raysweep::test::sourceFolder()) / folder))
            if (entry.is_regular_file()) names[entry.path().filename().string()].merge(namesIn(entry.path()));
    return names;
}

}  // namespace

TEST(Units, EveryNameInTheListIsOneOfTheCode) {
    const auto code = namesOfTheCode();
    const std::string list = contentsOf(fs::path(raysweep::test::sourceFolder()) / "docs" / "units.md");
    // `name`, or `name` (file.h): then it is there.
    static const std::regex kQuoted("`([^`]+)`(?: \\(([a-z_]+\\.h)\\))?");
    int found = 0;
    for (std::sregex_iterator it(list.begin(), list.end(), kQuoted), end; it != end; ++it, ++found) {
        const std::string name = (*it)[1], file = (*it)[2];
        bool known = false;
        for (const auto& [path, names] : code) known |= (file.empty() || path == file) && names.count(name) > 0;
        EXPECT_TRUE(known) << "docs/units.md: `" << name << "` is nowhere in " << (file.empty() ? "lib, apps" : file);
    }
    EXPECT_GT(found, 30);
}
