/// What the tests of poses share: cameras around an object, and pictures that they name.
#pragma once

#include "raysweep/camera/poses.h"
#include "raysweep/image/image_io.h"

#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace raysweep::test {

/// A black picture.
inline void writePicture(const std::string& path, int width, int height) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    writeImage(path, Image(width, height, 3));
}

/// `count` cameras on a spiral around `middle` that look at it, with pictures of 80x60.
inline std::vector<PhotoCamera> camerasAround(const Vec3& middle, int count, double distance,
                                              Camera::Projection projection = Camera::Projection::Perspective) {
    std::vector<PhotoCamera> cameras;
    for (int n = 0; n < count; ++n) {
        const double angle = 2.4 * n, height = -0.6 + 1.2 * (n + 0.5) / count;
        Camera camera;
        camera.projection = projection;
        camera.eye = middle + Vec3(std::cos(angle), std::sin(angle), height).normalized() * distance;
        camera.target = middle;
        camera.fov = 40;
        camera.orthoWidth = distance;
        camera.width = 80;
        camera.height = 60;
        cameras.push_back(photoCamera(camera));
    }
    return cameras;
}

inline Poses posesOf(const std::vector<PhotoCamera>& cameras) {
    Poses poses;
    for (std::size_t n = 0; n < cameras.size(); ++n) {
        Pose pose;
        pose.image = "view" + std::to_string(n) + ".exr";
        pose.camera = cameras[n];
        poses.views.push_back(pose);
    }
    return poses;
}

/// Points in a cube of this half edge, the same in every run.
inline std::vector<Vec3> somePoints(const Vec3& middle, double halfEdge, int count, unsigned seed = 1) {
    std::mt19937_64 random(seed);
    const auto next = [&] { return halfEdge * (2 * (double(random() >> 11) / 9007199254740992.0) - 1); };
    std::vector<Vec3> points;
    for (int n = 0; n < count; ++n) {
        const double x = next(), y = next(), z = next();
        points.push_back(middle + Vec3(x, y, z));
    }
    return points;
}

}  // namespace raysweep::test
