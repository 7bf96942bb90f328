/// What an X-ray detector measured, view by view.
#pragma once

#include "raysweep/camera/projection_geometry.h"

#include <cstddef>
#include <limits>
#include <vector>

namespace raysweep {

/// Line integrals of extinction (without unit), one for each ray of a ProjectionGeometry. NaN: not measured; such rays
/// are left out.
struct Projections {
    int width = 0, height = 0, views = 0;
    std::vector<float> values;  ///< columns run fastest, then rows, then views
    /// Values at or above it say only that the line integral is at least that much: the detector saw nothing more.
    float saturation = std::numeric_limits<float>::infinity();

    Projections() = default;
    /// All values 0.
    Projections(int width, int height, int views)
        : width(width), height(height), views(views), values(std::size_t(width) * height * views) {}

    std::size_t pixelsPerView() const { return std::size_t(width) * height; }
    float* view(int n) { return values.data() + n * pixelsPerView(); }
    const float* view(int n) const { return values.data() + n * pixelsPerView(); }
};

/// Which ray a value is of; all counted from 0.
struct RayPlace {
    std::size_t view, row, column;
};
RayPlace placeOf(const Projections& projections, std::size_t index);

/// The largest value that was measured; 0 if none is above it.
float largestValue(const Projections& projections);

/// @throw InvalidArgument if views, columns or rows differ in number; it says both numbers.
void requireMatching(const ProjectionGeometry& geometry, const Projections& projections);

}  // namespace raysweep
