#include "raysweep/reconstruct/reconstruction_grid.h"

#include "raysweep/core/error.h"

#include <cmath>
#include <string>

namespace raysweep {

openvdb::math::Transform::Ptr ReconstructionGrid::transform() const {
    const auto transform = openvdb::math::Transform::createLinearTransform(spacing);
    const Vec3 first = voxel(0, 0, 0);
    transform->postTranslate(openvdb::Vec3d(first.x, first.y, first.z));
    return transform;
}

void ReconstructionGrid::validate() const {
    for (int axis = 0; axis < 3; ++axis) {
        if (dims[axis] < 1)
            throw InvalidArgument("reconstruction grid dims[" + std::to_string(axis) + "] is " +
                                  std::to_string(dims[axis]) + ", but must be at least 1");
        if (!std::isfinite(center[axis]))
            throw InvalidArgument("reconstruction grid center[" + std::to_string(axis) + "] must be finite");
    }
    if (!(spacing > 0 && std::isfinite(spacing)))
        throw InvalidArgument("reconstruction grid spacing is " + std::to_string(spacing) +
                              ", but must be positive and finite");
}

}  // namespace raysweep
