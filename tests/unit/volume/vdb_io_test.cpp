#include "raysweep/volume/vdb_io.h"

#include "raysweep/core/error.h"
#include "support/files.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3SGrid;
using raysweep::test::contentsOf;
using raysweep::test::TemporaryFolder;
using raysweep::test::writeBytes;
namespace fs = std::filesystem;

namespace {

/// Irregular voxels and a tile, in several leaves and internal nodes. A background other than 0 makes the destructor
/// of a tree that was read half follow values as if they were pointers, were it called.
FloatGrid::Ptr makeGrid(const std::string& name, float background = 0) {
    const FloatGrid::Ptr grid = FloatGrid::create(background);
    grid->setName(name);
    for (int i = 0; i < 4000; ++i)
        grid->tree().setValueOn(Coord(i * 7 % 300 - 100, i * 13 % 97, i * 31 % 151),
                                0.001f * float(i * i % 1013) + 0.1f);
    grid->tree().addTile(1, Coord(512, 0, 0), 0.75f, true);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
    grid->transform().preRotate(0.3, openvdb::math::Z_AXIS);
    return grid;
}

std::string messageOfReading(const std::string& path) {
    try {
        readVdb(path);
    } catch (const IoError& e) {
        return e.what();
    }
    return "no error";
}

}  // namespace

TEST(VdbIo, WhatIsWrittenIsReadAgain) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.vdb";
    const FloatGrid::Ptr density = makeGrid("density");
    density->insertMeta("raysweep_note", openvdb::StringMetadata("kept"));
    const Vec3SGrid::Ptr color = Vec3SGrid::create();
    color->setName("Cd");
    color->tree().setValueOn(Coord(1, 2, 3), openvdb::Vec3s(0.1f, 0.2f, 0.3f));
    openvdb::MetaMap metadata;
    metadata.insertMeta("raysweep_version", openvdb::StringMetadata("1"));
    writeVdb(path, {color, density}, metadata);

    const VdbFile file = readVdb(path);
    ASSERT_EQ(file.grids.size(), 2u);
    EXPECT_EQ(file.metadata.metaValue<std::string>("raysweep_version"), "1");
    EXPECT_EQ(file.grids[0]->getName(), "Cd");
    EXPECT_EQ(file.grids[1]->metaValue<std::string>("raysweep_note"), "kept");
    EXPECT_TRUE(file.grids[1]->transform() == density->transform());
    const auto again = openvdb::gridPtrCast<FloatGrid>(file.grids[1]);
    EXPECT_TRUE(again->tree().hasSameTopology(density->tree()));
    EXPECT_EQ(again->activeVoxelCount(), density->activeVoxelCount());
    for (auto it = density->cbeginValueOn(); it; ++it) ASSERT_EQ(again->tree().getValue(it.getCoord()), *it);
}

TEST(VdbIo, HalfGridsPassThroughWithTheSameBits) {
    const TemporaryFolder folder;
    const FloatGrid::Ptr grid = makeGrid("density");
    grid->setSaveFloatAsHalf(true);
    writeVdb(folder / "a.vdb", {grid});
    const VdbFile once = readVdb(folder / "a.vdb");
    writeVdb(folder / "b.vdb", {once.grids[0]});
    const VdbFile twice = readVdb(folder / "b.vdb");
    EXPECT_TRUE(twice.grids[0]->saveFloatAsHalf());
    const auto a = openvdb::gridPtrCast<FloatGrid>(once.grids[0]), b = openvdb::gridPtrCast<FloatGrid>(twice.grids[0]);
    for (auto it = a->cbeginValueOn(); it; ++it) ASSERT_EQ(b->tree().getValue(it.getCoord()), *it);
    EXPECT_EQ(fs::file_size(folder / "a.vdb"), fs::file_size(folder / "b.vdb"));
}

// All behind the lengths of compressed leaves, which only OpenVDB's own writer stores: transform, topology, leaves.
TEST(VdbIo, LeavesCompressedByAllThreadsAreTheBytesOfOpenVdb) {
    const TemporaryFolder folder;
    const FloatGrid::Ptr density = makeGrid("density"), half = makeGrid("half", 3.0f);
    half->setSaveFloatAsHalf(true);
    const Vec3SGrid::Ptr color = Vec3SGrid::create();
    color->setName("Cd");
    color->denseFill({Coord(0), Coord(70)}, openvdb::Vec3s(0.1f, 0.2f, 0.3f));
    for (const openvdb::GridBase::ConstPtr& grid : openvdb::GridCPtrVec{density, half, color}) {
        writeVdb(folder / "ours.vdb", {grid});
        openvdb::io::File(folder / "theirs.vdb").write(openvdb::GridCPtrVec{grid});
        const std::string ours = contentsOf(folder / "ours.vdb"), theirs = contentsOf(folder / "theirs.vdb");
        const std::string lengths = "__delayedload";
        EXPECT_EQ(ours.find(lengths), std::string::npos);
        const std::size_t at = theirs.find(lengths) + lengths.size();
        ASSERT_LT(at, theirs.size());
        std::uint32_t size = 0;
        std::memcpy(&size, theirs.data() + at, sizeof size);
        const std::string rest = theirs.substr(at + sizeof size + size);
        ASSERT_GT(rest.size(), 1000u);
        EXPECT_TRUE(ours.size() > rest.size() && ours.compare(ours.size() - rest.size(), rest.size(), rest) == 0)
            << grid->getName();
    }
}

TEST(VdbIo, OpenVdbReadsWhatIsWritten) {
    const TemporaryFolder folder;
    const FloatGrid::Ptr a = makeGrid("a"), b = makeGrid("b", 3.0f), again = makeGrid("b", 5.0f);
    const openvdb::GridBase::Ptr sameTree = a->copyGrid();
    sameTree->setName("c");
    openvdb::MetaMap metadata;
    metadata.insertMeta("who", openvdb::StringMetadata("us"));
    writeVdb(folder / "a.vdb", {a, b, again, sameTree}, metadata);
    openvdb::io::File file(folder / "a.vdb");
    file.open();
    EXPECT_EQ(file.getMetadata()->metaValue<std::string>("who"), "us");
    const auto grids = file.getGrids();
    ASSERT_EQ(grids->size(), 4u);
    const FloatGrid::Ptr expected[] = {a, b, again, a};
    for (std::size_t i = 0; i < 4; ++i) {
        const auto grid = openvdb::gridPtrCast<FloatGrid>((*grids)[i]);
        if (i < 3) {
            EXPECT_EQ(grid->metaValue<std::int64_t>("file_voxel_count"), std::int64_t(expected[i]->activeVoxelCount()));
        }
        ASSERT_EQ(grid->activeVoxelCount(), expected[i]->activeVoxelCount());
        for (auto it = expected[i]->cbeginValueOn(); it; ++it)
            ASSERT_EQ(grid->tree().getValue(it.getCoord()), *it) << i;
    }
    EXPECT_EQ(&(*grids)[0]->constBaseTree(), &(*grids)[3]->constBaseTree());
    // Read in part: without the lengths, too.
    const auto part =
        openvdb::gridPtrCast<FloatGrid>(file.readGrid("a", openvdb::BBoxd(openvdb::Vec3d(-1), openvdb::Vec3d(1))));
    EXPECT_EQ(part->tree().getValue(Coord(0)), a->tree().getValue(Coord(0)));
}

TEST(VdbIo, GridsOfOneNameKeepTheirOrder) {
    const TemporaryFolder folder;
    openvdb::GridCPtrVec grids;
    for (int i = 0; i < 12; ++i) {
        const FloatGrid::Ptr grid = FloatGrid::create(0);
        grid->setName("density");
        grid->tree().setValueOn(Coord(0), float(i));
        grids.push_back(grid);
    }
    writeVdb(folder / "a.vdb", grids);
    const VdbFile file = readVdb(folder / "a.vdb");
    ASSERT_EQ(file.grids.size(), 12u);
    for (int i = 0; i < 12; ++i) {
        EXPECT_EQ(file.grids[std::size_t(i)]->getName(), "density");
        EXPECT_EQ(openvdb::gridPtrCast<FloatGrid>(file.grids[std::size_t(i)])->tree().getValue(Coord(0)), float(i));
    }
}

TEST(VdbIo, OneTreeSharedByTwoGridsIsReadForBoth) {
    const TemporaryFolder folder;
    const FloatGrid::Ptr a = makeGrid("a");
    const FloatGrid::Ptr b = openvdb::gridPtrCast<FloatGrid>(a->copyGrid());
    b->setName("b");
    writeVdb(folder / "a.vdb", {a, b});
    const VdbFile file = readVdb(folder / "a.vdb");
    ASSERT_EQ(file.grids.size(), 2u);
    EXPECT_EQ(file.grids[1]->activeVoxelCount(), a->activeVoxelCount());
}

// Both halves of a file matter: with the second grid cut, the first is whole and still nothing may be returned.
TEST(VdbIo, EveryTruncationIsNoticed) {
    const TemporaryFolder folder;
    writeVdb(folder / "whole.vdb", {makeGrid("density", 3.0f), makeGrid("second")});
    const std::string bytes = contentsOf(folder / "whole.vdb");
    ASSERT_GT(bytes.size(), 3000u);
    for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 16) {
        writeBytes(folder / "cut.vdb", bytes.substr(0, size));
        EXPECT_THROW(readVdb(folder / "cut.vdb"), IoError)
            << "cut after " << size << " of " << bytes.size() << " bytes";
    }
    writeBytes(folder / "cut.vdb", bytes.substr(0, bytes.size() - 1));
    const std::string message = messageOfReading(folder / "cut.vdb");
    EXPECT_NE(message.find("grid 2 of 2 ('second')"), std::string::npos) << message;
    EXPECT_NE(message.find("cut.vdb"), std::string::npos) << message;
}

TEST(VdbIo, SaysWhatIsWrongWithAFileThatCannotBeRead) {
    const TemporaryFolder folder;
    writeBytes(folder / "text.vdb", "this is no volume, whatever its name says");
    writeBytes(folder / "empty.vdb", "");
    EXPECT_NE(messageOfReading(folder / "text.vdb").find("not an OpenVDB file"), std::string::npos);
    EXPECT_NE(messageOfReading(folder / "empty.vdb").find("empty"), std::string::npos);
    EXPECT_NE(messageOfReading(folder / "none.vdb").find("there is no such file"), std::string::npos);
    EXPECT_NE(messageOfReading(folder.path().string()).find("folder"), std::string::npos);
}

TEST(VdbIo, AFailedWriteLeavesNothingBehind) {
    const TemporaryFolder folder;
    writeBytes(folder / "file", "");
    fs::create_directory(folder / "sub");
    EXPECT_THROW(writeVdb(folder / "missing/a.vdb", {makeGrid("a")}), IoError);
    EXPECT_THROW(writeVdb(folder / "file/a.vdb", {makeGrid("a")}), IoError);
    EXPECT_THROW(writeVdb(folder / "sub", {makeGrid("a")}), IoError);
    EXPECT_TRUE(fs::is_empty(folder / "sub"));
}
