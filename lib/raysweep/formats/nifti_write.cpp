// The NIfTI header of dense_headers.h. Source: nifti1.h; the quaternion: nifti1_io.c, nifti_mat44_to_quatern.
#include "raysweep/core/brief.h"
#include "raysweep/formats/dense_headers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace raysweep {
namespace {

constexpr std::size_t kHeaderSize = 348, kSamplesAt = 352;

template <class Number>
void put(std::string& bytes, std::size_t place, Number number) {
    std::memcpy(bytes.data() + place, &number, sizeof number);
}

/// From LPS to RAS.
Vec3 turned(const Vec3& lps) {
    return Vec3(-lps.x, -lps.y, lps.z);
}

/// Of a rotation whose columns are `axes`: b, c and d; a, which is not negative, follows from them.
std::array<double, 3> quaternionOf(const std::array<Vec3, 3>& axes) {
    const auto r = [&](int row, int column) { return axes[std::size_t(column)][row]; };
    std::array<double, 4> q{r(0, 0) + r(1, 1) + r(2, 2), r(0, 0) - r(1, 1) - r(2, 2), r(1, 1) - r(0, 0) - r(2, 2),
                            r(2, 2) - r(0, 0) - r(1, 1)};
    const auto largest = std::size_t(std::max_element(q.begin(), q.end()) - q.begin());
    const double root = 0.5 * std::sqrt(1 + q[largest]), part = 0.25 / root;
    const double bc = r(1, 0) + r(0, 1), bd = r(2, 0) + r(0, 2), cd = r(2, 1) + r(1, 2);
    const double ab = r(2, 1) - r(1, 2), ac = r(0, 2) - r(2, 0), ad = r(1, 0) - r(0, 1);
    const std::array<std::array<double, 4>, 4> rows{
        {{0, ab, ac, ad}, {ab, 0, bc, bd}, {ac, bc, 0, cd}, {ad, bd, cd, 0}}};
    for (std::size_t n = 0; n < 4; ++n) q[n] = n == largest ? root : rows[largest][n] * part;
    const double sign = q[0] < 0 ? -1 : 1;
    return {sign * q[1], sign * q[2], sign * q[3]};
}

void requireFits(const DenseLayout& layout) {
    for (int axis = 0; axis < 3; ++axis)
        if (layout.dims[axis] > std::numeric_limits<std::int16_t>::max())
            throw InvalidArgument("the volume has " + std::to_string(layout.dims[axis]) +
                                  " voxels along one axis, and NIfTI no more than 32767; write MetaImage or NRRD");
    double moved = 0, edge = std::numeric_limits<double>::infinity();
    const auto rounding = [](const Vec3& v) {
        return (v - Vec3(double(float(v.x)), double(float(v.y)), double(float(v.z)))).length();
    };
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3& step = layout.steps[std::size_t(axis)];
        moved += rounding(step) * double(layout.dims[axis] - 1);
        edge = std::min(edge, step.length());
    }
    moved += rounding(layout.origin);
    if (!(moved <= 0.01 * edge))
        throw InvalidArgument("NIfTI's single precision would move voxels by up to " + brief(moved) +
                              ", and they are " + brief(edge) + " apart; write MetaImage or NRRD");
}

/// The qform: a rotation, spacings, and whether the third axis is turned around.
void putQform(const DenseLayout& layout, std::string& bytes) {
    std::array<Vec3, 3> axes;
    for (std::size_t n = 0; n < 3; ++n) axes[n] = turned(layout.steps[n]).normalized();
    const bool leftHanded = axes[0].cross(axes[1]).dot(axes[2]) < 0;
    if (leftHanded) axes[2] = -axes[2];
    const std::array<double, 3> quaternion = quaternionOf(axes);
    const Vec3 origin = turned(layout.origin);
    put(bytes, 76, leftHanded ? -1.0f : 1.0f);
    put(bytes, 252, std::int16_t(1));  // scanner's coordinates
    for (std::size_t n = 0; n < 3; ++n) {
        put(bytes, 256 + 4 * n, float(quaternion[n]));
        put(bytes, 268 + 4 * n, float(origin[int(n)]));
    }
}

}  // namespace

std::string niftiHeader(const DenseLayout& layout) {
    requireFits(layout);
    constexpr std::int16_t kFloat = 16, kBits = 32;
    std::string bytes(kSamplesAt, '\0');
    put(bytes, 0, std::int32_t(kHeaderSize));
    put(bytes, 40, std::int16_t(3));
    for (std::size_t n = 0; n < 7; ++n) put(bytes, 42 + 2 * n, std::int16_t(n < 3 ? layout.dims[int(n)] : 1));
    put(bytes, 70, kFloat);
    put(bytes, 72, kBits);
    const Vec3 spacing = layout.spacing(), origin = turned(layout.origin);
    put(bytes, 76, 1.0f);
    for (std::size_t n = 0; n < 7; ++n) put(bytes, 80 + 4 * n, n < 3 ? float(spacing[int(n)]) : 1.0f);
    put(bytes, 108, float(kSamplesAt));
    put(bytes, 112, 1.0f);  // slope
    if (hasRightAngles(layout)) putQform(layout, bytes);
    put(bytes, 254, std::int16_t(1));  // sform: scanner's coordinates
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t n = 0; n < 3; ++n)
            put(bytes, 280 + 16 * row + 4 * n, float(turned(layout.steps[n])[int(row)]));
        put(bytes, 292 + 16 * row, float(origin[int(row)]));
    }
    bytes.replace(344, 4, std::string("n+1\0", 4));
    return bytes;
}

}  // namespace raysweep
