#include "raysweep/volume/checksum.h"

#include "raysweep/volume/vdb_io.h"
#include "raysweep/volume/voxel_check.h"

#include "support/temporary_folder.h"
#include "support/volumes.h"

#include <gtest/gtest.h>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

/// Tiles, and leaves beside them on either side of 0.
FloatGrid::Ptr tilesAndVoxels() {
    const FloatGrid::Ptr grid = FloatGrid::create(0);
    grid->tree().addTile(1, Coord(0, 0, 0), 0.5f, true);
    grid->tree().addTile(1, Coord(0, 8, -8), 0.25f, true);
    grid->tree().addTile(1, Coord(8, 0, 0), 0.75f, false);  // inactive: does not count
    for (int i = -20; i < 40; i += 3) grid->tree().setValueOn(Coord(i, 30 - i, i), float(i));
    grid->tree().setValueOn(Coord(100, 2, 3), 0);
    return grid;
}

}  // namespace

TEST(Checksum, IsTheHashOfCoordinatesAndValues) {
    EXPECT_EQ(checksum(*FloatGrid::create(0)), "cbf29ce484222325");  // FNV-1a of nothing
    const FloatGrid::Ptr grid = FloatGrid::create(0);
    grid->tree().setValueOn(Coord(1, -2, 3), 1.5f);
    grid->tree().setValueOn(Coord(1, -2, 200), 0);
    // By another program: 01 00 00 00, fe ff ff ff, 03 00 00 00, 00 00 c0 3f, ...
    EXPECT_EQ(checksum(*grid), "40fba1d14cca264f");
}

TEST(Checksum, GoesByCoordinatesWhateverTheTree) {
    // Two leaves side by side along z, and two along y: slices and rows of both are interleaved.
    const FloatGrid::Ptr grid = FloatGrid::create(0);
    for (int x = 6; x < 10; ++x)
        for (int y = 6; y < 10; ++y)
            for (int z = 6; z < 10; ++z) grid->tree().setValueOn(Coord(x, y, z), float(100 * x + 10 * y + z));
    EXPECT_EQ(checksum(*grid), "eff7c9a5c2291a55");
}

TEST(Checksum, TilesCountAsTheirVoxels) {
    const FloatGrid::Ptr grid = tilesAndVoxels(), copy = grid->deepCopy();
    voxelizeTiles(*copy);
    ASSERT_NE(copy->tree().activeTileCount(), grid->tree().activeTileCount());
    EXPECT_EQ(checksum(*copy), checksum(*grid));
}

TEST(Checksum, AnyChangeOfAVoxelChangesIt) {
    const FloatGrid::Ptr grid = tilesAndVoxels();
    const auto changed = [&](const auto& change) {
        const FloatGrid::Ptr copy = grid->deepCopy();
        change(copy->tree());
        return checksum(*copy);
    };
    const std::string before = checksum(*grid);
    EXPECT_EQ(changed([](openvdb::FloatTree&) {}), before);
    EXPECT_NE(changed([](openvdb::FloatTree& tree) { tree.setValueOn(Coord(1, 2, 3), 0.50001f); }), before);
    EXPECT_NE(changed([](openvdb::FloatTree& tree) { tree.setValueOn(Coord(9, 2, 3), 0.75f); }), before);
    EXPECT_NE(changed([](openvdb::FloatTree& tree) { tree.setValueOff(Coord(100, 2, 3)); }), before);  // a zero
}

TEST(Checksum, StaysWhatItIsFromFileToFile) {
    const test::TemporaryFolder folder;
    for (const bool half : {false, true}) {
        const FloatGrid::Ptr grid = test::cloudVolume(24);
        grid->setSaveFloatAsHalf(half);
        writeVdb(folder / "first.vdb", {grid});
        const VdbFile first = readVdb(folder / "first.vdb");
        writeVdb(folder / "again.vdb", {first.grids[0]});
        const auto read = openvdb::gridPtrCast<FloatGrid>(first.grids[0]),
                   again = openvdb::gridPtrCast<FloatGrid>(readVdb(folder / "again.vdb").grids[0]);
        EXPECT_EQ(checksum(*again), checksum(*read));
        EXPECT_EQ(checksum(*read) == checksum(*grid), !half);
    }
}
