/// Channels of a voxel's value, alike for scalars and colours.
#pragma once

#include <openvdb/Types.h>

#include <type_traits>

namespace raysweep {

template <class Value>
constexpr int kChannels = std::is_same<Value, float>::value ? 1 : 3;

inline float channel(const float& value, int) {
    return value;
}
inline float channel(const openvdb::Vec3s& value, int c) {
    return value[c];
}
inline float& channel(float& value, int) {
    return value;
}
inline float& channel(openvdb::Vec3s& value, int c) {
    return value[c];
}

}  // namespace raysweep
