#include "raysweep/reconstruct/photo_surfaces.h"

#include "raysweep/core/parallel.h"
#include "raysweep/reconstruct/photo_grids.h"

namespace raysweep {

PhotoSurfaces surfacesOf(const PhotoReconstruction& volume, const ReconstructionGrid& grid) {
    PhotoSurfaces to;
    to.grid = grid;
    to.layout = compositeLayout(grid.dims, bricksOf(*volume.density, openvdb::Coord(0)));
    to.voxels.resize(to.layout.voxelCount());
    to.normals.resize(to.layout.voxelCount());
    for (std::size_t b = 1; b < to.layout.brickCount(); ++b) {
        const Index3 at = to.layout.origins[b];
        const auto* density = volume.density->tree().probeConstLeaf(openvdb::Coord(at.x, at.y, at.z));
        const auto* color = volume.color->tree().probeConstLeaf(openvdb::Coord(at.x, at.y, at.z));
        for (openvdb::Index i = 0; i < 512; ++i) {
            if (!density->isValueOn(i)) continue;
            const openvdb::Vec3s c = color->getValue(i);
            to.voxels[b * 512 + i] = {float(density->getValue(i) * grid.edge()), c[0], c[1], c[2]};
        }
    }
    parallelFor(to.layout.brickCount() - 1,
                [&](std::size_t n) { brickNormals(to.layout, to.voxels.data(), n + 1, &to.normals[(n + 1) * 512]); });
    return to;
}

}  // namespace raysweep
