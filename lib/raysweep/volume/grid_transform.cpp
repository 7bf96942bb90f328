#include "raysweep/volume/grid_transform.h"

#include "raysweep/core/error.h"

namespace raysweep {

void requireLinear(const openvdb::GridBase& grid) {
    if (!grid.transform().isLinear())
        throw InvalidArgument("grid '" + grid.getName() +
                              "' has a transform that is not linear (a frustum?); resample it");
}

void requireSameTransform(const openvdb::GridBase& grid, const openvdb::GridBase& other) {
    if (grid.transform() != other.transform())
        throw InvalidArgument("grids '" + grid.getName() + "' and '" + other.getName() +
                              "' have different transforms; resample one onto the other");
}

}  // namespace raysweep
