#include "raysweep/phantoms/engine_room.h"

#include "raysweep/core/error.h"
#include "raysweep/formats/volume_import.h"
#include "raysweep/phantoms/engine_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "support/volumes.h"
#include "support/worst.h"

using namespace raysweep;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;

namespace {

/// Voxels of constant density.
FloatGrid::Ptr slab(const Coord& low, const Coord& high, float value = 0.5f) {
    FloatGrid::Ptr grid = FloatGrid::create(0.0f);
    grid->fill(CoordBBox(low, high), value, true);
    return grid;
}

EngineRoomOptions withEngine(const FloatGrid::Ptr& engine) {
    EngineRoomOptions options;
    options.engine = engine;
    return options;
}

double sum(const FloatGrid& grid) {
    double total = 0;
    for (auto it = grid.cbeginValueOn(); it; ++it) total += double(*it) * double(it.getVoxelCount());
    return total;
}

double voxelVolume(const FloatGrid& grid) {
    return std::abs(grid.transform().baseMap()->getAffineMap()->getMat4().det());
}

std::uint64_t volumeOf(const Coord& dims) {
    return std::uint64_t(dims.x()) * std::uint64_t(dims.y()) * std::uint64_t(dims.z());
}

std::string errorOf(const EngineRoomOptions& options) {
    try {
        makeEngineRoom(options);
    } catch (const InvalidArgument& e) {
        return e.what();
    }
    return "no error";
}

void expectError(const EngineRoomOptions& options, const std::string& part) {
    const std::string message = errorOf(options);
    EXPECT_NE(message.find(part), std::string::npos) << message << "\n  lacks: " << part;
}

}  // namespace

TEST(EngineRoom, HasTheSizesOfThePaper) {
    EngineRoomOptions options = withEngine(slab(Coord(0), Coord(255, 255, 107)));
    EngineRoom room = makeEngineRoom(options);
    EXPECT_EQ(room.dims, Coord(276, 276, 130));
    EXPECT_EQ(room.engineDims, Coord(256, 256, 110));
    EXPECT_EQ(room.density->evalActiveVoxelBoundingBox(), CoordBBox(Coord(0), room.dims.offsetBy(-1)));
    options.size = 148;
    room = makeEngineRoom(options);
    EXPECT_EQ(room.dims, Coord(148, 148, 75));
    EXPECT_EQ(room.density->evalActiveVoxelBoundingBox(), CoordBBox(Coord(0), room.dims.offsetBy(-1)));
    options = EngineRoomOptions();
    EXPECT_EQ(makeEngineRoom(options).dims, Coord(276, 276, 130));
    options.size = 148;
    EXPECT_EQ(makeEngineRoom(options).dims, Coord(148, 148, 75));
}

TEST(EngineRoom, KeepsTheEnginesVoxelsAndTheirPlace) {
    const FloatGrid::Ptr engine = FloatGrid::create(0.0f);
    const Coord low(-7, 100, 13), dims(30, 21, 18);
    for (int i = 0; i < dims.x(); ++i)
        for (int j = 0; j < dims.y(); ++j)
            for (int k = 0; k < dims.z(); ++k)
                engine->tree().setValueOn(low + Coord(i, j, k), 0.1f + 0.001f * float((i * 37 + j * 11 + k * 5) % 900));
    engine->tree().setValueOn(low + Coord(90, 5, dims.z() + 60), 0.01f);  // an artefact in an empty slice
    const openvdb::Mat4d skew(1.0, 0.0, 0.0, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 7.0, 8.0, 9.0, 1.0);
    engine->setTransform(openvdb::math::Transform::createLinearTransform(skew));

    const EngineRoom room = makeEngineRoom(withEngine(engine));
    EXPECT_EQ(room.engineDims, dims + Coord(0, 0, 2));
    EXPECT_EQ(room.dims, dims + Coord(20, 20, 22));
    const Coord shift = Coord(10, 10, 4) - low;
    for (auto it = engine->cbeginValueOn(); it; ++it) {
        if (it.getCoord().z() > low.z() + dims.z()) continue;
        EXPECT_EQ(room.density->tree().getValue(it.getCoord() + shift), *it) << it.getCoord();
    }
    const openvdb::Vec3d moved =
        room.density->indexToWorld(Coord(4, 5, 6) + shift) - engine->indexToWorld(Coord(4, 5, 6));
    EXPECT_LT(moved.length(), 1e-9);
    // Nothing but engine and walls: all voxels of the room less the space between the walls, and the engine.
    EXPECT_EQ(room.density->activeVoxelCount(),
              volumeOf(room.dims) - volumeOf(room.dims.offsetBy(-8)) + volumeOf(dims));
}

TEST(EngineRoom, WallsHaveTheirThickness) {
    for (const int wall : {2, 4, 9}) {
        for (const bool open : {false, true}) {
            EngineRoomOptions options = withEngine(slab(Coord(0), Coord(19, 15, 11)));
            options.wall = wall;
            options.openFront = open;
            const EngineRoom room = makeEngineRoom(options);
            const Coord inside = room.dims.offsetBy(-2 * wall);
            EXPECT_EQ(inside, Coord(20 + 12, 16 + 12, 12 + 2 + 12));
            const std::uint64_t front = open ? std::uint64_t(wall) * std::uint64_t(inside.x() * inside.z()) : 0;
            EXPECT_EQ(room.density->activeVoxelCount(), volumeOf(room.dims) - volumeOf(inside) - front + 20 * 16 * 12u);
            const auto density = [&](int i, int j, int k) { return room.density->tree().getValue(Coord(i, j, k)); };
            const Coord middle(room.dims.x() / 2, room.dims.y() / 2, room.dims.z() - wall - 4);
            for (int axis = 0; axis < 3; ++axis) {
                for (int n = 0; n < wall; ++n) {
                    Coord low = middle, high = middle;
                    low[std::size_t(axis)] = n;
                    high[std::size_t(axis)] = room.dims[std::size_t(axis)] - 1 - n;
                    EXPECT_EQ(density(low.x(), low.y(), low.z()), axis == 1 && open ? 0 : kWallDensity);
                    EXPECT_EQ(density(high.x(), high.y(), high.z()), kWallDensity);
                }
            }
            EXPECT_EQ(density(wall + 6, wall + 6, wall), 0.5f) << "the engine stands on the floor";
            EXPECT_EQ(density(wall + 5, wall + 6, wall), 0) << "air on its sides";
            EXPECT_EQ(density(wall + 6, wall + 6, wall + 12), 0) << "air above";
        }
    }
}

TEST(EngineRoom, LightHasItsAreaAndPower) {
    const FloatGrid::Ptr engine = slab(Coord(0), Coord(255, 255, 107));
    const openvdb::Mat4d skew(0.5, 0.0, 0.0, 0.0, 0.1, 0.7, 0.0, 0.0, 0.2, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 1.0);
    engine->setTransform(openvdb::math::Transform::createLinearTransform(skew));
    EngineRoomOptions options = withEngine(engine);
    options.radiance = 3;
    const EngineRoom room = makeEngineRoom(options);
    const int width = 268 / 2, depth = 268;
    const double radius = 0.25 * width;
    // A disk's lattice points: their number is off by about the root of the radius' length, 10 of 3500 here.
    const double cells = width * depth - kPi * radius * radius;
    EXPECT_NEAR(double(room.emission->activeVoxelCount()), cells, 15);
    EXPECT_NEAR(room.lightArea, double(room.emission->activeVoxelCount()) * 0.5 * 0.7, 1e-6 * room.lightArea);
    EXPECT_NEAR(room.lightPower, kPi * 3 * room.lightArea, 1e-12 * room.lightPower);
    // What the grid holds is that power; values are floats.
    EXPECT_NEAR(sum(*room.emission) * voxelVolume(*room.emission) / room.lightPower, 1, 1e-6);
}

TEST(EngineRoom, LightCoversTheLeftHalfOfTheCeilingAroundAHole) {
    const EngineRoom room = makeEngineRoom(withEngine(slab(Coord(0), Coord(39, 29, 19))));
    const int k = room.dims.z() - 4, width = (room.dims.x() - 8) / 2, depth = room.dims.y() - 8;
    const auto lit = [&](int i, int j) { return room.emission->tree().isValueOn(Coord(4 + i, 4 + j, k)); };
    EXPECT_EQ(room.emission->evalActiveVoxelBoundingBox(), CoordBBox(Coord(4, 4, k), Coord(3 + width, 3 + depth, k)));
    EXPECT_TRUE(lit(0, 0) && lit(width - 1, depth - 1) && !lit(width, 0));
    EXPECT_FALSE(lit(width / 2, depth / 2));
    for (int i = 0; i < width; ++i) {
        for (int j = 0; j < depth; ++j) {
            EXPECT_EQ(lit(i, j), lit(width - 1 - i, j));
            EXPECT_EQ(lit(i, j), lit(i, depth - 1 - j));
            EXPECT_EQ(room.density->tree().getValue(Coord(4 + i, 4 + j, k)), kWallDensity) << "light is on a wall";
            EXPECT_EQ(room.density->tree().getValue(Coord(4 + i, 4 + j, k - 1)), 0) << "and faces the room";
        }
    }
}

TEST(EngineRoom, PaintCoversWhatIsThere) {
    EngineRoomOptions options = withEngine(slab(Coord(0), Coord(19, 15, 11)));
    EXPECT_FALSE(makeEngineRoom(options).albedo);
    options.coloured = true;
    const EngineRoom room = makeEngineRoom(options);
    ASSERT_TRUE(room.albedo);
    EXPECT_EQ(room.albedo->activeVoxelCount(), room.density->activeVoxelCount());
    const auto paint = [&](int i, int j, int k) {
        const Coord at(i, j, k);
        EXPECT_TRUE(room.albedo->tree().isValueOn(at));
        return room.albedo->tree().getValue(at);
    };
    const int x = room.dims.x(), y = room.dims.y(), z = room.dims.z();
    const openvdb::Vec3s left = paint(0, y / 2, z / 2), right = paint(x - 1, y / 2, z / 2),
                         back = paint(x / 2, y - 1, z / 2);
    EXPECT_GT(left[0], 3 * left[1]);
    EXPECT_GT(right[1], 3 * right[0]);
    EXPECT_TRUE(back[0] == back[1] && back[1] == back[2]);
    EXPECT_EQ(paint(10, 10, 4), back) << "the engine is grey";
    EXPECT_EQ(paint(x / 2, y / 2, 0), back);
    EXPECT_EQ(paint(x / 2, y / 2, z - 1), back);
}

TEST(EngineRoom, ASmallerRoomKeepsTheEnginesAmount) {
    const FloatGrid::Ptr engine = FloatGrid::create(0.0f);
    for (int i = 0; i < 50; ++i)
        for (int j = 0; j < 40; ++j)
            for (int k = 0; k < 30; ++k)
                engine->tree().setValueOn(Coord(3 + i, j - 9, k), 0.2f + 0.7f * float((i * i + 3 * j + k) % 100) / 100);
    EngineRoomOptions options = withEngine(engine);
    options.size = 37 + 20;  // 50/37 is not whole
    const EngineRoom room = makeEngineRoom(options);
    EXPECT_EQ(room.dims.x(), 57);
    EXPECT_EQ(room.engineDims, Coord(37, 30, 24));  // 40 and 32 (two slices of air) times 37/50, and up
    double amount = 0;
    const CoordBBox inside(Coord(4), room.dims.offsetBy(-5));
    for (auto it = room.density->cbeginValueOn(); it; ++it)
        if (inside.isInside(it.getCoord())) amount += *it;
    const double walls = 0;                                                              // none is inside
    EXPECT_NEAR((amount - walls) * voxelVolume(*room.density) / sum(*engine), 1, 1e-5);  // sums of floats
    // Its first voxel begins where the engine's does.
    const openvdb::Vec3d corner = room.density->indexToWorld(openvdb::Vec3d(9.5, 9.5, 3.5));
    EXPECT_LT((corner - openvdb::Vec3d(2.5, -9.5, -0.5)).length(), 1e-9);
}

TEST(EngineRoom, TakesTheSlicesThatAreGiven) {
    EngineRoomOptions options = withEngine(slab(Coord(0), Coord(19, 15, 29)));
    options.slices = {5, 24};
    EXPECT_EQ(makeEngineRoom(options).engineDims, Coord(20, 16, 20));
    options.slices = {40, 50};
    expectError(options, "slices 0 to 29");
    options.slices = {8, 7};
    expectError(options, "the last of the slices 7: must be at or behind the first");
}

TEST(EngineRoom, RefusesWhatMakesNoRoom) {
    EngineRoomOptions options;
    options.size = 35;
    expectError(options, "size 35: must be in [");
    options.size = 0;
    options.wall = 1;
    expectError(options, "wall 1: must be in [2,64]");
    expectError(withEngine(FloatGrid::create(0.0f)), "is empty");
    expectError(withEngine(slab(Coord(0), Coord(9), 0.0f)), "is empty");
    expectError(withEngine(slab(Coord(0), Coord(9), -1.0f)), "no active voxel is larger than 0");
    const FloatGrid::Ptr mixed = slab(Coord(0), Coord(9));
    mixed->tree().setValueOn(Coord(3), -1000.0f);
    expectError(withEngine(mixed), "negative values, down to -1000");
    mixed->tree().setValueOn(Coord(3), std::numeric_limits<float>::quiet_NaN());
    expectError(withEngine(mixed), "not a number");
    options = withEngine(slab(Coord(0), Coord(49, 9, 9)));
    options.size = 71;
    expectError(options, "a room of at most 70");
    expectError(withEngine(slab(Coord(0), Coord(5000, 9, 9))), "give a size");
}

TEST(EngineRoom, OfTheEnginesScan) {
    const std::string path = test::findData("volumes/engine.nrrd");
    if (path.empty()) GTEST_SKIP() << "needs volumes/engine.nrrd; set RAYSWEEP_DATA";
    const EngineRoom room = makeEngineRoom(withEngine(importVolume({path}, {}).grid));
    EXPECT_EQ(room.dims, Coord(276, 276, 130));
    // Voxel (128,128,64) of the scan is 133: see the test of import.
    EXPECT_FLOAT_EQ(room.density->tree().getValue(Coord(138, 138, 68)), 133 / 255.0f);
}

TEST(EngineBlock, ABoreInItsLinerHasTheirAreas) {
    const int edge = 256, height = 110;
    const FloatGrid::Ptr block = makeEngineBlock(Coord(edge, edge, height));
    EXPECT_EQ(block->evalActiveVoxelBoundingBox().min().z(), 0);
    float least = 1, most = 0;
    for (auto it = block->cbeginValueOn(); it; ++it) least = std::min(least, *it), test::raiseTo(most, *it);
    EXPECT_GT(least, 0);
    EXPECT_EQ(most, 1);
    // Half way up, around the second bore: 0.55 but for a liner of 1 around nothing. The edge of a bar is a linear ramp
    // one voxel wide, which adds pi/12 to its area.
    const int k = height / 2, low = int(0.31 * edge), high = int(0.49 * edge);
    double amount = 0;
    for (int i = low; i < high; ++i)
        for (int j = low; j < high; ++j) amount += block->tree().getValue(Coord(i, j, k));
    const auto area = [&](double radius) { return kPi * (radius * radius * edge * edge + 1 / 12.0); };
    const double whole = double(high - low) * (high - low);
    const double expected = 0.55 * (whole - area(0.080)) + area(0.080) - area(0.062);
    EXPECT_NEAR(amount / expected, 1, 1e-3);  // sums over a lattice of ramps one voxel wide
    EXPECT_EQ(block->tree().getValue(Coord(int(0.40 * edge), int(0.40 * edge), k)), 0) << "the bore is open";
}
