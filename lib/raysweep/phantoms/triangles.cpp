#include "raysweep/phantoms/triangles.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/phantoms/convex_clip.h"
#include "raysweep/phantoms/leaf_fill.h"
#include "raysweep/phantoms/noise.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3SGrid;

constexpr double kSmallest = 0.18, kLargest = 0.4;   // radius of the ball of corners, of the cube's edge
constexpr double kClearest = 0.05, kDensest = 0.95;  // opacity

double edgeOf(const TrianglesOptions& options) {
    return options.voxelSize > 0 ? options.voxelSize : 2.0 / options.size;
}

/// Numbers evenly in [0,1), one after the other.
class Random {
  public:
    explicit Random(std::uint32_t seed) : seed_(seed) {}
    double next() { return latticeRandom(drawn_++, 0, 0, seed_); }
    double between(double low, double high) { return low + (high - low) * next(); }
    Vec3 inCube(double half) {
        const double x = between(-half, half), y = between(-half, half);
        return Vec3(x, y, between(-half, half));
    }
    Vec3 inBall() {
        for (;;)
            if (const Vec3 p = inCube(1); p.length2() <= 1) return p;
    }

  private:
    std::uint32_t seed_;
    int drawn_ = 0;
};

/// Half the edge of the cube that corners must lie in, voxels, so that no sheet comes out of the volume.
double room(const TrianglesOptions& options) {
    return 0.5 * (options.size - options.thickness);
}

/// A triangle in voxels from the middle of the cube.
struct Sheet {
    std::vector<HalfSpace> spaces;  ///< the prism
    Vec3 low, high;                 ///< its box
    double depth;                   ///< optical depth of a voxel that it fills
    Color color;
};

Sheet sheetOf(const TranslucentTriangle& triangle, double voxelSize, double thickness) {
    Sheet sheet;
    Vec3 corners[3];
    for (int i = 0; i < 3; ++i) corners[i] = triangle.corners[i] / voxelSize;
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    const double half = 0.5 * thickness, at = normal.dot(corners[0]);
    sheet.spaces = {{normal, at + half}, {normal * -1.0, half - at}};
    sheet.low = sheet.high = corners[0];
    for (int i = 0; i < 3; ++i) {
        const Vec3 outwards = (corners[(i + 1) % 3] - corners[i]).cross(normal).normalized();
        sheet.spaces.push_back({outwards, outwards.dot(corners[i])});
        for (int axis = 0; axis < 3; ++axis) {
            const double reach = half * std::abs(normal[axis]);
            sheet.low[axis] = std::min(sheet.low[axis], corners[i][axis] - reach);
            sheet.high[axis] = std::max(sheet.high[axis], corners[i][axis] + reach);
        }
    }
    sheet.depth = -std::log1p(-triangle.opacity);
    sheet.color = triangle.color;
    return sheet;
}

bool contains(const Sheet& sheet, const Vec3& p) {
    return std::all_of(sheet.spaces.begin(), sheet.spaces.end(),
                       [&](const HalfSpace& space) { return space.normal.dot(p) <= space.offset; });
}

/// Could any of it be in the cube of half edge `half` about `p`?
bool reaches(const Sheet& sheet, const Vec3& p, double half) {
    for (int axis = 0; axis < 3; ++axis)
        if (sheet.low[axis] > p[axis] + half || sheet.high[axis] < p[axis] - half) return false;
    return std::all_of(sheet.spaces.begin(), sheet.spaces.end(), [&](const HalfSpace& space) {
        const Vec3& n = space.normal;
        return n.dot(p) - half * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z)) <= space.offset;
    });
}

using DensityLeaf = openvdb::FloatTree::LeafNodeType;
using ColorLeaf = openvdb::Vec3STree::LeafNodeType;

struct Leaves {
    std::unique_ptr<DensityLeaf> density;
    std::unique_ptr<ColorLeaf> color;
};

/// Optical depth of one voxel at `p`, and the sum of colours weighted by it.
struct Filling {
    double depth = 0;
    Vec3 color{0};
};

Filling fillingAt(const std::vector<const Sheet*>& sheets, const Vec3& p, bool binary) {
    Filling filling;
    for (const Sheet* sheet : sheets) {
        const double coverage = binary ? contains(*sheet, p) : volumeInCube(p, sheet->spaces);
        filling.depth += coverage * sheet->depth;
        filling.color += Vec3(sheet->color.x, sheet->color.y, sheet->color.z) * (coverage * sheet->depth);
    }
    return filling;
}

Leaves fillLeaf(const Coord& origin, const std::vector<Sheet>& sheets, const TrianglesOptions& options) {
    const Vec3 middle = Vec3(0.5 * (options.size - 1));
    const auto position = [&](const Coord& c) { return Vec3(c.x(), c.y(), c.z()) - middle; };
    std::vector<const Sheet*> near;
    for (const Sheet& sheet : sheets)
        if (reaches(sheet, position(origin) + Vec3(3.5), 4)) near.push_back(&sheet);
    if (near.empty()) return {};
    Leaves leaves{std::make_unique<DensityLeaf>(origin, 0.0f),
                  std::make_unique<ColorLeaf>(origin, openvdb::Vec3s(0.0f))};
    std::vector<const Sheet*> here;
    for (openvdb::Index i = 0; i < DensityLeaf::SIZE; ++i) {
        const Coord at = leaves.density->offsetToGlobalCoord(i);
        const Vec3 p = position(at);
        here.clear();
        for (const Sheet* sheet : near)
            if (reaches(*sheet, p, 0.5)) here.push_back(sheet);
        if (here.empty() || !CoordBBox(Coord(0), Coord(options.size - 1)).isInside(at)) continue;
        const Filling filling = fillingAt(here, p, options.binary);
        // Corners that touch a voxel leave rounding errors, which are not worth a voxel.
        if (!(filling.depth > 1e-6)) continue;
        const Vec3 color = filling.color / filling.depth;
        leaves.density->setValueOn(i, float(filling.depth / edgeOf(options)));
        leaves.color->setValueOn(i, openvdb::Vec3s(float(color.x), float(color.y), float(color.z)));
    }
    return leaves.density->isEmpty() ? Leaves() : std::move(leaves);
}

/// Low corners of the leaves of the cube.
std::vector<Coord> leafOrigins(int size) {
    std::vector<Coord> origins;
    for (int x = 0; x < size; x += 8)
        for (int y = 0; y < size; y += 8)
            for (int z = 0; z < size; z += 8) origins.emplace_back(x, y, z);
    return origins;
}

void requireTriangles(const std::vector<TranslucentTriangle>& triangles) {
    for (const TranslucentTriangle& triangle : triangles) {
        requireField(triangle.opacity > 0 && triangle.opacity < 1, "triangle opacity", triangle.opacity, "in (0,1)");
        const Vec3* const p = triangle.corners;
        const double area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).length();
        requireField(area > 0 && std::isfinite(area), "triangle area", area, "positive and finite");
    }
}

}  // namespace

void TrianglesOptions::validate() const {
    requireField(size >= 8 && size <= 2048, "size", size, "in [8,2048]");
    requireField(voxelSize >= 0 && std::isfinite(voxelSize), "voxelSize", voxelSize, "0 (automatic) or larger");
    requireField(count >= 1 && count <= 100000, "count", count, "in [1,100000]");
    requireField(thickness >= 0.1 && thickness <= 8, "thickness", thickness, "in [0.1,8] voxels");
}

std::vector<TranslucentTriangle> randomTriangles(const TrianglesOptions& options) {
    options.validate();
    Random random(options.seed);
    std::vector<TranslucentTriangle> triangles(std::size_t(options.count));
    const double half = room(options), h = edgeOf(options);
    for (TranslucentTriangle& triangle : triangles) {
        for (bool inside = false; !inside;) {
            const Vec3 center = random.inCube(half);
            const double radius = random.between(kSmallest, kLargest) * options.size;
            inside = true;
            for (Vec3& corner : triangle.corners) {
                corner = center + random.inBall() * radius;
                for (int axis = 0; axis < 3; ++axis) inside &= std::abs(corner[axis]) <= half;
                corner *= h;
            }
        }
        triangle.opacity = random.between(kClearest, kDensest);
        for (int c = 0; c < 3; ++c) triangle.color[c] = float(random.next());
    }
    return triangles;
}

ColorVolume voxelizeTriangles(const std::vector<TranslucentTriangle>& triangles, const TrianglesOptions& options) {
    options.validate();
    requireTriangles(triangles);
    const double h = edgeOf(options);
    std::vector<Sheet> sheets;
    for (const auto& triangle : triangles) sheets.push_back(sheetOf(triangle, h, options.thickness));
    requireLeafIndex(std::pow(options.size / 8.0, 3));
    const std::vector<Coord> origins = leafOrigins(options.size);
    const Vec3 middle = Vec3(0.5 * (options.size - 1));
    requireRoomForLeaves(origins.size(), sizeof(float) + 2 * sizeof(openvdb::Vec3s), [&](std::size_t n) {
        const Vec3 center = Vec3(origins[n].x(), origins[n].y(), origins[n].z()) - middle + Vec3(3.5);
        return std::any_of(sheets.begin(), sheets.end(), [&](const Sheet& sheet) { return reaches(sheet, center, 4); });
    });
    std::vector<Leaves> made(origins.size());
    parallelFor(origins.size(), [&](std::size_t n) { made[n] = fillLeaf(origins[n], sheets, options); });

    const auto transform = openvdb::math::Transform::createLinearTransform(h);
    transform->postTranslate(openvdb::Vec3d(-0.5 * h * (options.size - 1)));
    ColorVolume volume;
    volume.density = FloatGrid::create(0.0f);
    volume.density->setTransform(transform);
    volume.density->setName("density");
    volume.density->setGridClass(openvdb::GRID_FOG_VOLUME);
    const auto color = Vec3SGrid::create(openvdb::Vec3s(0.0f));
    color->setTransform(transform);
    for (Leaves& leaves : made) {
        if (!leaves.density) continue;
        volume.density->tree().addLeaf(leaves.density.release());
        color->tree().addLeaf(leaves.color.release());
    }
    volume.color = extendedColor(*color, *volume.density);
    return volume;
}

ColorVolume makeTriangles(const TrianglesOptions& options) {
    return voxelizeTriangles(randomTriangles(options), options);
}

}  // namespace raysweep
