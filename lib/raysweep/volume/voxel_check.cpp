#include "raysweep/volume/voxel_check.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/channels.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Index64;
using openvdb::Vec3SGrid;

/// True if `good` holds for each channel.
template <class Good, class Value>
bool holds(const Good& good, const Value& v) {
    for (int c = 0; c < kChannels<Value>; ++c)
        if (!good(channel(v, c))) return false;
    return true;
}

// Written so that NaN fails.
bool isUsable(float v) {
    return v >= 0.0f && std::isfinite(v);
}
bool isFinite(float v) {
    return std::isfinite(v);
}
bool isFraction(float v) {
    return v >= 0.0f && v <= 1.0f;
}
bool fitsHalf(float v) {
    return !(std::abs(v) > kLargestHalf);
}

float zeroUnlessUsable(float v) {
    return isUsable(v) ? v : 0.0f;
}
float zeroUnlessFinite(float v) {
    return isFinite(v) ? v : 0.0f;
}
float clampedToFraction(float v) {
    return v > 0.0f ? std::min(v, 1.0f) : 0.0f;  // NaN too becomes 0
}
float clampedToHalf(float v) {
    return fitsHalf(v) ? v : std::copysign(kLargestHalf, v);
}

template <class Value>
struct Bad {
    Index64 count = 0;
    Coord first;
    Value value{};
    void add(Index64 voxels, const Coord& at, const Value& v) {
        if (count == 0) first = at, value = v;
        count += voxels;
    }
    Bad& operator+=(const Bad& other) {
        if (other.count) add(other.count, other.first, other.value);
        return *this;
    }
};

template <class GridT, class Good>
Bad<typename GridT::ValueType> findBad(const GridT& grid, const Good& good) {
    using Value = typename GridT::ValueType;
    return sumOverActive<Bad<Value>>(grid, [&](Bad<Value>& bad, const Value& v, const CoordBBox& box) {
        if (!holds(good, v)) bad.add(box.volume(), box.min(), v);
    });
}

/// How values that are not good are spoken of.
struct Refusal {
    const char *fault, *advice;
    Remedy remedy = Remedy::none;
};

template <class GridT, class Good>
void requireAll(const GridT& grid, const Good& good, const std::string& what, const Refusal& refusal) {
    const auto bad = findBad(grid, good);
    if (bad.count == 0) return;
    const openvdb::Vec3d world = grid.indexToWorld(bad.first);
    std::ostringstream text;
    text << what << ": " << bad.count << " active voxel" << (bad.count > 1 ? "s are " : " is ") << refusal.fault
         << ", the first at index (" << bad.first.x() << ", " << bad.first.y() << ", " << bad.first.z() << "), world ("
         << world.x() << ", " << world.y() << ", " << world.z() << "), with the value " << bad.value << "; "
         << refusal.advice;
    throw InvalidArgument(text.str(), refusal.remedy);
}

/// Applies `change` to the active values for which `good` does not hold. @return the number of voxels changed.
template <class GridT, class Good, class Change>
std::size_t changeBad(GridT& grid, const Good& good, const Change& change) {
    using Value = typename GridT::ValueType;
    return sumOverActive<std::size_t>(grid, [&](std::size_t& count, Value& v, const CoordBBox& box) {
        if (holds(good, v)) return;
        for (int c = 0; c < kChannels<Value>; ++c) channel(v, c) = change(channel(v, c));
        count += box.volume();
    });
}

template <class GridT>
void requireUsable(const GridT& grid, const std::string& what) {
    requireAll(grid, isUsable, what, {"negative, infinite or not a number", "repair the file", Remedy::repairVoxels});
}

template <class GridT>
void requireFractions(const GridT& grid, const std::string& what) {
    requireAll(grid, isFraction, what,
               {"outside [0,1]", "an albedo is a fraction: `repair` clamps it, `albedoScale` scales it"});
}

template <class GridT>
std::size_t clampGridForHalf(GridT& grid) {
    return grid.saveFloatAsHalf() ? changeBad(grid, fitsHalf, clampedToHalf) : 0;
}

}  // namespace

void checkVoxels(const FloatGrid& grid, const std::string& what) {
    requireUsable(grid, what);
}
void checkVoxels(const Vec3SGrid& grid, const std::string& what) {
    requireUsable(grid, what);
}

std::size_t repairVoxels(FloatGrid& grid) {
    return changeBad(grid, isUsable, zeroUnlessUsable);
}
std::size_t repairVoxels(Vec3SGrid& grid) {
    return changeBad(grid, isUsable, zeroUnlessUsable);
}

void checkFinite(const FloatGrid& grid, const std::string& what) {
    requireAll(grid, isFinite, what, {"infinite or not a number", "repair the file", Remedy::repairVoxels});
}

std::size_t repairNotFinite(FloatGrid& grid) {
    return changeBad(grid, isFinite, zeroUnlessFinite);
}

void checkAlbedo(const openvdb::GridBase& grid, const std::string& what) {
    if (const auto* scalar = dynamic_cast<const FloatGrid*>(&grid)) return requireFractions(*scalar, what);
    if (const auto* color = dynamic_cast<const Vec3SGrid*>(&grid)) return requireFractions(*color, what);
    throw InvalidArgument(what + ": the grid has the type " + grid.valueType() + ", but float or vec3s is needed");
}

std::size_t clampAlbedo(FloatGrid& grid) {
    return changeBad(grid, isFraction, clampedToFraction);
}
std::size_t clampAlbedo(Vec3SGrid& grid) {
    return changeBad(grid, isFraction, clampedToFraction);
}

void requireFiniteResult(const openvdb::GridBase& grid, const std::string& cause) {
    const std::string what = "the result's grid '" + grid.getName() + "'";
    const Refusal refusal{"infinite or not a number", cause.c_str()};
    if (const auto* scalar = dynamic_cast<const FloatGrid*>(&grid)) requireAll(*scalar, isFinite, what, refusal);
    if (const auto* color = dynamic_cast<const Vec3SGrid*>(&grid)) requireAll(*color, isFinite, what, refusal);
}

std::size_t clampForHalf(FloatGrid& grid) {
    return clampGridForHalf(grid);
}
std::size_t clampForHalf(Vec3SGrid& grid) {
    return clampGridForHalf(grid);
}

void voxelizeTiles(FloatGrid& grid) {
    grid.tree().voxelizeActiveTiles();
}
void voxelizeTiles(Vec3SGrid& grid) {
    grid.tree().voxelizeActiveTiles();
}

}  // namespace raysweep
