#include "raysweep/core/memory.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "raysweep/core/error.h"
#include "support/temporary_folder.h"

using namespace raysweep;

namespace {

void write(const std::string& path, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    std::ofstream(path) << text << "\n";
}

double limitOf(const std::string& groups, const std::string& root) {
    std::istringstream lines(groups);
    return groupLimit(lines, root);
}

}  // namespace

TEST(Memory, LeastLimitOfAllGroupsAbove) {
    const test::TemporaryFolder folder;
    const std::string root = folder.path().string();
    const double none = std::numeric_limits<double>::infinity();
    EXPECT_EQ(limitOf("0::/a/b\n", root), none);
    write(folder / "memory.max", "max");
    write(folder / "a/memory.max", "2000");
    write(folder / "a/b/memory.max", "max");
    write(folder / "memory/c/memory.limit_in_bytes", "3000");
    write(folder / "memory/memory.limit_in_bytes", "9223372036854771712");
    EXPECT_EQ(limitOf("0::/a/b\n", root), 2000);
    EXPECT_EQ(limitOf("0::/\n", root), none);
    EXPECT_EQ(limitOf("8:pids:/a\n4:cpu,memory:/c/d\n0::/\n", root), 3000);
    EXPECT_EQ(limitOf("8:pids:/a\n", root), none);
    write(folder / "memory.max", "1000");
    EXPECT_EQ(limitOf("0::/of/the/host\n", root), 1000);
    EXPECT_EQ(limitOf("", root), none);
}

TEST(Memory, ErrorsSayHowMuchThereIs) {
    EXPECT_GT(physicalBytes(), 0u);
    EXPECT_NO_THROW(requireBytes(1, "this needs", "do without"));
    try {
        requireBytes(7e18, "this needs", "do without", Remedy::giveGrid);
        FAIL();
    } catch (const InvalidArgument& error) {
        const std::string text = error.what();
        EXPECT_EQ(text.rfind("this needs 7e+09 GB, there are ", 0), 0u) << text;
        EXPECT_EQ(error.remedy, Remedy::giveGrid);
        EXPECT_EQ(error.remedyAt, text.size());
    }
}
