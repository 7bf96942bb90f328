#include "raysweep/volume/grid_select.h"

#include "raysweep/core/error.h"

#include "support/other_grid.h"

#include <gtest/gtest.h>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

template <class GridT>
typename GridT::Ptr add(VdbFile& file, const std::string& name, int voxels = 1) {
    const auto grid = test::otherGrid<GridT>();
    grid->setName(name);
    for (int i = 0; i < voxels; ++i) grid->tree().setValueOn(Coord(i, 0, 0), typename GridT::ValueType(1));
    file.grids.push_back(grid);
    return grid;
}

VdbFile newFile() {
    VdbFile file;
    file.path = "some.vdb";
    return file;
}

std::string messageOf(const VdbFile& file, const std::string& name = "") {
    try {
        selectDensity(file, name);
    } catch (const InvalidArgument& e) {
        return e.what();
    }
    return "no error";
}

::testing::AssertionResult says(const std::string& message, const std::string& part) {
    if (message.find(part) != std::string::npos) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << "'" << part << "' is not in: " << message;
}

}  // namespace

TEST(SelectDensity, TakesTheGridCalledDensity) {
    VdbFile file = newFile();
    add<FloatGrid>(file, "heat");
    const auto density = add<FloatGrid>(file, "density");
    EXPECT_EQ(selectDensity(file), density);
    EXPECT_EQ(selectDensity(file, "heat")->getName(), "heat");
}

TEST(SelectDensity, TakesTheOnlyScalarGridWhateverItsName) {
    VdbFile file = newFile();
    add<openvdb::Vec3SGrid>(file, "velocity");
    const auto smoke = add<FloatGrid>(file, "smoke");
    EXPECT_EQ(selectDensity(file), smoke);
}

TEST(SelectDensity, ListsTheCandidatesWhenThereAreSeveral) {
    VdbFile file = newFile();
    add<FloatGrid>(file, "smoke", 3);
    add<FloatGrid>(file, "heat", 2);
    const std::string message = messageOf(file);
    EXPECT_TRUE(says(message, "some.vdb"));
    EXPECT_TRUE(says(message, "smoke: float, 3 active voxels"));
    EXPECT_TRUE(says(message, "heat: float, 2 active voxels"));
}

TEST(SelectDensity, NeverGuessesBetweenGridsOfOneName) {
    VdbFile file = newFile();
    const auto first = add<FloatGrid>(file, "density", 1);
    const auto second = add<FloatGrid>(file, "density", 2);
    EXPECT_TRUE(says(messageOf(file), "'density[1]' the second"));
    EXPECT_TRUE(says(messageOf(file), "density[1]: float, 2 active voxels"));
    EXPECT_TRUE(says(messageOf(file, "density"), "2 grids are called 'density'"));
    EXPECT_EQ(selectDensity(file, "density[0]"), first);
    EXPECT_EQ(selectDensity(file, "density[1]"), second);
    EXPECT_TRUE(says(messageOf(file, "density[2]"), "no grid called 'density[2]'"));
}

TEST(SelectDensity, ANameMayReallyEndInBrackets) {
    VdbFile file = newFile();
    const auto grid = add<FloatGrid>(file, "part[7]");
    EXPECT_EQ(selectDensity(file, "part[7]"), grid);
}

TEST(SelectDensity, RefusesALevelSetAndSaysHowToUseIt) {
    VdbFile file = newFile();
    add<FloatGrid>(file, "density")->setGridClass(openvdb::GRID_LEVEL_SET);
    try {
        selectDensity(file);
        FAIL() << "no error";
    } catch (const InvalidArgument& e) {
        EXPECT_TRUE(says(e.what(), "level set"));
        EXPECT_EQ(e.remedy, Remedy::fillLevelSet);
        EXPECT_EQ(std::string(e.what()).substr(e.remedyAt, 10), "convert it");
    }
}

TEST(SelectDensity, NamesTheTypeOfGridsItCannotUse) {
    VdbFile file = newFile();
    add<openvdb::BoolGrid>(file, "mask");
    add<openvdb::Vec3SGrid>(file, "velocity");
    add<openvdb::Int32Grid>(file, "id");
    EXPECT_TRUE(says(messageOf(file), "no grid of float"));
    EXPECT_TRUE(says(messageOf(file, "mask"), "type bool"));
    EXPECT_TRUE(says(messageOf(file, "velocity"), "type vec3s"));
    EXPECT_TRUE(says(messageOf(file, "id"), "type int32"));
    EXPECT_TRUE(says(messageOf(newFile()), "no grids"));
}

TEST(SelectDensity, ConvertsDoubles) {
    VdbFile file = newFile();
    const auto grid = add<openvdb::DoubleGrid>(file, "density");
    grid->tree().setValueOn(Coord(5, 6, 7), 0.25);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    const FloatGrid::Ptr density = selectDensity(file);
    EXPECT_EQ(density->tree().getValue(Coord(5, 6, 7)), 0.25f);
    EXPECT_EQ(density->getName(), "density");
    EXPECT_TRUE(density->transform() == grid->transform());
}

TEST(SelectGrid, TakesColours) {
    VdbFile file = newFile();
    add<FloatGrid>(file, "density");
    const auto color = add<openvdb::Vec3SGrid>(file, "Cd");
    EXPECT_EQ(selectGrid(file, "Cd"), color);
    EXPECT_THROW(selectGrid(file, "nothing"), InvalidArgument);
}
