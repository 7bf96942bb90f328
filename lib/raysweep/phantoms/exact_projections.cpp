#include "raysweep/phantoms/exact_projections.h"

#include "raysweep/core/parallel.h"

namespace raysweep {

Projections exactProjections(const std::vector<SolidShape>& shapes, const ProjectionGeometry& geometry) {
    geometry.validate();
    Projections projections(geometry.width, geometry.height, int(geometry.views.size()));
    const bool cone = geometry.beam == BeamShape::cone;
    parallelFor(std::size_t(projections.views) * geometry.height, [&](std::size_t line) {
        const int n = int(line / geometry.height), y = int(line % geometry.height);
        const XrayView& view = geometry.views[n];
        float* row = projections.view(n) + std::size_t(y) * geometry.width;
        for (int x = 0; x < geometry.width; ++x) {
            const Vec3 pixel = view.pixel(x, y);
            const double integral = cone ? lineIntegral(shapes, view.source, (pixel - view.source).normalized(), 0)
                                         : lineIntegral(shapes, pixel, view.direction);
            row[x] = float(integral);
        }
    });
    return projections;
}

}  // namespace raysweep
