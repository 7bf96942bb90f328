#include "raysweep/projector/composite_ray.h"

namespace raysweep {

CompositeRay compositeRay(const CompositeLayout& layout, const Ray& ray, int perSlice) {
    CompositeRay line;
    const int axis = majorAxis(ray.direction);
    const int others[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    const double major = ray.direction[axis];
    // In slices; samples lie between -1 and dims, both excluded, on all axes.
    double low = -1, high = layout.dims[axis];
    major > 0 ? low = std::max(low, ray.origin[axis]) : high = std::min(high, ray.origin[axis]);
    double place[2], rate[2];
    for (int i = 0; i < 2; ++i) {
        rate[i] = ray.direction[others[i]] / major;
        place[i] = ray.origin[others[i]] - rate[i] * ray.origin[axis];
        const double least = -1, most = layout.dims[others[i]];
        if (std::abs(rate[i]) < 1e-12) {
            if (place[i] <= least || place[i] >= most) high = low;
            continue;
        }
        const double a = (least - place[i]) / rate[i], b = (most - place[i]) / rate[i];
        low = std::max(low, std::min(a, b));
        high = std::min(high, std::max(a, b));
    }
    // A little inside: what is at the very edge sees nothing, and rounding must not bring it out.
    constexpr double kInside = 1e-4;
    const double first = std::floor((low + kInside) * perSlice) + 1, last = std::ceil((high - kInside) * perSlice) - 1;
    line.axis = axis;
    line.count = last >= first ? int(last - first) + 1 : 0;
    const double start = (major > 0 ? first : last) / perSlice, step = (major > 0 ? 1.0 : -1.0) / perSlice;
    line.start = float(start);
    line.step = float(step);
    for (int i = 0; i < 2; ++i) {
        line.place[i] = float(place[i] + rate[i] * start);
        line.rate[i] = float(rate[i] * step);
    }
    line.length = float(ray.direction.length() / std::abs(major) / perSlice);
    return line;
}

bool meetsBricks(const CompositeLayout& layout, const CompositeRay& ray) {
    const CellWalk walk(layout, ray);
    for (int k = 0; k < ray.count;) {
        const int next = walk.next(k);
        if (next == k) return true;
        k = next;
    }
    return false;
}

}  // namespace raysweep
