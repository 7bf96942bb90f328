// Files of output are there whole or not at all, follow nobody's link but the user's, and take no input's place.
#include "raysweep/core/output_file.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_folder.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/core/target_path.h"
#include "raysweep/core/text_file.h"
#include "support/expect_error.h"
#include "support/files.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

namespace fs = std::filesystem;
using namespace raysweep;
using test::contentsOf;
using test::entriesOf;
using test::writeBytes;

namespace {

unsigned modeOf(const fs::path& path) {
    struct stat found = {};
    ::stat(path.c_str(), &found);
    return found.st_mode & 0777u;
}

}  // namespace

TEST(OutputFile, AppearsWhenItIsCommittedAndNotOtherwise) {
    const test::TemporaryFolder around;
    {
        OutputFile file(around / "new.vdb");
        writeBytes(file.temporary(), "lost");
        EXPECT_FALSE(fs::exists(around / "new.vdb"));
        EXPECT_EQ(fs::path(file.temporary()).extension(), ".vdb");
    }
    EXPECT_TRUE(around.isEmpty());
    writeText(around / "new.vdb", "kept");
    EXPECT_EQ(contentsOf(around / "new.vdb"), "kept");
    EXPECT_EQ(entriesOf(around.path()), 1u);
}

// Two processes, or a program that was stopped and one that is not, never share a temporary; and while it is written,
// nobody else may look at it.
TEST(OutputFile, TemporariesAreNewFilesOfTheirOwn) {
    const test::TemporaryFolder around;
    OutputFile a(around / "x"), b(around / "x");
    EXPECT_NE(a.temporary(), b.temporary());
    EXPECT_EQ(modeOf(a.temporary()), 0600u);
}

TEST(OutputFile, HandsOnPermissions) {
    const test::TemporaryFolder around;
    writeBytes(around / "old", "old");
    fs::permissions(around / "old", fs::perms(0640));
    writeText(around / "old", "new");
    EXPECT_EQ(modeOf(around / "old"), 0640u);
    EXPECT_EQ(contentsOf(around / "old"), "new");
    const mode_t mask = ::umask(0);
    ::umask(mask);
    writeText(around / "fresh", "new");
    EXPECT_EQ(modeOf(around / "fresh"), 0666u & ~mask);
}

TEST(OutputFile, RefusesWhatItCannotReplace) {
    const test::TemporaryFolder around;
    writeBytes(around / "closed", "precious");
    fs::permissions(around / "closed", fs::perms(0444));
    ::mkfifo((around / "pipe").c_str(), 0600);
    fs::create_symlink("loop", around / "loop");
    test::expectError<IoError>([&] { OutputFile(around / "closed"); }, "it is read-only");
    test::expectError<IoError>([&] { OutputFile(around / "pipe"); }, "it is not a regular file");
    test::expectError<IoError>([&] { OutputFile("/dev/null"); }, "it is not a regular file");
    test::expectError<IoError>([&] { OutputFile(around / "loop"); }, "a link that leads nowhere");
    test::expectError<IoError>([&] { OutputFile(around / "no/file"); }, "does not exist; create it first");
    test::expectError<IoError>([&] { OutputFile(around / "folder/"); }, "it names a folder");
    test::expectError<IoError>([&] { OutputFile(around / std::string(256, 'n')); }, "too long");
    EXPECT_EQ(contentsOf(around / "closed"), "precious");
    writeText(around / std::string(255, 'n'), "the longest name there is");
}

TEST(OutputFile, WritesToWhatALinkLeadsTo) {
    const test::TemporaryFolder around;
    fs::create_directory(around / "there");
    writeBytes(around / "there/old", "old");
    fs::create_symlink("there/old", around / "link");
    fs::create_symlink("link", around / "second");
    fs::create_symlink("there/new", around / "dangling");
    writeText(around / "second", "new");
    writeText(around / "dangling", "fresh");
    EXPECT_EQ(contentsOf(around / "there/old"), "new");
    EXPECT_EQ(contentsOf(around / "there/new"), "fresh");
    EXPECT_TRUE(fs::is_symlink(around / "link") && fs::is_symlink(around / "second"));
    EXPECT_EQ(entriesOf(around.path()), 4u);
    EXPECT_EQ(entriesOf(around / "there"), 2u);
}

TEST(RunOutputs, OutputsAppearTogetherOrNotAtAll) {
    const test::TemporaryFolder around;
    const auto isOurs = [](const std::string& name) { return name == "a"; };
    const auto writeAll = [&] {
        writeText(around / "one", "1");
        OutputFolder folder(around / "two", isOurs);
        writeText(folder.temporary() + "/a", "2");
        folder.commit();
        makeOutputFolder(around / "three/four");
        EXPECT_FALSE(fs::exists(around / "one") || fs::exists(around / "two"));
    };
    {
        const RunOutputs run;
        writeAll();
    }
    EXPECT_TRUE(around.isEmpty());
    {
        const RunOutputs run;
        writeAll();
        commitRunOutputs();
        writeText(around / "late", "never");
    }
    EXPECT_EQ(contentsOf(around / "one"), "1");
    EXPECT_EQ(contentsOf(around / "two/a"), "2");
    EXPECT_TRUE(fs::is_directory(around / "three/four"));
    EXPECT_EQ(entriesOf(around.path()), 3u);
}

TEST(RunOutputs, NoFileThatWasReadIsReplaced) {
    const test::TemporaryFolder around;
    writeBytes(around / "in", "precious");
    fs::create_hard_link(around / "in", around / "hard");
    fs::create_symlink("in", around / "soft");
    {
        const RunOutputs run;
        bytesOfFile(around / "in", "a file");
        for (const char* name : {"in", "hard", "soft"})
            test::expectError<IoError>([&] { writeText(around / name, "new"); }, "one of the files that were read");
    }
    {
        const RunOutputs run;
        noteOutput(around / "soft");
        noteOutput(around / "not there yet");
        test::expectError<IoError>([&] { bytesOfFile(around / "hard", "text"); }, "would be written, but is also read");
    }
    writeText(around / "in", "new");  // outside of a run who reads and writes knows what is meant
    EXPECT_EQ(contentsOf(around / "hard"), "precious");
}

TEST(TargetPath, OneFileUnderSeveralNames) {
    const test::TemporaryFolder around;
    fs::create_directory(around / "sub");
    writeBytes(around / "a", "");
    writeBytes(around / "b", "");
    fs::create_hard_link(around / "a", around / "sub/hard");
    fs::create_symlink("../a", around / "sub/soft");
    fs::create_symlink("..", around / "sub/up");
    fs::create_symlink("nowhere", around / "dangling");
    const auto named = [&](const char* name) { return FileIdentity(around / name); };
    for (const char* name : {"a", "./a", "sub/../a", "missing/../a", "sub/hard", "sub/soft", "sub/up/a"})
        EXPECT_TRUE(named("a") == named(name)) << name;
    for (const auto& [one, other] : {std::pair("sub", "sub/"), std::pair("new", "sub/../new"),
                                     std::pair("new", "sub/up/new"), std::pair("dangling", "nowhere")})
        EXPECT_TRUE(named(one) == named(other)) << one;
    for (const auto& [one, other] : {std::pair("a", "b"), std::pair("a", "A"), std::pair("new", "newer")})
        EXPECT_TRUE(named(one) < named(other) || named(other) < named(one)) << one;
    EXPECT_TRUE(named("a").isWithin(FileIdentity(around.path().string())));
    EXPECT_TRUE(named("sub/up/sub/new").isWithin(named("sub")));
    for (const char* name : {"a", "sub", "subway"}) EXPECT_FALSE(named(name).isWithin(named("sub"))) << name;
}
