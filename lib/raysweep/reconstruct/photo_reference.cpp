#include "raysweep/reconstruct/photo_reference.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/grid_lattice.h"

#include <cmath>
#include <string>

namespace raysweep {

CompositeVoxel matterOf(const CompositeVoxel& voxel) {
    const float opacity = -std::expm1(-voxel.extinction);
    return {opacity, opacity * voxel.red, opacity * voxel.green, opacity * voxel.blue};
}

void forVoxelsIn(const ReconstructionGrid& grid, const ColorVolume& volume, const char* what,
                 const std::function<void(const Index3& at, const CompositeVoxel& voxel)>& body) {
    const auto shift = shiftTo(*volume.density, grid);
    if (!shift)
        throw InvalidArgument(std::string("the voxels of the ") + what +
                              " volume are not where those of the reconstruction are: choose the grid such that they "
                              "are, or resample it");
    const openvdb::CoordBBox all(*shift, shift->offsetBy(grid.dims.x - 1, grid.dims.y - 1, grid.dims.z - 1));
    const auto color = volume.color->getConstAccessor();
    for (auto value = volume.density->cbeginValueOn(); value; ++value) {
        openvdb::CoordBBox box = value.getBoundingBox();
        box.intersect(all);
        for (const openvdb::Coord& at : box) {
            const openvdb::Vec3s c = color.getValue(at);
            const openvdb::Coord to = at - *shift;
            body(Index3(to.x(), to.y(), to.z()), CompositeVoxel{float(*value * grid.edge()), c[0], c[1], c[2]});
        }
    }
}

PhotoReference::Squares& PhotoReference::Squares::operator+=(const Squares& other) {
    opacity += other.opacity;
    color += other.color;
    return *this;
}

PhotoReference::Squares PhotoReference::squares(const CompositeVoxel& a, const CompositeVoxel& b) {
    const double o = double(a.extinction) - b.extinction;
    const double red = double(a.red) - b.red, green = double(a.green) - b.green, blue = double(a.blue) - b.blue;
    return {o * o, (red * red + green * green + blue * blue) / 3};
}

PhotoReference::PhotoReference(const ColorVolume& volume, const ReconstructionGrid& grid, const CompositeLayout& layout)
    : layout_(layout), matter_(layout.voxelCount()), total_(double(grid.dims.x) * grid.dims.y * grid.dims.z) {
    forVoxelsIn(grid, volume, "reference", [&](const Index3& at, const CompositeVoxel& voxel) {
        const std::size_t i = layout.voxel(at);
        if (i >= 512)
            matter_[i] = matterOf(voxel);
        else
            outside_ += squares(matterOf(voxel), {});
    });
}

void PhotoReference::compare(const std::function<CompositeVoxel(std::size_t voxel)>& matter, PhotoPoint& point) const {
    Squares sum = orderedSum<Squares>(layout_.brickCount() - 1, [&](std::size_t n) {
        Squares brick;
        for (std::size_t i = (n + 1) * 512; i < (n + 2) * 512; ++i) brick += squares(matter(i), matter_[i]);
        return brick;
    });
    sum += outside_;
    point.opacity = std::sqrt(sum.opacity / total_);
    point.color = std::sqrt(sum.color / total_);
}

}  // namespace raysweep
