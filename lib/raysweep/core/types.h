/// Small types that everything is made of. Vectors are those of Imath, which OpenEXR brings along. OpenVDB's own are
/// used only where grids are.
#pragma once

#include <ImathColor.h>
#include <ImathMatrix.h>
#include <ImathVec.h>

#include <array>
#include <cmath>
#include <cstdint>

namespace raysweep {

using Vec3 = Imath::V3d;      ///< position or direction, world units unless said otherwise
using Index3 = Imath::V3i;    ///< voxel coordinates (i,j,k)
using Color = Imath::C3f;     ///< linear RGB
using Matrix3 = Imath::M33d;  ///< row vectors: world = index * M, as in OpenVDB

constexpr double kPi = 3.14159265358979323846;
constexpr int kMaxChannels = 3;  ///< wavelengths solved side by side

inline Color grey(float value) {
    return Color(value, value, value);
}
inline bool isGrey(const Color& c) {
    return c.x == c.y && c.y == c.z;
}
inline float maxComponent(const Color& c) {
    return c.x > c.y ? (c.x > c.z ? c.x : c.z) : (c.y > c.z ? c.y : c.z);
}

/// Axes (x, y, z) of index space along which a volume's bounding box repeats.
using Periodic = std::array<bool, 3>;

/// Along any axis.
inline bool isPeriodic(const Periodic& periodic) {
    return periodic[0] || periodic[1] || periodic[2];
}

/// The axis along which a direction (in index space) is longest.
inline int majorAxis(const Vec3& direction) {
    const double x = std::abs(direction.x), y = std::abs(direction.y), z = std::abs(direction.z);
    return x >= y && x >= z ? 0 : (y >= z ? 1 : 2);
}

}  // namespace raysweep
