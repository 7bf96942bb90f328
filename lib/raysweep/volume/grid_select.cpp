#include "raysweep/volume/grid_select.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/solid.h"

#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <vector>

namespace raysweep {
namespace {

using openvdb::DoubleGrid;
using openvdb::FloatGrid;
using openvdb::GridBase;
using openvdb::Vec3SGrid;
using Accepts = std::function<bool(const GridBase&)>;

bool isScalar(const GridBase& grid) {
    return grid.isType<FloatGrid>() || grid.isType<DoubleGrid>();
}
bool isScalarOrColor(const GridBase& grid) {
    return grid.isType<FloatGrid>() || grid.isType<Vec3SGrid>();
}

[[noreturn]] void fail(const VdbFile& file, const std::string& why, Remedy remedy = Remedy::none,
                       const std::string& rest = "") {
    throw InvalidArgument("'" + file.path + "': " + why, remedy,
                          rest + ". It holds" + (file.grids.empty() ? " no grids" : ":\n" + listGrids(file)));
}

std::vector<GridBase::Ptr> named(const VdbFile& file, const std::string& name) {
    std::vector<GridBase::Ptr> found;
    for (const GridBase::Ptr& grid : file.grids)
        if (grid->getName() == name) found.push_back(grid);
    return found;
}

/// Splits "name[3]" into name and 3. @return false if `text` does not end so.
bool splitIndex(const std::string& text, std::string& name, std::size_t& index) {
    const std::size_t open = text.rfind('[');
    if (open == std::string::npos || text.back() != ']' || text.size() - open < 3 || text.size() - open > 8)
        return false;
    const std::string digits = text.substr(open + 1, text.size() - open - 2);
    if (digits.find_first_not_of("0123456789") != std::string::npos) return false;
    name = text.substr(0, open);
    index = std::stoul(digits);
    return true;
}

std::string quoted(const std::string& name) {
    return "'" + name + "'";
}

/// The one grid called `name`, or null if there is none.
GridBase::Ptr findNamed(const VdbFile& file, const std::string& name) {
    const auto found = named(file, name);
    if (found.size() == 1) return found.front();
    if (found.size() > 1)
        fail(file, std::to_string(found.size()) + " grids are called " + quoted(name) + "; " + quoted(name + "[0]") +
                       " picks the first, " + quoted(name + "[1]") + " the second");
    std::string base;
    std::size_t index = 0;
    if (!splitIndex(name, base, index)) return nullptr;
    const auto indexed = named(file, base);
    return index < indexed.size() ? indexed[index] : nullptr;
}

GridBase::Ptr find(const VdbFile& file, const std::string& name, const Accepts& accepts, const std::string& kind) {
    if (!name.empty()) {
        if (const GridBase::Ptr grid = findNamed(file, name)) return grid;
        fail(file, "there is no grid called " + quoted(name));
    }
    if (const GridBase::Ptr grid = findNamed(file, "density")) return grid;
    std::vector<GridBase::Ptr> candidates;
    for (const GridBase::Ptr& grid : file.grids)
        if (accepts(*grid)) candidates.push_back(grid);
    if (candidates.empty()) fail(file, "there is no grid of " + kind);
    if (candidates.size() > 1)
        fail(file, "none of the " + kind + " grids is called 'density'; say by name which to use");
    return candidates.front();
}

void requireType(const VdbFile& file, const GridBase& grid, const Accepts& accepts, const std::string& kind) {
    if (accepts(grid)) return;
    const std::string what = "the grid " + quoted(grid.getName()) + " has the type " + grid.valueType();
    if (grid.isType<openvdb::points::PointDataGrid>())
        fail(file,
             "the grid " + quoted(grid.getName()) +
                 " holds points, not a volume; rasterize them first (Blender: Points to Volume, Houdini: VDB from "
                 "Particles)");
    fail(file, what + ", but " + kind + " is needed; convert it first");
}

FloatGrid::Ptr toFloat(const GridBase::Ptr& grid) {
    if (grid->isType<DoubleGrid>()) return std::make_shared<FloatGrid>(*openvdb::gridPtrCast<DoubleGrid>(grid));
    return openvdb::gridPtrCast<FloatGrid>(grid);
}

const char* className(const GridBase& grid) {
    switch (grid.getGridClass()) {
        case openvdb::GRID_LEVEL_SET:
            return ", level set";
        case openvdb::GRID_FOG_VOLUME:
            return ", fog volume";
        case openvdb::GRID_STAGGERED:
            return ", staggered";
        default:
            return "";
    }
}

}  // namespace

FloatGrid::Ptr selectScalar(const VdbFile& file, const std::string& name) {
    const GridBase::Ptr grid = find(file, name, isScalar, "float");
    requireType(file, *grid, isScalar, "float");
    return toFloat(grid);
}

FloatGrid::Ptr selectDensity(const VdbFile& file, const std::string& name) {
    const FloatGrid::Ptr grid = selectScalar(file, name);
    if (grid->getGridClass() == openvdb::GRID_LEVEL_SET)
        fail(file,
             "the grid " + quoted(grid->getName()) +
                 " is a level set: its values are distances to a surface, not densities; ",
             Remedy::fillLevelSet, "convert it first (Houdini: Convert VDB to Fog)");
    return grid;
}

FloatGrid::Ptr selectLevelSet(const VdbFile& file, const std::string& name) {
    const FloatGrid::Ptr grid = selectScalar(file, name);
    if (grid->getGridClass() != openvdb::GRID_LEVEL_SET)
        fail(file, "the grid " + quoted(grid->getName()) + " is not a level set", Remedy::isNoLevelSet);
    return levelSetToSolid(*grid);
}

FloatGrid::Ptr selectSolid(const VdbFile& file, const std::string& name) {
    const FloatGrid::Ptr grid = selectScalar(file, name);
    return grid->getGridClass() == openvdb::GRID_LEVEL_SET ? levelSetToSolid(*grid) : grid;
}

GridBase::ConstPtr selectGrid(const VdbFile& file, const std::string& name) {
    const GridBase::Ptr grid = find(file, name, isScalarOrColor, "float or vec3s");
    requireType(file, *grid, isScalarOrColor, "float or vec3s");
    return grid;
}

GridBase::ConstPtr selectValues(const VdbFile& file, const std::string& name) {
    const auto accepts = [](const GridBase& grid) { return isScalar(grid) || isScalarOrColor(grid); };
    const GridBase::Ptr grid = find(file, name, accepts, "float or vec3s");
    requireType(file, *grid, accepts, "float or vec3s");
    if (grid->isType<DoubleGrid>()) return toFloat(grid);
    return grid;
}

std::string listGrids(const VdbFile& file) {
    std::string text;
    for (std::size_t i = 0; i < file.grids.size(); ++i) {
        const GridBase& grid = *file.grids[i];
        std::string name = grid.getName();
        if (named(file, name).size() > 1) {
            const auto sameName = [&](const GridBase::Ptr& other) { return other->getName() == grid.getName(); };
            const auto index = std::count_if(file.grids.begin(), file.grids.begin() + std::ptrdiff_t(i), sameName);
            name += "[" + std::to_string(index) + "]";
        }
        text += (text.empty() ? "  " : "\n  ") + (name.empty() ? "(no name)" : name) + ": " + grid.valueType() +
                className(grid) + ", " + std::to_string(grid.activeVoxelCount()) + " active voxels";
    }
    return text;
}

}  // namespace raysweep
