#include "raysweep/camera/pose_motion.h"

#include "raysweep/core/normal_equations.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace raysweep {
namespace {

using Equations = NormalEquations<7>;

Vec3 turned(const Vec3& v, const Vec3& turn) {
    const double angle = turn.length();
    if (!(angle > 0)) return v;
    const Vec3 axis = turn / angle;  // Rodrigues
    return v * std::cos(angle) + axis.cross(v) * std::sin(angle) + axis * (axis.dot(v) * (1 - std::cos(angle)));
}

Vec3 corner(const Box3& box, int n) {
    return Vec3(n & 1 ? box.max.x : box.min.x, n & 2 ? box.max.y : box.min.y, n & 4 ? box.max.z : box.min.z);
}

/// Where the corners of a box are seen.
struct Corners {
    std::array<double, 16> at;  ///< x, y, x, ...; NaN if not seen

    Corners(const PhotoCamera& camera, const Box3& box) {
        for (std::size_t n = 0; n < 8; ++n) {
            const auto seen = project(camera, corner(box, int(n)));
            at[2 * n] = seen ? seen->x : std::numeric_limits<double>::quiet_NaN();
            at[2 * n + 1] = seen ? seen->y : std::numeric_limits<double>::quiet_NaN();
        }
    }
};

/// Mean square distance of the corners that both see.
double meanSquare(const Corners& a, const Corners& b) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < a.at.size(); ++i) {
        const double difference = a.at[i] - b.at[i];
        if (std::isnan(difference)) continue;
        sum += difference * difference;
        count += 0.5;
    }
    return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

/// Unknowns: turn and shift times a length, growth.
SpaceMotion motionOf(const Equations::Vector& x, double length) {
    return {Vec3(x[0], x[1], x[2]), Vec3(x[3], x[4], x[5]) * length, x[6]};
}

/// What a view has to say about the common motion. Its weight makes of squares of distances the distances.
Equations equationsOf(const PhotoCamera& given, const PhotoCamera& camera, const Box3& box) {
    constexpr double kStep = 1e-4, kNear = 1e-3;  // radians; pixels
    const double length = 0.5 * box.size().length();
    const Corners target(given, box), now(camera, box);
    std::array<Corners, 7> more{now, now, now, now, now, now, now}, less = more;
    for (std::size_t n = 0; n < 7; ++n) {
        Equations::Vector x{};
        x[n] = kStep;
        more[n] = Corners(moved(camera, motionOf(x, length), box.center()), box);
        x[n] = -kStep;
        less[n] = Corners(moved(camera, motionOf(x, length), box.center()), box);
    }
    const double distance = std::sqrt(meanSquare(target, now));
    Equations equations;
    for (std::size_t i = 0; i < now.at.size(); ++i) {
        Equations::Vector slopes;
        bool known = !std::isnan(target.at[i] - now.at[i]);
        for (std::size_t n = 0; n < 7; ++n) {
            slopes[n] = (more[n].at[i] - less[n].at[i]) / (2 * kStep);
            known &= !std::isnan(slopes[n]);
        }
        if (known) equations.add(slopes, target.at[i] - now.at[i], 1 / std::max(distance, kNear));
    }
    return equations;
}

}  // namespace

PhotoCamera moved(const PhotoCamera& camera, const SpaceMotion& motion, const Vec3& about) {
    PhotoCamera after = camera;
    after.position = about + turned(camera.position - about, motion.turn) * std::exp(motion.growth) + motion.shift;
    after.right = turned(camera.right, motion.turn).normalized();
    after.forward = turned(camera.forward, motion.turn);
    after.forward = (after.forward - after.right * after.right.dot(after.forward)).normalized();
    after.down = after.forward.cross(after.right);
    return after;
}

PhotoCamera withPose(const PhotoCamera& camera, const PhotoCamera& pose) {
    PhotoCamera after = camera;
    after.position = pose.position;
    after.right = pose.right;
    after.down = pose.down;
    after.forward = pose.forward;
    return after;
}

double angleBetween(const PhotoCamera& from, const PhotoCamera& to) {
    const Vec3 twice = from.right.cross(to.right) + from.down.cross(to.down) + from.forward.cross(to.forward);
    const double trace = from.right.dot(to.right) + from.down.dot(to.down) + from.forward.dot(to.forward);
    return std::atan2(twice.length(), trace - 1) * 180 / kPi;
}

double motionInPicture(const PhotoCamera& from, const PhotoCamera& to, const Box3& box) {
    return std::sqrt(meanSquare(Corners(from, box), Corners(to, box)));
}

void removeCommonMotion(const std::vector<PhotoCamera>& given, const Box3& box, std::vector<PhotoCamera>& cameras) {
    constexpr int kSteps = 40;         // reweighted least squares: a step takes a part of what is left
    constexpr double kDamping = 1e-9;  // for what no view shows, such as growth in parallel projection
    for (int step = 0; step < kSteps; ++step) {
        Equations equations;
        for (std::size_t n = 0; n < cameras.size(); ++n) equations += equationsOf(given[n], cameras[n], box);
        const SpaceMotion motion = motionOf(equations.solved(kDamping), 0.5 * box.size().length());
        for (PhotoCamera& camera : cameras) camera = moved(camera, motion, box.center());
    }
}

}  // namespace raysweep
