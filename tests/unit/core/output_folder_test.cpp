// Folders of output are there whole or not at all, and nothing of the user's is lost.
#include "raysweep/core/output_folder.h"

#include "raysweep/core/error.h"
#include "raysweep/core/run_outputs.h"
#include "support/expect_error.h"
#include "support/files.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <fcntl.h>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <thread>

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

TEST(OutputFolder, LeavesAloneWhatIsPutThereMeanwhile) {
    const test::TemporaryFolder around;
    fs::create_directory(around / "old");
    writeBytes(around / "old/ours", "old");
    for (const bool inRun : {false, true}) {
        std::unique_ptr<RunOutputs> run;
        if (inRun) run = std::make_unique<RunOutputs>();
        fs::remove(around / "old/notes.txt");
        OutputFolder folder(around / "old", isOurs);
        writeBytes(fs::path(folder.temporary()) / "ours", "new");
        if (inRun) folder.commit();
        writeBytes(around / "old/notes.txt", "dear");
        test::expectError<IoError>([&] { inRun ? commitRunOutputs() : folder.commit(); }, "it holds 'notes.txt'");
        EXPECT_EQ(contentsOf(around / "old/notes.txt"), "dear");
        EXPECT_EQ(contentsOf(around / "old/ours"), "old");
    }
    EXPECT_EQ(entriesOf(around.path()), 1u);  // no temporary
}

// Where the file system can exchange two names; elsewhere there is a moment without.
TEST(OutputFolder, IsThereAtAnyMomentWhileItIsReplaced) {
    const test::TemporaryFolder around;
    fs::create_directory(around / "a");
    fs::create_directory(around / "b");
    const std::string a = around / "a", b = around / "b";
    if (::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) != 0)
        GTEST_SKIP() << "this file system cannot exchange names";
    std::atomic<bool> done{false};
    std::size_t looks = 0, missing = 0;
    std::thread watch([&] {
        for (; !done; ++looks) missing += !fs::exists(a);
    });
    for (int n = 0; n < 2000; ++n) {
        OutputFolder folder(a, isOurs);
        folder.commit();
    }
    done = true;
    watch.join();
    EXPECT_GT(looks, 100u);
    EXPECT_EQ(missing, 0u);
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
