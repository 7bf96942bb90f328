#include "raysweep/phantoms/engine_room.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"
#include "raysweep/phantoms/engine_block.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/coarsen.h"
#include "raysweep/volume/grid_transform.h"
#include "raysweep/volume/statistics.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;

constexpr int kGap = 6;                   ///< air on each side, voxels; above the engine twice as much
constexpr int kAirSlices = 2;             ///< above the engine's last slice
constexpr double kEmptySlice = 0.1;       ///< a slice is empty where nothing reaches this part of the largest value
constexpr int kLeast = 16, kMost = 4096;  ///< longest edge of the engine's box, voxels
constexpr int kPaperSize = 276;

/// Paint in a Cornell box.
const Vec3s kGrey(0.75f), kRed(0.65f, 0.06f, 0.05f), kGreen(0.12f, 0.45f, 0.10f);

int longestOf(const Coord& dims) {
    return std::max({dims.x(), dims.y(), dims.z()});
}

/// How much longer the room is than the engine's box, voxels.
int margin(const EngineRoomOptions& options) {
    return 2 * (options.wall + kGap);
}

/// A grid whose voxel (0,0,0) is the engine's first.
struct Engine {
    FloatGrid::Ptr grid;
    Coord dims;
};

void requireValues(const FloatGrid& grid) {
    const ValueRange range = valueRange(grid);
    const auto fail = [&](const std::string& why, Remedy remedy = Remedy::none) {
        throw InvalidArgument("the volume '" + grid.getName() + "' " + why, remedy);
    };
    if (range.notFinite > 0) fail("has voxels that are infinite or not a number; repair it first");
    if (range.max.empty() || !(range.max[0] > 0)) fail("is empty: no active voxel is larger than 0");
    if (range.min[0] < 0)
        fail("has negative values, down to " + std::to_string(range.min[0]) + ", which are no densities",
             Remedy::mapValues);
}

/// Calls `visit(value, box)` for the active voxels and tiles of `grid`, cut to `box`.
template <class Visit>
void forEachActiveIn(const CoordBBox& box, const FloatGrid& grid, const Visit& visit) {
    forEachActive(grid, [&](float value, CoordBBox part) {
        part.intersect(box);
        if (!part.empty()) visit(value, part);
    });
}

/// First and last slice in which something stands.
std::pair<int, int> filledSlices(const FloatGrid& grid, const CoordBBox& active) {
    const int low = active.min().z();
    std::vector<float> largest(std::size_t(active.dim().z()), 0.0f);
    forEachActive(grid, [&](float value, const CoordBBox& box) {
        for (int k = box.min().z(); k <= box.max().z(); ++k) {
            float& here = largest[std::size_t(k - low)];
            here = std::max(here, value);
        }
    });
    const float least = float(kEmptySlice) * *std::max_element(largest.begin(), largest.end());
    const auto filled = [&](float value) { return value >= least; };
    const auto first = std::find_if(largest.begin(), largest.end(), filled);
    const auto last = std::find_if(largest.rbegin(), largest.rend(), filled);
    return {low + int(first - largest.begin()), low + int(largest.rend() - last) - 1};
}

/// The box of the engine, see EngineRoom.
CoordBBox engineBox(const FloatGrid& grid, const std::optional<std::pair<int, int>>& slices) {
    const CoordBBox active = grid.evalActiveVoxelBoundingBox();
    if (longestOf(active.dim()) > (1 << 24))
        throw InvalidArgument("the volume's active voxels are " + std::to_string(longestOf(active.dim())) +
                              " voxels apart; crop it first");
    const auto [first, last] = slices ? *slices : filledSlices(grid, active);
    CoordBBox box;
    CoordBBox given = active;
    given.min().z() = first;
    given.max().z() = last;
    forEachActiveIn(given, grid, [&](float, const CoordBBox& part) { box.expand(part); });
    if (box.empty())
        throw InvalidArgument("no active voxel is in the slices " + std::to_string(first) + " to " +
                              std::to_string(last) + "; the volume has slices " + std::to_string(active.min().z()) +
                              " to " + std::to_string(active.max().z()));
    box.min().z() = first;
    box.max().z() = slices ? last : last + kAirSlices;
    return box;
}

/// Copies the active voxels of `from` in `box` so that the box begins at `to`.
void copyActive(const FloatGrid& from, const CoordBBox& box, const Coord& to, FloatGrid& target) {
    const Coord shift = to - box.min();
    auto voxels = target.getAccessor();
    forEachActiveIn(box, from, [&](float value, const CoordBBox& part) {
        if (part.min() == part.max())
            voxels.setValueOn(part.min() + shift, value);
        else
            target.fill(CoordBBox(part.min() + shift, part.max() + shift), value, true);
    });
}

/// The transform under which voxel `first` of a grid with `transform` is voxel (0,0,0).
openvdb::math::Transform::Ptr movedTo(const openvdb::math::Transform& transform, const Coord& first) {
    const auto moved = transform.copy();
    moved->preTranslate(first.asVec3d());
    return moved;
}

/// What the user brought, on voxels of the size that was asked for.
Engine cutEngine(const EngineRoomOptions& options) {
    const FloatGrid& given = *options.engine;
    requireValues(given);
    requireLinear(given);
    const CoordBBox box = engineBox(given, options.slices);
    Engine engine{FloatGrid::create(0.0f), box.dim()};
    engine.grid->setTransform(movedTo(given.transform(), box.min()));
    const int longest = longestOf(box.dim()), wanted = options.size ? options.size - margin(options) : longest;
    if (wanted > longest)
        throw InvalidArgument("size is " + std::to_string(options.size) + ", but the volume is " +
                              std::to_string(longest) + " voxels long, which makes a room of at most " +
                              std::to_string(longest + margin(options)) + "; a volume is not made finer");
    requireField(wanted <= kMost, "the volume's longest edge", wanted, "at most 4096 voxels; give a size");
    copyActive(given, box, Coord(0), *engine.grid);
    if (wanted == longest) return engine;
    const double resolution = double(wanted) / longest;
    engine.grid = openvdb::gridPtrCast<FloatGrid>(coarsened(*engine.grid, resolution));
    for (int axis = 0; axis < 3; ++axis)
        engine.dims[axis] = int(std::ceil(engine.dims[axis] * resolution - 1e-9));  // 55 and not 56 of 110 halves
    return engine;
}

/// In the proportions of the paper's scan.
Engine standIn(const EngineRoomOptions& options) {
    const int edge = (options.size ? options.size : kPaperSize) - margin(options);
    const Coord dims(edge, edge, int(std::lround(edge * 110 / 256.0)));
    const Engine engine{makeEngineBlock(dims), dims};
    const Coord room = dims.offsetBy(margin(options));
    const double h = options.voxelSize > 0 ? options.voxelSize : 2.0 / longestOf(room);
    const auto transform = openvdb::math::Transform::createLinearTransform(h);
    // The room's middle is the world's origin.
    const Coord first(options.wall + kGap, options.wall + kGap, options.wall);
    transform->preTranslate(first.asVec3d() - 0.5 * (room.asVec3d() - openvdb::Vec3d(1)));
    engine.grid->setTransform(transform);
    return engine;
}

/// Calls use(box, paint) for floor, ceiling and sides; they do not overlap.
template <class Use>
void forWalls(const EngineRoomOptions& options, const Coord& dims, const Use& use) {
    const int T = options.wall;
    const Coord last = dims.offsetBy(-1);
    use(CoordBBox(Coord(0), Coord(last.x(), last.y(), T - 1)), kGrey);
    use(CoordBBox(Coord(0, 0, dims.z() - T), last), kGrey);
    const int low = T, high = dims.z() - T - 1;  // between floor and ceiling
    use(CoordBBox(Coord(0, 0, low), Coord(T - 1, last.y(), high)), kRed);
    use(CoordBBox(Coord(dims.x() - T, 0, low), Coord(last.x(), last.y(), high)), kGreen);
    use(CoordBBox(Coord(T, dims.y() - T, low), Coord(dims.x() - T - 1, last.y(), high)), kGrey);
    if (!options.openFront) use(CoordBBox(Coord(T, 0, low), Coord(dims.x() - T - 1, T - 1, high)), kGrey);
}

/// Lights the ceiling's lowest layer. @return number of lit voxels
std::size_t lightCeiling(const EngineRoomOptions& options, const Coord& dims, float power, FloatGrid& emission) {
    const int T = options.wall, k = dims.z() - T;
    const int width = (dims.x() - 2 * T) / 2, depth = dims.y() - 2 * T;
    const double radius = 0.25 * std::min(width, depth);
    auto voxels = emission.getAccessor();
    std::size_t lit = 0;
    for (int i = 0; i < width; ++i) {
        for (int j = 0; j < depth; ++j) {
            if (std::hypot(i + 0.5 - 0.5 * width, j + 0.5 - 0.5 * depth) < radius) continue;
            voxels.setValueOn(Coord(T + i, T + j, k), power);
            ++lit;
        }
    }
    return lit;
}

void addLight(const EngineRoomOptions& options, EngineRoom& room) {
    const openvdb::math::Transform& transform = room.density->transform();
    const openvdb::Vec3d origin = transform.indexToWorld(openvdb::Vec3d(0));
    const openvdb::Vec3d i = transform.indexToWorld(openvdb::Vec3d(1, 0, 0)) - origin;
    const openvdb::Vec3d j = transform.indexToWorld(openvdb::Vec3d(0, 1, 0)) - origin;
    const openvdb::Vec3d k = transform.indexToWorld(openvdb::Vec3d(0, 0, 1)) - origin;
    const double area = i.cross(j).length(), thickness = std::abs(i.cross(j).dot(k)) / area;
    room.emission = FloatGrid::create(0.0f);
    room.emission->setName("emission");
    room.emission->setGridClass(openvdb::GRID_FOG_VOLUME);
    room.emission->setTransform(transform.copy());
    const std::size_t lit = lightCeiling(options, room.dims, float(kPi * options.radiance / thickness), *room.emission);
    room.lightArea = area * double(lit);
    room.lightPower = kPi * options.radiance * room.lightArea;
}

/// The albedo of every active voxel.
void addAlbedo(const EngineRoomOptions& options, EngineRoom& room) {
    room.albedo = Vec3SGrid::create(Vec3s(0));
    room.albedo->setName("albedo");
    room.albedo->setTransform(room.density->transform().copy());
    room.albedo->tree().topologyUnion(room.density->tree());
    forEachActive(*room.albedo, [](Vec3s& albedo, const CoordBBox&) { albedo = kGrey; });
    forWalls(options, room.dims,
             [&](const CoordBBox& box, const Vec3s& paint) { room.albedo->fill(box, paint, true); });
}

}  // namespace

void EngineRoomOptions::validate() const {
    requireField(wall >= 2 && wall <= 64, "wall", wall, "in [2,64]");
    const int least = kLeast + margin(*this);
    requireField(size == 0 || (size >= least && size <= kMost + margin(*this)), "size", size,
                 "in [" + std::to_string(least) + "," + std::to_string(kMost + margin(*this)) + "] with walls of " +
                     std::to_string(wall));
    requireField(voxelSize >= 0 && std::isfinite(voxelSize), "voxelSize", voxelSize, "0 (automatic) or larger");
    requireField(radiance >= 0 && std::isfinite(radiance), "radiance", radiance, "finite and not negative");
    if (slices)
        requireField(slices->second >= slices->first, "the last of the slices", slices->second,
                     "at or behind the first");
}

EngineRoom makeEngineRoom(const EngineRoomOptions& options) {
    options.validate();
    const Engine engine = options.engine ? cutEngine(options) : standIn(options);
    const Coord place(options.wall + kGap, options.wall + kGap, options.wall);
    EngineRoom room;
    room.engineDims = engine.dims;
    room.dims = engine.dims.offsetBy(margin(options));
    room.density = FloatGrid::create(0.0f);
    room.density->setName("density");
    room.density->setGridClass(openvdb::GRID_FOG_VOLUME);
    room.density->setTransform(movedTo(engine.grid->transform(), Coord(0) - place));
    copyActive(*engine.grid, CoordBBox(Coord(0), engine.dims.offsetBy(-1)), place, *room.density);
    forWalls(options, room.dims,
             [&](const CoordBBox& box, const Vec3s&) { room.density->fill(box, kWallDensity, true); });
    addLight(options, room);
    if (options.coloured) addAlbedo(options, room);
    return room;
}

}  // namespace raysweep
