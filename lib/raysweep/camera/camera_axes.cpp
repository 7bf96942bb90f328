#include "raysweep/camera/camera_axes.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"
#include "raysweep/core/finite.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

constexpr double kTolerance = 1e-3;  ///< of lengths and cosines; files have four digits or more
constexpr double kRounding = 1e-14;  ///< of doubles

/// How far the lengths are from 1, and the angles from right ones (as cosines).
double deviation(const FileAxes& axes) {
    double worst = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j) worst = std::max(worst, std::abs(axes[i].dot(axes[j]) - (i == j ? 1 : 0)));
    return worst;
}

double determinant(const FileAxes& axes) {
    return axes[0].dot(axes[1].cross(axes[2]));
}

void requireRotation(const FileAxes& axes) {
    const auto length = [&](std::size_t n) { return brief(axes[n].length(), 4); };
    if (!isFinite(axes[0]) || !isFinite(axes[1]) || !isFinite(axes[2])) throw IoError("its rotation is not finite");
    if (deviation(axes) > kTolerance)
        throw IoError("its rotation is none: the axes have the lengths " + length(0) + ", " + length(1) + ", " +
                      length(2) +
                      ", or are not at right angles; the matrix must neither scale nor shear: divide a scale out");
    if (determinant(axes) < 0)
        throw IoError(
            "its rotation mirrors (determinant -1); turn one axis around where the file is made, or exchange two");
}

/// Newton's iteration for the orthonormal factor of the polar decomposition: the mean of a matrix and the inverse of
/// its transpose (N. Higham, Computing the polar decomposition, SIAM J. Sci. Stat. Comput. 7, 1986).
FileAxes nearestRotation(FileAxes axes) {
    for (int n = 0; n < 10 && deviation(axes) > kRounding; ++n) {
        const double determinant = raysweep::determinant(axes);
        const FileAxes inverse = {axes[1].cross(axes[2]) / determinant, axes[2].cross(axes[0]) / determinant,
                                  axes[0].cross(axes[1]) / determinant};
        for (std::size_t i = 0; i < 3; ++i) axes[i] = (axes[i] + inverse[i]) * 0.5;
    }
    return axes;
}

}  // namespace

void setAxes(PhotoCamera& camera, const FileAxes& axes, CameraAxes convention) {
    requireRotation(axes);
    const FileAxes rotation = nearestRotation(axes);
    const double sign = convention == CameraAxes::openCv ? 1 : -1;
    camera.right = rotation[0];
    camera.down = rotation[1] * sign;
    camera.forward = rotation[2] * sign;
}

void setWorldToCamera(PhotoCamera& camera, const FileAxes& axes, const Vec3& translation, CameraAxes convention) {
    setAxes(camera, axes, CameraAxes::openCv);
    camera.position = -(camera.right * translation.x + camera.down * translation.y + camera.forward * translation.z);
    setAxes(camera, axes, convention);
}

}  // namespace raysweep
