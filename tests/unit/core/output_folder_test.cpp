// Folders of output are there whole or not at all, and nothing of the user's is lost.
#include "raysweep/core/output_folder.h"

#include "raysweep/core/error.h"
#include "support/files.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace fs = std::filesystem;
using namespace raysweep;
using test::contentsOf;
using test::entriesOf;
using test::writeBytes;

namespace {

bool isOurs(const std::string& name) {
    return name.rfind("ours", 0) == 0;
}

std::string errorOf(const std::string& target) {
    try {
        OutputFolder folder(target, isOurs);
    } catch (const IoError& e) {
        return e.what();
    }
    return "no error";
}

}  // namespace

TEST(OutputFolder, AppearsWhenItIsCommittedAndNotOtherwise) {
    const test::TemporaryFolder around;
    {
        OutputFolder folder(around / "new", isOurs);
        writeBytes(fs::path(folder.temporary()) / "ours", "lost");
        EXPECT_FALSE(fs::exists(around / "new"));
    }
    EXPECT_TRUE(around.isEmpty());
    OutputFolder folder(around / "new/", isOurs);
    writeBytes(fs::path(folder.temporary()) / "ours", "kept");
    folder.commit();
    EXPECT_EQ(contentsOf(around / "new/ours"), "kept");
    EXPECT_EQ(entriesOf(around.path()), 1u);
}

TEST(OutputFolder, ReplacesAFolderOfItsKindAsAWhole) {
    const test::TemporaryFolder around;
    fs::create_directory(around / "old");
    writeBytes(around / "old/ours1", "old");
    writeBytes(around / "old/ours2", "old");
    {
        OutputFolder folder(around / "old", isOurs);
        writeBytes(fs::path(folder.temporary()) / "ours1", "new");
    }
    EXPECT_EQ(contentsOf(around / "old/ours1"), "old");
    fs::create_directory_symlink(around / "old", around / "link");
    OutputFolder folder(around / "link", isOurs);
    writeBytes(fs::path(folder.temporary()) / "ours1", "new");
    folder.commit();
    EXPECT_TRUE(fs::is_symlink(around / "link"));
    EXPECT_EQ(contentsOf(around / "old/ours1"), "new");
    EXPECT_EQ(entriesOf(around / "old"), 1u);
    EXPECT_EQ(entriesOf(around.path()), 2u);
}

TEST(OutputFolder, LeavesWhatIsNotItsOwnAlone) {
    const test::TemporaryFolder around;
    fs::create_directory(around / "mine");
    writeBytes(around / "mine/diary", "dear");
    EXPECT_NE(errorOf(around / "mine").find("it holds 'diary'"), std::string::npos);
    fs::remove(around / "mine/diary");
    fs::create_directory(around / "mine/ours");
    EXPECT_NE(errorOf(around / "mine").find("it holds 'ours'"), std::string::npos);
    writeBytes(around / "file", "text");
    EXPECT_NE(errorOf(around / "file").find("it is a file"), std::string::npos);
    EXPECT_NE(errorOf(around / "no/new").find("does not exist; create it first"), std::string::npos);
    EXPECT_EQ(entriesOf(around.path()), 2u);
}
