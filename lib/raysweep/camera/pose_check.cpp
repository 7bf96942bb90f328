#include "raysweep/camera/pose_check.h"

#include "raysweep/camera/object_bounds.h"

namespace raysweep {
namespace {

constexpr double kNearlyAll = 0.9;
constexpr int kLattice = 5;  ///< points along each edge of the box that are looked for in pictures

/// Whether some point of a lattice over the box is in the picture.
bool sees(const PhotoCamera& camera, const Box3& box) {
    for (int n = 0; n < kLattice * kLattice * kLattice; ++n) {
        const Vec3 at(n % kLattice, n / kLattice % kLattice, n / kLattice / kLattice);
        const auto seen = project(camera, box.min + (box.max - box.min) * at / (kLattice - 1));
        if (seen && seen->x >= 0 && seen->x <= camera.width && seen->y >= 0 && seen->y <= camera.height) return true;
    }
    return false;
}

std::vector<std::size_t> notSeeing(const std::vector<Pose>& views, const Box3& box) {
    std::vector<std::size_t> away;
    for (std::size_t n = 0; n < views.size(); ++n)
        if (!sees(views[n].camera, box)) away.push_back(n);
    return away;
}

std::optional<Box3> boxToSee(const Poses& poses, const std::optional<Box3>& bounds) {
    if (bounds) return bounds;
    if (poses.bounds) return poses.bounds;
    if (const auto ofPoints = boundsOfPoints(poses)) return ofPoints;
    if (const auto middle = middleOfViews(poses.views)) return Box3(*middle, *middle);
    return std::nullopt;
}

}  // namespace

AxesFinding checkAxes(const Poses& poses, const std::optional<Box3>& bounds) {
    AxesFinding finding;
    const std::optional<Box3> box = boxToSee(poses, bounds);
    if (!box) return finding;
    finding.lookingAway = notSeeing(poses.views, *box);
    const double count = double(poses.views.size());
    if (double(finding.lookingAway.size()) < kNearlyAll * count) return finding;
    const CameraAxes other = poses.axes == CameraAxes::openGl ? CameraAxes::openCv : CameraAxes::openGl;
    const auto stillAway = notSeeing(withConvention(poses, other).views, *box);
    if (double(stillAway.size()) <= (1 - kNearlyAll) * count) finding.better = other;
    return finding;
}

}  // namespace raysweep
