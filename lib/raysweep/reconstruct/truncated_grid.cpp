// Voxels of scans whose object is wider than the detector. See truncation.h.
#include "raysweep/core/parallel.h"
#include "raysweep/reconstruct/grid_lattice.h"
#include "raysweep/reconstruct/truncation.h"
#include "raysweep/reconstruct/view_matrix.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace raysweep {
namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

/// The body in whose slice a point is: that of the row onto which the axis at its height falls.
const EllipticBody& bodyFor(const Truncation& t, const ViewMatrix& view, const Vec3& point) {
    const Vec3 onAxis = t.orbit.center + t.orbit.axis * (point - t.orbit.center).dot(t.orbit.axis);
    const ViewMatrix::Affine& along = t.sideways ? view.x : view.y;
    const double row = std::round(along(onAxis) / view.depth(onAxis));
    const double last = double(t.bodies.size() - 1);
    return t.bodies[std::size_t(std::clamp(row, 0.0, last))];
}

float bodyValue(const Truncation& t, const ViewMatrix& view, const Vec3& point) {
    const EllipticBody& body = bodyFor(t, view, point);
    const Vec3 place = point - t.orbit.center;
    const bool inside = body.extinction > 0 && body.contains(place.dot(t.planeX), place.dot(t.planeY));
    return inside ? float(body.extinction) : 0;
}

double distanceFromAxis(const Truncation& t, const Vec3& point) {
    return t.orbit.inPlane(point - t.orbit.center).length();
}

/// Where a volume on `grid` says what is there, be it nothing.
bool isKnown(const Truncation& t, const ReconstructionGrid& grid, const Vec3& point) {
    return grid.box().intersects(point) && distanceFromAxis(t, point) <= t.radius;
}

}  // namespace

ReconstructionGrid widened(const Truncation& t, const ReconstructionGrid& grid) {
    ReconstructionGrid wide = grid;
    for (int axis = 0; axis < 3; ++axis) {
        const double along = std::abs(t.orbit.axis[axis]), across = std::sqrt(std::max(0.0, 1 - along * along));
        const double edge = grid.spacing[axis], half = 0.5 * grid.dims[axis] * edge;
        const double away = grid.center[axis] - t.orbit.center[axis];
        // What is along the axis stays as it is.
        const auto voxels = [&](double side) {
            const double missing = across * (t.reach + 2 * edge) - (half + side * away);
            return across < 1e-6 ? 0 : std::max(0, int(std::ceil(missing / edge)));
        };
        const int low = voxels(-1), high = voxels(1);
        wide.dims[axis] += low + high;
        wide.center[axis] += 0.5 * (high - low) * edge;
    }
    return wide;
}

openvdb::FloatGrid::Ptr continuedObject(const Truncation& t, const ProjectionGeometry& geometry,
                                        const ReconstructionGrid& grid, const KnownVolume& known) {
    const auto volume = openvdb::FloatGrid::create(0.0f);
    volume->setTransform(grid.transform());
    const ViewMatrix view = viewMatrix(geometry.views.front(), geometry.beam);
    const openvdb::Coord shift = known.volume ? requireShift(*known.volume, grid, "initial") : openvdb::Coord(0);
    std::vector<openvdb::Coord> origins;
    for (int i = 0; i < grid.dims.x; i += int(Leaf::DIM))
        for (int j = 0; j < grid.dims.y; j += int(Leaf::DIM))
            for (int k = 0; k < grid.dims.z; k += int(Leaf::DIM)) origins.emplace_back(i, j, k);
    std::vector<std::unique_ptr<Leaf>> leaves(origins.size());
    parallelFor(origins.size(), [&](std::size_t n) {
        auto leaf = std::make_unique<Leaf>(origins[n], 0.0f);
        std::optional<openvdb::FloatGrid::ConstAccessor> values;
        if (known.volume) values.emplace(known.volume->getConstAccessor());
        for (openvdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const openvdb::Coord at = leaf->offsetToGlobalCoord(offset);
            if (at.x() >= grid.dims.x || at.y() >= grid.dims.y || at.z() >= grid.dims.z) continue;
            const Vec3 point = grid.voxel(at.x(), at.y(), at.z());
            float value = 0;
            const bool active = values && values->probeValue(at + shift, value);
            if (!active) value = values && isKnown(t, known.grid, point) ? 0 : bodyValue(t, view, point);
            if (value != 0) leaf->setValueOn(offset, value);
        }
        if (!leaf->isEmpty()) leaves[n] = std::move(leaf);
    });
    for (auto& leaf : leaves)
        if (leaf) volume->tree().addLeaf(leaf.release());
    return volume;
}

openvdb::FloatGrid::Ptr fieldOf(const Truncation& t, const ReconstructionGrid& grid, const openvdb::FloatGrid& volume) {
    const auto field = openvdb::FloatGrid::create(0.0f);
    field->setTransform(grid.transform());
    field->setName(volume.getName());
    field->setGridClass(volume.getGridClass());
    auto values = field->getAccessor();
    for (auto value = volume.cbeginValueOn(); value; ++value) {
        const openvdb::Vec3d world = volume.indexToWorld(value.getCoord());
        const openvdb::Coord voxel = openvdb::Coord::round(field->worldToIndex(world));
        if (voxel.x() >= 0 && voxel.x() < grid.dims.x && voxel.y() >= 0 && voxel.y() < grid.dims.y && voxel.z() >= 0 &&
            voxel.z() < grid.dims.z && distanceFromAxis(t, Vec3(world.x(), world.y(), world.z())) <= t.radius)
            values.setValue(voxel, *value);
    }
    field->insertMeta("field_radius", openvdb::DoubleMetadata(t.radius));
    field->insertMeta("field_rows_cut", openvdb::DoubleMetadata(t.share));
    return field;
}

}  // namespace raysweep
