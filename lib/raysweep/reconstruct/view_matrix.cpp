#include "raysweep/reconstruct/view_matrix.h"

namespace raysweep {

// Cone: p - source = depth (origin - source + x column + y row). Parallel: p - origin = x column + y row + t direction.
// Cramer's rule: each unknown is a triple product over that of all three vectors.
ViewMatrix viewMatrix(const XrayView& view, BeamShape beam) {
    const bool cone = beam == BeamShape::cone;
    const Vec3 through = cone ? view.origin - view.source : view.direction;
    const Vec3 from = cone ? view.source : view.origin;
    const double volume = view.column.cross(view.row).dot(through);
    const auto unknown = [&](const Vec3& normal) {
        const Vec3 a = normal / volume;
        return ViewMatrix::Affine{a, -a.dot(from)};
    };
    ViewMatrix matrix;
    matrix.x = unknown(view.row.cross(through));
    matrix.y = unknown(through.cross(view.column));
    matrix.depth = cone ? unknown(view.column.cross(view.row)) : ViewMatrix::Affine{Vec3(0), 1};
    return matrix;
}

}  // namespace raysweep
