#include "raysweep/volume/directional_color.h"

#include "raysweep/volume/active_values.h"

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::Vec3SGrid;

/// Eq. 1 at a voxel.
struct SeenColor {
    const DirectionalColor& color;
    const PhotoCamera& camera;
    Vec3SGrid::ConstUnsafeAccessor constant, x, y, z;

    openvdb::Vec3s operator()(const Coord& at) const {
        const openvdb::Vec3d place = color.constant->indexToWorld(at);
        Vec3 d = camera.forward;
        if (camera.projection == Camera::Projection::Perspective)
            d = (Vec3(place.x(), place.y(), place.z()) - camera.position).normalized();
        const openvdb::Vec3s seen = constant.getValue(at) + x.getValue(at) * float(d.x) + y.getValue(at) * float(d.y) +
                                    z.getValue(at) * float(d.z);
        return openvdb::math::maxComponent(seen, openvdb::Vec3s(0.0f));
    }
};

}  // namespace

Vec3SGrid::Ptr colorSeenFrom(const DirectionalColor& color, const PhotoCamera& camera) {
    const Vec3SGrid::Ptr seen = color.constant->deepCopy();
    seen->setName("Cd");
    setActive(*seen, [&] {
        return SeenColor{color,
                         camera,
                         color.constant->getConstUnsafeAccessor(),
                         color.x->getConstUnsafeAccessor(),
                         color.y->getConstUnsafeAccessor(),
                         color.z->getConstUnsafeAccessor()};
    });
    return seen;
}

}  // namespace raysweep
