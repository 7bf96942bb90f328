// Users see what raysweep.h includes, itself or through another header: that is what docs/overview.md lists, module by
// module, and none of it is a detail of the solvers.
#include "support/source_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>

namespace fs = std::filesystem;
using raysweep::test::sourceFolder;

namespace {

/// Adds `header` ("module/name.h") and all that it includes of the library.
void addIncluded(const std::string& header, std::set<std::string>& known) {
    if (!known.insert(header).second) return;
    const std::regex include("#include \"raysweep/(.*)\"");
    std::ifstream file(fs::path(sourceFolder()) / "lib" / "raysweep" / header);
    std::smatch match;
    for (std::string line; std::getline(file, line);)
        if (std::regex_match(line, match, include)) addIncluded(match[1], known);
}

/// "module/name.h" of every header in the last column of the overview's table of modules.
std::set<std::string> listed() {
    const std::regex row(R"(\| `(\w+)/` \| .* \| ([^|]*) \|)"), name("`([a-z_]+\\.h)`");
    std::set<std::string> headers;
    std::ifstream file(fs::path(sourceFolder()) / "docs" / "overview.md");
    std::smatch match;
    for (std::string line; std::getline(file, line);) {
        if (!std::regex_match(line, match, row)) continue;
        const std::string module = match[1], names = match[2];
        for (std::sregex_iterator it(names.begin(), names.end(), name), end; it != end; ++it)
            headers.insert(module + "/" + (*it)[1].str());
    }
    return headers;
}

}  // namespace

TEST(PublicHeaders, AreThoseThatTheOverviewLists) {
    std::set<std::string> included;
    addIncluded("raysweep.h", included);
    included.erase("raysweep.h");
    EXPECT_GT(included.size(), 40u);
    EXPECT_EQ(included, listed());
}
