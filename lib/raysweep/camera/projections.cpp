#include "raysweep/camera/projections.h"

#include "raysweep/core/error.h"

#include <algorithm>
#include <numeric>

namespace raysweep {

std::string placeOf(const Projections& projections, std::size_t index) {
    const std::size_t width = std::size_t(projections.width), perView = projections.pixelsPerView();
    return "view " + std::to_string(index / perView) + ", row " + std::to_string(index % perView / width) +
           ", column " + std::to_string(index % width);
}

float largestValue(const Projections& projections) {
    float largest = 0;
    for (const float value : projections.values)
        if (value > largest) largest = value;  // NaN is not
    return largest;
}

float usualLargest(const Projections& projections) {
    constexpr double kBelow = 0.98;
    std::size_t step = std::max<std::size_t>(1, projections.values.size() >> 20);
    while (std::gcd(step, std::size_t(std::max(1, projections.width))) > 1) ++step;  // all columns have a say
    std::vector<float> values;
    for (std::size_t p = 0; p < projections.values.size(); p += step)
        if (projections.values[p] > 0) values.push_back(projections.values[p]);  // NaN is not
    if (values.empty()) return 0;
    const auto at = values.begin() + std::ptrdiff_t(kBelow * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

void requireMatching(const ProjectionGeometry& geometry, const Projections& projections) {
    const auto require = [](std::size_t ofGeometry, int ofImages, const char* what) {
        if (ofGeometry != std::size_t(ofImages))
            throw InvalidArgument("the geometry has " + std::to_string(ofGeometry) + " " + what +
                                  ", but the projections have " + std::to_string(ofImages) +
                                  "; give the geometry that belongs to them");
    };
    require(geometry.views.size(), projections.views, "views");
    require(std::size_t(geometry.width), projections.width, "detector columns");
    require(std::size_t(geometry.height), projections.height, "detector rows");
}

}  // namespace raysweep
