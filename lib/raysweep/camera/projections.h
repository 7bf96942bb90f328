/// What an X-ray detector measured, view by view.
#pragma once

#include "raysweep/camera/projection_geometry.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace raysweep {

/// What a value says about its ray's line integral.
enum class RayBound : std::uint8_t {
    none,     ///< that it is as much
    atLeast,  ///< that it is at least as much: the detector counted next to nothing
    atMost    ///< that it is at most as much: the detector counted as much as it can
};

/// Line integrals of extinction (without unit), one for each ray of a ProjectionGeometry. NaN: not measured; such rays
/// are left out.
struct Projections {
    int width = 0, height = 0, views = 0;
    std::vector<float> values;  ///< columns run fastest, then rows, then views
    /// Values at or above it say only that the line integral is at least that much: the detector saw nothing more.
    float saturation = std::numeric_limits<float>::infinity();
    std::vector<RayBound> bounds;  ///< of values below `saturation`, one for each value; empty: none is a bound

    Projections() = default;
    /// All values 0.
    Projections(int width, int height, int views)
        : width(width), height(height), views(views), values(std::size_t(width) * height * views) {}

    RayBound boundOf(std::size_t index) const {
        if (values[index] >= saturation) return RayBound::atLeast;
        return bounds.empty() ? RayBound::none : bounds[index];
    }

    std::size_t pixelsPerView() const { return std::size_t(width) * height; }
    float* view(int n) { return values.data() + n * pixelsPerView(); }
    const float* view(int n) const { return values.data() + n * pixelsPerView(); }
};

/// Values of some kind among the projections.
struct ValuesFound {
    std::size_t count = 0;
    std::size_t first = 0;  ///< index of the first of them
};

/// @param isMeant function of a value
template <class IsMeant>
ValuesFound findValues(const Projections& projections, const IsMeant& isMeant) {
    ValuesFound found;
    for (std::size_t n = 0; n < projections.values.size(); ++n)
        if (isMeant(projections.values[n]) && found.count++ == 0) found.first = n;
    return found;
}

/// Which ray a value is of, for messages: "view 2, row 1, column 3", all counted from 0.
std::string placeOf(const Projections& projections, std::size_t index);

/// The largest value that was measured; 0 if none is above it.
float largestValue(const Projections& projections);

/// The value that 98 % of those above 0 are below, of about a million of them: the object's largest line integral, but
/// for pixels that are hit or broken. 0 if there is none.
float usualLargest(const Projections& projections);

/// @throw InvalidArgument if views, columns or rows differ in number; it says both numbers.
void requireMatching(const ProjectionGeometry& geometry, const Projections& projections);

}  // namespace raysweep
