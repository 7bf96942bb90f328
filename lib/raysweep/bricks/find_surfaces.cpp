// Which voxels of a solid are its surface, which its inside, and which a medium: docs/illumination.md, "Surfaces".
#include "raysweep/bricks/gradient.h"
#include "raysweep/bricks/surface.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

constexpr int kBlurs = 3;         ///< of opacity, 1 2 1 along each axis, before differences are taken
constexpr int kPad = kBlurs + 1;  ///< what the differences of a brick's voxels reach
/// Where the normals of opacity as it is and of averaged opacity are farther apart than this (14 degrees) there is an
/// edge of the solid, which averaging would round.
constexpr double kEdgeCosine = 0.97;
constexpr int kSteps = 3;      ///< voxels behind a surface within which ...
constexpr double kOpaque = 3;  ///< ... this optical depth must lie: 5 % get through
static_assert(kSteps <= kPad, "steps stay within the padding");
/// Part of a surface voxel's neighbours behind it that must be solid, too: a normal among others without is noise.
constexpr double kLeastSupport = 0.75;
constexpr double kHard = 0.5 * kOpaque;  ///< optical depth from which on a voxel beside a surface belongs to the solid
/// Part of the surface voxels from which on those that would be surfaces and are not matter.
constexpr double kMixed = 0.02;

using PaddedField = PaddedBrick<float, kPad>;
using Marks = PaddedBrick<PackedNormal>;
using DeepMarks = PaddedBrick<PackedNormal, kSteps>;

/// Averages the lines along one axis with weights 1 2 1.
void blurAlong(PaddedField& field, int axis) {
    constexpr int kWidth = PaddedField::kWidth;
    constexpr int kStrides[3] = {kWidth * kWidth, kWidth, 1};
    const int along = kStrides[axis], across = kStrides[(axis + 1) % 3], deep = kStrides[(axis + 2) % 3];
    float* const values = &field.value[0][0][0];
    for (int i = 0; i < kWidth; ++i)
        for (int j = 0; j < kWidth; ++j) {
            float* const line = values + i * across + j * deep;
            float before = line[0];
            for (int k = 1; k + 1 < kWidth; ++k) {
                const float here = line[k * along];
                line[k * along] = 0.25f * (before + 2 * here + line[(k + 1) * along]);
                before = here;
            }
        }
}

Index3 nearestVoxel(const Vec3& v) {
    const auto whole = [](double x) { return int(std::floor(x + 0.5)); };
    return {whole(v.x), whole(v.y), whole(v.z)};
}

/// The shape of voxels: normals are directions in the world, neighbours are found in steps of voxels.
struct VoxelShape {
    Matrix3 worldFromIndex, indexFromWorld;
    double edge;           ///< of the cube of the same volume, world units
    double stepLength[3];  ///< of a voxel along each axis, edges

    explicit VoxelShape(const BrickLayout& layout)
        : worldFromIndex(layout.worldFromIndex),
          indexFromWorld(layout.worldFromIndex.inverse()),
          edge(std::cbrt(layout.voxelVolume)) {
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 step(0);
            step[axis] = 1;
            stepLength[axis] = (step * worldFromIndex).length() / edge;
        }
    }

    /// One edge along a direction, or less: at most one voxel along any axis, in voxels. @param direction world, unit
    Vec3 stepAlong(const Vec3& direction) const {
        const Vec3 step = direction * edge * indexFromWorld;
        return step / std::max({1.0, std::abs(step.x), std::abs(step.y), std::abs(step.z)});
    }
};

/// Optical depths of voxel edges around a brick.
struct Depths {
    const PaddedField& depth;
    const VoxelShape& shape;

    double at(const Index3& v) const { return double(depth.at(v.x, v.y, v.z)); }

    /// Of the voxels in kSteps steps from voxel `v` on. @param step voxel coordinates, at most 1
    double beyond(const Index3& v, const Vec3& step) const {
        double sum = 0;
        for (int k = 1; k <= kSteps; ++k) sum += at(v + nearestVoxel(double(k) * step));
        return sum * (step * shape.worldFromIndex).length() / shape.edge;
    }

    /// True if what is behind the voxel is opaque: no light comes out of it that has not been scattered there.
    /// @param inwards world, unit
    bool isBacked(const Index3& v, const Vec3& inwards) const {
        return at(v) + beyond(v, shape.stepAlong(inwards)) >= kOpaque;
    }

    /// True if the voxel and all beside it are solid, and no light comes through to its other side. @param least depth
    /// of what counts as solid
    bool isEnclosed(const Index3& v, double least) const {
        constexpr int kWidth = PaddedField::kWidth;
        constexpr int kStrides[3] = {kWidth * kWidth, kWidth, 1};
        const float* const here = &depth.at(v.x, v.y, v.z);
        if (double(*here) < least) return false;
        for (int axis = 0; axis < 3; ++axis)
            for (const int stride : {-kStrides[axis], kStrides[axis]}) {
                if (double(here[stride]) < least) return false;
                double sum = 0;
                for (int k = 1; k <= kSteps; ++k) sum += double(here[k * stride]);
                if (double(*here) + sum * shape.stepLength[axis] < kOpaque) return false;
            }
        return true;
    }
};

/// The direction into the solid that averaged opacity tells, but at edges of the solid that of plain opacity.
Vec3 sharpest(const Vec3& averaged, const Vec3& plain) {
    return averaged.dot(plain) < kEdgeCosine ? plain : averaged;
}

/// Voxels that could be a surface, and became what.
struct Count {
    int surface = 0, other = 0;
    Count& operator+=(const Count& more) {
        surface += more.surface, other += more.other;
        return *this;
    }
};

/// Marks the voxels of a brick that could be a surface with their normals, and those inside.
/// @param tau changed
Count markBrick(const VoxelShape& shape, PaddedField& tau, const SurfaceCriterion& criterion, NormalBrick& marks) {
    const auto depths = tau.values();
    if (std::all_of(depths.begin(), depths.end(), [](float t) { return t == 0; })) return {};
    for (float& depth : depths) depth *= float(criterion.perVoxel);
    const Depths around{tau, shape};
    const double least = -std::log1p(-criterion.threshold);
    const bool uniform = std::all_of(depths.begin(), depths.end(), [&](float t) { return t == *depths.begin(); });
    PaddedField plain = tau;
    for (float& value : plain.values()) value = 1 - std::exp(-value);
    PaddedField opacity = plain;
    if (!uniform) {
        for (int n = 0; n < kBlurs; ++n)
            for (int axis = 0; axis < 3; ++axis) blurAlong(opacity, axis);
    }
    Count count;
    for (int i = 0; i < kBrickVoxels; ++i) {
        const Index3 v = voxelInBrick(i);
        if (around.at(v) == 0) continue;
        // What is steep is so from voxel to voxel, however long voxels are that way.
        const Vec3 change = uniform ? Vec3(0) : gradientAt(opacity, v.x, v.y, v.z);
        const bool steep = change.length() > criterion.threshold;
        const Vec3 inwards = steep ? worldGradient(change, shape.indexFromWorld).normalized() : Vec3(0);
        if (steep && around.isBacked(v, inwards)) {
            const Vec3 unaveraged = gradientAt(plain, v.x, v.y, v.z);
            const bool more = unaveraged.length() > criterion.threshold;
            marks.normal[i] = packNormal(
                -(more ? sharpest(inwards, worldGradient(unaveraged, shape.indexFromWorld).normalized()) : inwards));
            ++count.surface;
            continue;
        }
        count.other += steep;
        if (around.isEnclosed(v, least)) marks.normal[i] = kInsideSolid;
    }
    return count;
}

/// Part of the neighbours behind surface voxel `i` that are solid.
double supportOf(const Marks& marks, const VoxelShape& shape, int i) {
    const Index3 v = voxelInBrick(i);
    const Vec3 normal = unpackNormal(marks.at(v.x, v.y, v.z));
    int solid = 0, all = 0;
    forEachSide([&](const Index3& side) {
        const Vec3 way = Vec3(side) * shape.worldFromIndex;
        if (side == Index3(0) || way.dot(normal) > -0.5 * way.length()) return;
        ++all;
        solid += marks.at(v.x + side.x, v.y + side.y, v.z + side.z) != 0;
    });
    return double(solid) / std::max(1, all);
}

/// True if surface voxel `i` faces another one across a gap too narrow for the local furnace (exchange.h).
bool facesAnother(const DeepMarks& marks, const VoxelShape& shape, int i) {
    const Index3 v = voxelInBrick(i);
    const Vec3 step = shape.stepAlong(unpackNormal(marks.at(v.x, v.y, v.z)));
    bool gap = false;
    for (int k = 1; k <= kSteps; ++k) {
        const Index3 way = v + nearestVoxel(double(k) * step);
        const PackedNormal there = marks.at(way.x, way.y, way.z);
        if (gap && there != 0) return true;
        gap = gap || there == 0;
    }
    return false;
}

/// The marks of all bricks, and steps that look at a voxel's neighbours.
struct Classification {
    const BrickLayout& layout;
    const BrickMap& map;
    const Periodic& periodic;
    const VoxelShape shape;
    std::vector<NormalBrick> marks;
    std::vector<Count> counts;

    template <class Padded>
    Padded around(std::size_t b) const {
        return Padded(layout, map, periodic, b, [&](std::size_t n) { return marks[n].normal; });
    }

    /// Takes its normal from surface voxels with little behind them.
    void dropUnsupported() {
        std::vector<VoxelMarks> dropped(marks.size());
        parallelFor(marks.size(), [&](std::size_t b) {
            if (counts[b].surface == 0) return;
            const auto near = around<Marks>(b);
            for (int i = 0; i < kBrickVoxels; ++i)
                if (isSurface(marks[b].normal[i]) && supportOf(near, shape, i) < kLeastSupport)
                    dropped[b].set(std::size_t(i));
        });
        for (std::size_t b = 0; b < marks.size(); ++b) {
            for (int i = 0; dropped[b].any() && i < kBrickVoxels; ++i)
                if (dropped[b][std::size_t(i)]) marks[b].normal[i] = 0;
            counts[b].surface -= int(dropped[b].count());
            counts[b].other += int(dropped[b].count());
        }
    }

    /// Voxels inside of solids, with those that have no normal but are hard and have a surface beside them.
    std::vector<VoxelMarks> findInside(const BrickField& tau, const SurfaceCriterion& criterion) {
        std::vector<VoxelMarks> inside(marks.size());
        const double least = -std::log1p(-criterion.threshold);
        parallelFor(marks.size(), [&](std::size_t b) {
            const auto near = around<Marks>(b);
            for (int i = 0; i < kBrickVoxels; ++i) {
                const double depth = double(tau.brick(b)[i]) * criterion.perVoxel;
                if (marks[b].normal[i] == kInsideSolid) inside[b].set(std::size_t(i));
                if (marks[b].normal[i] != 0 || depth < least) continue;
                bool beside = false;
                near.forEachAround(i, [&](int x, int y, int z) { beside = beside || isSurface(near.at(x, y, z)); });
                counts[b].other += beside;
                if (beside && depth >= kHard) inside[b].set(std::size_t(i));
            }
        });
        return inside;
    }

    void countFacing() {
        parallelFor(marks.size(), [&](std::size_t b) {
            if (counts[b].surface == 0) return;
            const auto near = around<DeepMarks>(b);
            for (int i = 0; i < kBrickVoxels; ++i)
                if (isSurface(marks[b].normal[i])) counts[b].other += facesAnother(near, shape, i);
        });
    }

    Count total() const {
        Count sum;
        for (const Count& count : counts) sum += count;
        return sum;
    }
};

}  // namespace

Surfaces findSurfaces(const BrickLayout& layout, const BrickMap& map, const BrickField& tau, const Periodic& periodic,
                      const SurfaceCriterion& criterion) {
    const std::size_t bricks = layout.brickCount();
    Classification found{
        layout, map, periodic, VoxelShape(layout), std::vector<NormalBrick>(bricks), std::vector<Count>(bricks)};
    parallelFor(bricks, [&](std::size_t b) {
        PaddedField around(layout, map, periodic, b, [&](std::size_t n) { return tau.brick(n); });
        found.counts[b] = markBrick(found.shape, around, criterion, found.marks[b]);
    });
    found.dropUnsupported();
    Surfaces surfaces;
    if (found.total().surface > 0) {
        surfaces.inside = found.findInside(tau, criterion);
        found.countFacing();
        surfaces.slots.assign(bricks, kNoSurface);
    }
    for (std::size_t b = 0; b < bricks; ++b) {
        if (found.counts[b].surface == 0) continue;
        for (int i = 0; i < kBrickVoxels; ++i)
            if (surfaces.inside[b][std::size_t(i)]) found.marks[b].normal[i] = kInsideSolid;
        surfaces.slots[b] = std::uint32_t(surfaces.bricks.size());
        surfaces.bricks.push_back(found.marks[b]);
    }
    const Count total = found.total();
    surfaces.mixed = total.other > kMixed * total.surface;
    return surfaces;
}

}  // namespace raysweep
