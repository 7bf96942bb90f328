/// The way of rays through the cells of a layout.
#pragma once

#include "raysweep/projector/composite.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace raysweep {

/// Distances in a table with z contiguous: along a ray's major axis, the first and the second other axis.
inline void stridesAlong(int axis, const Index3& dims, int (&to)[3]) {
    const int along[3] = {dims.y * dims.z, dims.z, 1};
    to[0] = along[axis];
    to[1] = along[axis == 0 ? 1 : 0];
    to[2] = along[axis == 2 ? 1 : 2];
}

/// A ray on its way through the cells of a layout.
class CellWalk {
  public:
    CellWalk(const CompositeLayout& layout, const CompositeRay& ray) : cells_(layout.cells.data()), ray_(ray) {
        stridesAlong(ray.axis, layout.cellDims, stride_);
        const float rate[3] = {ray.step, ray.rate[0], ray.rate[1]};
        for (int axis = 0; axis < 3; ++axis) inverse_[axis] = std::abs(rate[axis]) < 1e-9f ? 1e9f : 1 / rate[axis];
    }

    /// A sample behind `k`, before which nothing is seen; `k` itself if that may see something.
    int next(int k) const {
        const float place[3] = {ray_.start + float(k) * ray_.step, ray_.place[0] + float(k) * ray_.rate[0],
                                ray_.place[1] + float(k) * ray_.rate[1]};
        int whole[3];
        std::ptrdiff_t cell = 0;
        for (int axis = 0; axis < 3; ++axis) {
            whole[axis] = (int(place[axis] + 8.0f) - 8) >> 2;
            cell += (whole[axis] + 2) * std::ptrdiff_t(stride_[axis]);
        }
        const int distance = cells_[cell];
        if (distance == 0) return k;
        float least = 1e9f;
        for (int axis = 0; axis < 3; ++axis) {
            const float end = 4.0f * float(inverse_[axis] > 0 ? whole[axis] + distance : whole[axis] - distance + 1);
            least = std::min(least, (end - place[axis]) * inverse_[axis]);
        }
        return k + std::max(1, int(std::ceil(least)));
    }

  private:
    const std::uint8_t* cells_;
    const CompositeRay& ray_;
    int stride_[3];
    float inverse_[3];
};

}  // namespace raysweep
