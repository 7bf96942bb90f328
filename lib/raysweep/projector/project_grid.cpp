#include "raysweep/projector/project_grid.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/projector/footprint.h"
#include "raysweep/projector/project.h"

#include <algorithm>
#include <limits>

namespace raysweep {

Projections projectGrid(const openvdb::FloatGrid& grid, const ProjectionGeometry& geometry,
                        const ProgressCallback& progress) {
    geometry.validate();
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (box.empty()) throw InvalidArgument("the volume has no active voxels: there is nothing to project");
    const ColumnLattice lattice = columnLattice(box, grid.transform(), columnAxisFor(geometry, grid.transform()));
    requireSeen(geometry, lattice);
    const ColumnVolume volume = columnsOf(grid, lattice);

    Projections projections(geometry.width, geometry.height, int(geometry.views.size()));
    ViewRays rays;
    for (int view = 0; view < projections.views; ++view) {
        if (!report(progress, "projecting", double(view) / projections.views)) {
            std::fill(projections.values.begin() + std::ptrdiff_t(view * projections.pixelsPerView()),
                      projections.values.end(), std::numeric_limits<float>::quiet_NaN());
            break;
        }
        setView(rays, geometry, view, lattice);
        projectView(volume, rays);
        float* to = projections.view(view);
        parallelFor(
            std::size_t(rays.view.height),
            [&](std::size_t v) {
                for (int u = 0; u < rays.view.width; ++u) to[rays.view.pixel(u, int(v))] = rays.values.column(u)[v];
            },
            16);
    }
    return projections;
}

}  // namespace raysweep
