#include "raysweep/sweep/diverging_front.h"

#include "raysweep/bricks/brick_map.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace raysweep {
namespace {

constexpr int kLeastCells = 64;  ///< cells across a pyramid, at least: close to the source a voxel fills a wide angle

/// Deposits are added up as integers, whose sum does not depend on the order: threads may come as they like. One unit
/// is this part of the power that is sent towards the volume.
constexpr double kFixedPoint = 0x1.0p60;
constexpr double kFarthest = 5e8;  ///< slices; beyond that cells cannot be counted
using FixedField = std::vector<std::atomic<std::int64_t>>;

/// One of the six pyramids; distances along its axis are in slices from the source.
struct Pyramid {
    SweepAxis axis;
    int sign;
    int cells;                  ///< across slopes [-1,1]
    RayRange columns, rows;     ///< cells that can meet the volume
    int firstSlice, lastSlice;  ///< major coordinates of the volume's slices, in the order of travel

    double slope(int cell) const { return -1 + 2.0 * cell / cells; }
};

/// What rays read and write.
struct Field {
    const PointSource& source;
    FixedField power;
    FixedField furnace;
    double unitsPerPower;  ///< of both
};

/// Slopes under which the volume's extent [low, high] is seen between the distances `near` and `far`.
RayRange cellsThatSee(double low, double high, double near, double far, int cells) {
    const double least = std::min(low / near, low / far), most = std::max(high / near, high / far);
    const auto cell = [&](double slope) { return (std::clamp(slope, -1.0, 1.0) + 1) * 0.5 * cells; };
    return {std::max(0, int(std::floor(cell(least)))), std::min(cells, int(std::ceil(cell(most))))};
}

/// @return a pyramid without cells if the volume is not in it
Pyramid pyramidOf(const BrickLayout& layout, const Vec3& position, int major, int sign) {
    Pyramid pyramid{sweepAxis(major), sign, 0, {}, {}, 0, 0};
    const auto extent = [&](int axis) {
        return std::pair<double, double>(layout.low[axis] - 0.5 - position[axis],
                                         layout.high[axis] - 0.5 - position[axis]);
    };
    const auto [low, high] = extent(major);
    const double near = std::max(sign > 0 ? low : -high, 0.0), far = sign > 0 ? high : -low;
    if (far <= 0) return pyramid;
    if (far > kFarthest) throw InvalidArgument("a point light is more than 5e8 voxels away from the volume; use a sun");
    pyramid.firstSlice = sign > 0 ? std::max(layout.low[major], int(std::floor(position[major] + 0.5)))
                                  : std::min(layout.high[major] - 1, int(std::ceil(position[major] - 0.5)));
    pyramid.lastSlice = sign > 0 ? layout.high[major] - 1 : layout.low[major];
    pyramid.cells = std::max(kLeastCells, int(std::ceil(2 * far)));
    const auto see = [&](int axis) {
        const auto [a, b] = extent(axis);
        return cellsThatSee(a, b, std::max(near, 1e-9 * far), far, pyramid.cells);
    };
    pyramid.columns = see(pyramid.axis.column);
    pyramid.rows = see(pyramid.axis.row);
    return pyramid;
}

/// Solid angle of a spherical triangle (van Oosterom and Strackee 1983).
double solidAngle(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double la = a.length(), lb = b.length(), lc = c.length();
    const double volume = std::abs(a.dot((b - a).cross(c - a)));
    return 2 * std::atan2(volume, la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

/// The up to two voxels that the stretch [begin, begin + width], width <= 1, overlaps.
struct CellOverlap {
    int voxel;
    double weight[2];

    CellOverlap(double begin, double width) : voxel(int(std::floor(begin + 0.5))) {
        const double border = voxel + 0.5;
        weight[0] = width > 0 ? std::clamp((border - begin) / width, 0.0, 1.0) : 1.0;
        weight[1] = 1 - weight[0];
    }
};

/// A ray on its way.
struct Ray {
    double power;
    double furnace;  ///< f, in the same units: the ray's whole power wherever it is outside of surfaces
    Vec3 direction;  ///< world, unit
    double lengthPerSlice;
};

/// Where a voxel is held, and the part of a ray that meets it.
struct VoxelPart {
    std::uint32_t brick;
    std::size_t offset;
    double weight;
};

/// What a slice takes of a ray.
struct Taken {
    double power = 0, furnace = 0;
    bool solid = false, leaving = false;
};

/// Exchanges a part of the ray with one voxel of optical depth tau * `length`.
void meetVoxel(Field& field, const Ray& ray, const VoxelPart& part, double length, Taken& taken) {
    const float tau = field.source.tau.brick(part.brick)[part.offset];
    const PackedNormal* const normals = field.source.surfaces ? field.source.surfaces->normals(part.brick) : nullptr;
    const bool surface = normals && isSurface(normals[part.offset]);
    const double cosine = surface ? unpackNormal(normals[part.offset]).dot(ray.direction) : 0;
    const bool solid = normals && normals[part.offset] != 0 && tau > 0;
    taken.solid = taken.solid || solid;
    taken.leaving = taken.leaving || (tau > 0 && cosine > double(kLeavingCosine));
    if (tau == 0) return;
    const double opacity = -std::expm1(-double(tau) * length);
    const auto take = [&](FixedField& to, std::size_t brick, double energy) {
        const std::int64_t units = std::llround(part.weight * energy * opacity * field.unitsPerPower);
        to[brick * std::size_t(kBrickVoxels) + part.offset].fetch_add(units, std::memory_order_relaxed);
        return double(units) / field.unitsPerPower;
    };
    taken.power += take(field.power, part.brick, ray.power);
    if (solid) taken.furnace += take(field.furnace, field.source.surfaces->slots[part.brick], ray.furnace);
}

/// Takes one ray through the volume. @return the power left
double marchRay(Field& field, const Pyramid& pyramid, int column, int row, Ray ray) {
    const SweepAxis& axis = pyramid.axis;
    const Vec3& position = field.source.position;
    const double width = 2.0 / pyramid.cells, whole = ray.power;
    const int slices = std::abs(pyramid.lastSlice - pyramid.firstSlice) + 1;
    Index3 lastCell(INT32_MIN);
    std::uint32_t brick = kNoBrick;
    int lastSolid = -kSurfaceGap;
    for (int i = 0; i < slices && ray.power > 0; ++i) {
        const int slice = pyramid.firstSlice + pyramid.sign * i;
        const double middle = pyramid.sign * (slice - position[axis.major]);
        const double enter = std::max(0.0, middle - 0.5), leave = middle + 0.5, z = 0.5 * (enter + leave);
        const double length = (leave - enter) * ray.lengthPerSlice * field.source.scale;
        const CellOverlap u(position[axis.column] + pyramid.slope(column) * z, width * z);
        const CellOverlap v(position[axis.row] + pyramid.slope(row) * z, width * z);
        Taken taken;
        for (int dv = 0; dv < 2; ++dv)
            for (int du = 0; du < 2; ++du) {
                const double weight = u.weight[du] * v.weight[dv];
                if (weight == 0) continue;
                Index3 voxel;
                voxel[axis.major] = slice;
                voxel[axis.column] = u.voxel + du;
                voxel[axis.row] = v.voxel + dv;
                const Index3 cell(voxel.x >> 3, voxel.y >> 3, voxel.z >> 3);
                if (cell != lastCell) brick = field.source.volume.map.find(voxel);
                lastCell = cell;
                if (brick == kNoBrick) continue;
                meetVoxel(field, ray, {brick, offsetInBrick(voxel), weight}, length, taken);
            }
        ray.power = std::max(0.0, ray.power - taken.power);
        ray.furnace = std::max(0.0, ray.furnace - taken.furnace);
        if (taken.solid) lastSolid = i;
        if (taken.leaving || i - lastSolid >= kSurfaceGap) ray.furnace = whole;
    }
    return ray.power;
}

/// World vector from the source to the cell corner of slopes (a, b), one slice away.
Vec3 towards(const Pyramid& pyramid, const Matrix3& worldFromIndex, double a, double b) {
    Vec3 inIndex;
    inIndex[pyramid.axis.major] = pyramid.sign;
    inIndex[pyramid.axis.column] = a;
    inIndex[pyramid.axis.row] = b;
    return inIndex * worldFromIndex;
}

/// Power of the ray of a cell, its part of the whole sphere; the ray's length in a slice, and its direction.
struct Cell {
    double power, lengthPerSlice;
    Vec3 direction;
};

Cell cellOf(const Pyramid& pyramid, const Matrix3& world, int column, int row) {
    const double a0 = pyramid.slope(column), a1 = pyramid.slope(column + 1);
    const double b0 = pyramid.slope(row), b1 = pyramid.slope(row + 1);
    const Vec3 c00 = towards(pyramid, world, a0, b0), c10 = towards(pyramid, world, a1, b0);
    const Vec3 c01 = towards(pyramid, world, a0, b1), c11 = towards(pyramid, world, a1, b1);
    const Vec3 middle = 0.25 * (c00 + c10 + c01 + c11);
    return {(solidAngle(c00, c10, c11) + solidAngle(c00, c11, c01)) / (4 * kPi), middle.length(), middle.normalized()};
}

BrickField floatsOf(const FixedField& fixed, double unitsPerPower) {
    BrickField field(fixed.size() / kBrickVoxels);
    parallelFor(field.brickCount(), [&](std::size_t b) {
        for (std::size_t i = 0; i < kBrickVoxels; ++i)
            field.brick(b)[i] = float(double(fixed[b * kBrickVoxels + i]) / unitsPerPower);
    });
    return field;
}

/// Sum of `term(column, row)` over the cells of a pyramid.
template <class Term>
double sumOverCells(const Pyramid& pyramid, const Term& term) {
    return orderedSum(
        std::size_t(pyramid.rows.size()),
        [&](std::size_t i) {
            double sum = 0;
            for (int column = pyramid.columns.begin; column < pyramid.columns.end; ++column)
                sum += term(column, pyramid.rows.begin + int(i));
            return sum;
        },
        1);
}

}  // namespace

PointDeposit depositFromPoint(const PointSource& source) {
    const BrickLayout& layout = source.volume.layout;
    const Matrix3& world = layout.worldFromIndex;
    std::vector<Pyramid> pyramids;
    for (int major = 0; major < 3; ++major)
        for (const int sign : {1, -1}) {
            const Pyramid pyramid = pyramidOf(layout, source.position, major, sign);
            if (!pyramid.rows.empty() && !pyramid.columns.empty()) pyramids.push_back(pyramid);
        }
    double sent = 0, left = 0;
    for (const Pyramid& pyramid : pyramids)
        sent += sumOverCells(pyramid, [&](int column, int row) { return cellOf(pyramid, world, column, row).power; });

    const std::size_t surfaceBricks = source.surfaces ? source.surfaces->bricks.size() : 0;
    Field field{source, FixedField(layout.brickCount() * kBrickVoxels), FixedField(surfaceBricks * kBrickVoxels),
                kFixedPoint / std::max(sent, 1e-300)};
    for (const Pyramid& pyramid : pyramids)
        left += sumOverCells(pyramid, [&](int column, int row) {
            const Cell cell = cellOf(pyramid, world, column, row);
            return marchRay(field, pyramid, column, row, {cell.power, cell.power, cell.direction, cell.lengthPerSlice});
        });
    return {floatsOf(field.power, field.unitsPerPower), floatsOf(field.furnace, field.unitsPerPower),
            (1 - sent) + left};
}

}  // namespace raysweep
