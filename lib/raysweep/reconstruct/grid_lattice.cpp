#include "raysweep/reconstruct/grid_lattice.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include <cmath>
#include <string>

namespace raysweep {
namespace {

/// @param differences makes, for each slice, the difference as a function of (x, y, z)
template <class Differences>
double rmsOver(const Index3& dims, const Differences& differences) {
    const double sum = orderedSum<double>(
        std::size_t(dims.x),
        [&](std::size_t x) {
            const auto differenceAt = differences();
            double squares = 0;
            for (int y = 0; y < dims.y; ++y)
                for (int z = 0; z < dims.z; ++z) {
                    const double difference = differenceAt(int(x), y, z);
                    squares += difference * difference;
                }
            return squares;
        },
        4);
    return std::sqrt(sum / (double(dims.x) * dims.y * dims.z));
}

double activeValue(const openvdb::FloatGrid::ConstAccessor& values, const openvdb::Coord& voxel) {
    float value = 0;
    return values.probeValue(voxel, value) ? double(value) : 0;
}

}  // namespace

ColumnLattice latticeOf(const ReconstructionGrid& grid, const ProjectionGeometry& geometry) {
    const auto transform = grid.transform();
    const openvdb::CoordBBox box(openvdb::Coord(0), openvdb::Coord(grid.dims.x - 1, grid.dims.y - 1, grid.dims.z - 1));
    return columnLattice(box, *transform, columnAxisFor(geometry, *transform));
}

std::optional<openvdb::Coord> shiftTo(const openvdb::FloatGrid& volume, const ReconstructionGrid& grid) {
    constexpr double kSame = 1e-3;  // voxels
    const auto transform = grid.transform();
    const auto place = [&](const openvdb::Coord& voxel) {
        return volume.transform().worldToIndex(transform->indexToWorld(voxel));
    };
    const openvdb::Coord shift = openvdb::Coord::round(place(openvdb::Coord(0)));
    const Index3& dims = grid.dims;
    for (const openvdb::Coord& corner :
         {openvdb::Coord(0), openvdb::Coord(dims.x, 0, 0), openvdb::Coord(0, dims.y, 0), openvdb::Coord(0, 0, dims.z)})
        if (!((place(corner) - (corner + shift).asVec3d()).length() < kSame)) return {};
    return shift;
}

openvdb::Coord requireShift(const openvdb::FloatGrid& volume, const ReconstructionGrid& grid, const char* what) {
    if (const auto shift = shiftTo(volume, grid)) return *shift;
    throw InvalidArgument(std::string("the voxels of the ") + what +
                          " volume are not where those of the reconstruction are: choose spacing and centre such that "
                          "they are, or resample it");
}

double rmsDifference(const ColumnVolume& volume, const ColumnVolume& reference) {
    return rmsOver(volume.lattice().dims, [&] {
        return [&](int x, int y, int z) { return double(volume.value(x, y, z)) - reference.value(x, y, z); };
    });
}

double rmsDifference(const openvdb::FloatGrid& volume, const openvdb::FloatGrid& reference, const Index3& dims,
                     const openvdb::Coord& shift) {
    return rmsOver(dims, [&] {
        return [is = volume.getConstAccessor(), shouldBe = reference.getConstAccessor(), &shift](int x, int y, int z) {
            const openvdb::Coord voxel(x, y, z);
            return activeValue(is, voxel) - activeValue(shouldBe, voxel + shift);
        };
    });
}

}  // namespace raysweep
