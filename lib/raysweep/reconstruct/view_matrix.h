/// Perspective: onto which pixel a point of the world falls.
#pragma once

#include "raysweep/camera/projection_geometry.h"

namespace raysweep {

/// A 3x4 matrix: world point p falls on pixel (x,y)(p) / depth(p).
struct ViewMatrix {
    /// a.p + b
    struct Affine {
        Vec3 a{0};
        double b = 0;
        double operator()(const Vec3& p) const { return a.dot(p) + b; }
    };
    Affine x, y;   ///< pixel columns and rows
    Affine depth;  ///< cone: 0 at the source, 1 on the detector; parallel: 1
};

/// For a valid view (see ProjectionGeometry::validate).
ViewMatrix viewMatrix(const XrayView& view, BeamShape beam);

}  // namespace raysweep
