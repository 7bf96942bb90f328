#include "raysweep/formats/sections.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raysweep {
namespace {

std::string textOf(const Vec3& v) {
    return brief(v.x, 6) + ", " + brief(v.y, 6) + ", " + brief(v.z, 6);
}

/// The sample whose voxel holds `at`.
Index3 sampleAt(const DenseLayout& layout, const Vec3& at) {
    const auto& s = layout.steps;
    const double volume = s[0].cross(s[1]).dot(s[2]);
    Index3 sample;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 across = s[std::size_t(axis + 1) % 3].cross(s[std::size_t(axis + 2) % 3]);
        const double place = std::floor((at - layout.origin).dot(across) / volume + 0.5);
        if (!(place >= 0 && place < layout.dims[axis])) {
            Vec3 last = layout.origin;
            for (int n = 0; n < 3; ++n) last += s[std::size_t(n)] * double(layout.dims[n] - 1);
            throw about("at", InvalidArgument(textOf(at) + " must be within the volume, whose first voxel is at " +
                                              textOf(layout.origin) + " and its last at " + textOf(last)));
        }
        sample[axis] = int(place);
    }
    return sample;
}

/// What slice k of the source has of the sections.
void addSlice(const float* slice, int k, Sections& sections) {
    const Index3& dims = sections.layout.dims;
    const auto row = [&](int j) { return slice + std::size_t(j) * std::size_t(dims.x); };
    if (k == sections.at.z) sections.planes[0].assign(slice, row(dims.y));
    sections.planes[1].insert(sections.planes[1].end(), row(sections.at.y), row(sections.at.y) + dims.x);
    for (int j = 0; j < dims.y; ++j) sections.planes[2].push_back(row(j)[sections.at.x]);
    const auto [least, most] = std::minmax_element(slice, row(dims.y));
    sections.smallest = std::min(sections.smallest, double(*least));
    sections.largest = std::max(sections.largest, double(*most));
}

}  // namespace

void SectionOptions::validate() const {
    if (!window) return;
    const auto bounded = [](double number) { return std::abs(number) <= std::numeric_limits<float>::max(); };
    requireField(bounded(window->low) && bounded(window->high) && window->low < window->high, "window",
                 brief(window->low, 6) + "," + brief(window->high, 6), "two numbers, the lower one first");
}

Sections sectionsOf(DenseSource& source, const SectionOptions& options) {
    options.validate();
    Sections sections;
    sections.layout = source.layout();
    sections.corner = source.corner();
    const Index3& dims = sections.layout.dims;
    sections.at = options.at ? sampleAt(sections.layout, *options.at) : Index3(dims.x / 2, dims.y / 2, dims.z / 2);
    sections.smallest = std::numeric_limits<double>::infinity();
    sections.largest = -sections.smallest;
    for (int k = 0; k < dims.z; ++k) addSlice(source.slice(k), k, sections);
    sections.window = options.window.value_or(GreyWindow{sections.smallest, sections.largest});
    return sections;
}

std::string axisName(const DenseLayout& layout, int axis) {
    constexpr double kRounding = 1e-6;
    const auto along = [&](int n) {
        const Vec3 direction = layout.steps[std::size_t(n)].normalized();
        const int world = majorAxis(direction);
        return std::abs(direction[world]) > 1 - kRounding ? world : -1;
    };
    if (along(0) < 0 || along(1) < 0 || along(2) < 0) return std::string(1, "ijk"[axis]);
    const int world = along(axis);
    return (layout.steps[std::size_t(axis)][world] < 0 ? "-" : "") + std::string(1, "xyz"[world]);
}

double scaleLength(double longest) {
    const double power = std::pow(10.0, std::floor(std::log10(longest)));
    for (const double factor : {5.0, 2.0})
        if (factor * power <= longest) return factor * power;
    return power;
}

}  // namespace raysweep
