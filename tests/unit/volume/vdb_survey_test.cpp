// Damaged .vdb files: no memory for what is not there, and one bad grid does not hide the others.
#include "raysweep/core/error.h"
#include "raysweep/volume/vdb_io.h"
#include "support/expect_error.h"
#include "support/files.h"
#include "support/memory.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;
using test::contentsOf;
using test::writeBytes;

namespace {

FloatGrid::Ptr gridCalled(const std::string& name, const Coord& at = Coord(0)) {
    const FloatGrid::Ptr grid = FloatGrid::create();
    grid->setName(name);
    grid->tree().setValueOn(Coord(0), 1.0f);
    grid->tree().setValueOn(at, 2.0f);
    return grid;
}

/// The bytes of three grids, "one", "two" and "three".
std::string threeGrids(const std::string& path) {
    initializeGrids();
    writeVdb(path, {gridCalled("one"), gridCalled("two"), gridCalled("three")});
    return contentsOf(path);
}

std::vector<std::string> namesOf(const VdbSurvey& survey) {
    std::vector<std::string> names;
    for (const auto& grid : survey.file.grids) names.push_back(grid->getName());
    return names;
}

}  // namespace

TEST(VdbSurvey, ShowsGridsBesideOnesThatCannotBeRead) {
    const test::TemporaryFolder folder;
    const std::string path = folder / "a.vdb";
    std::string bytes = threeGrids(path);
    EXPECT_TRUE(surveyVdb(path).unreadable.empty());

    const std::size_t second = bytes.find("two"), type = bytes.find("Tree_float", second);
    bytes.replace(type, 10, "Tree_flaot");
    writeBytes(path, bytes);
    const VdbSurvey survey = surveyVdb(path);
    EXPECT_EQ(namesOf(survey), (std::vector<std::string>{"one", "three"}));
    ASSERT_EQ(survey.unreadable.size(), 1u);
    EXPECT_EQ(survey.unreadable[0].name, "two");
    EXPECT_EQ(survey.unreadable[0].type.substr(0, 10), "Tree_flaot");
    test::expectError<IoError>([&] { readVdb(path); }, "grid 2 of 3 ('two')");

    // The last one is cut off: what it holds is not all there.
    writeBytes(path, threeGrids(path).substr(0, bytes.size() - 10));
    const VdbSurvey cut = surveyVdb(path);
    EXPECT_EQ(namesOf(cut), (std::vector<std::string>{"one", "two"}));
    ASSERT_EQ(cut.unreadable.size(), 1u);
    EXPECT_NE(cut.unreadable[0].error.find("grid 3 of 3 ('three'): the file ends inside it"), std::string::npos);
}

// Every number of 32 bits in the part before the first tree is set to a large one in turn: reading may fail, but not
// for want of the memory that it says.
TEST(VdbSurvey, LengthsAreNotBelieved) {
    const test::TemporaryFolder folder;
    const std::string path = folder / "a.vdb";
    const std::string bytes = threeGrids(path);
    const std::size_t end = bytes.find("ScaleMap");
    ASSERT_NE(end, std::string::npos);
    const auto taken = test::bytesTaken([&] {
        for (std::size_t at = 8; at < end; ++at) {
            std::string damaged = bytes;
            const std::uint32_t large = 0xf0000000u;
            std::memcpy(&damaged[at], &large, sizeof large);
            writeBytes(path, damaged);
            try {
                surveyVdb(path);
            } catch (const IoError&) {
            }
        }
    });
    EXPECT_LT(taken.value_or(0), 300u << 20);  // 4 GB were asked for at some places
}

TEST(VdbSurvey, VoxelsAtTheEndsOfTheRangeOfCoordinatesAreRefused) {
    const test::TemporaryFolder folder;
    const std::string path = folder / "a.vdb";
    constexpr int kMax = std::numeric_limits<int>::max(), kMin = std::numeric_limits<int>::min();
    for (const Coord& at : {Coord(kMax, 0, 0), Coord(0, kMin, 0), Coord(0, 0, kFarthestVoxel + 1)}) {
        writeVdb(path, {gridCalled("far", at)});
        test::expectError<IoError>([&] { readVdb(path); }, "farther from 0 than 536870912");
        EXPECT_EQ(surveyVdb(path).unreadable.size(), 1u);
    }
    writeVdb(path, {gridCalled("far", Coord(kFarthestVoxel, -kFarthestVoxel, 0))});
    EXPECT_EQ(readVdb(path).grids.size(), 1u);
}
