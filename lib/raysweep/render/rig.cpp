#include "raysweep/render/rig.h"

#include "raysweep/core/directions.h"
#include "raysweep/core/error.h"
#include "raysweep/core/finite.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

const double kGoldenAngle = kPi * (3 - std::sqrt(5.0));

/// Directions for someone who stands upright before the volume; lengths are 1.
struct Standing {
    Vec3 up, right, front;

    explicit Standing(const Vec3& axis) : up(unitVector(axis)) {
        const Vec3 beside = axisAside(up);
        right = (beside - up * beside.dot(up)).normalized();
        front = right.cross(up);
    }

    /// At `angle` from the front towards the right, `height` in [-1,1] times 1 above the middle.
    Vec3 at(double angle, double height) const {
        const double level = std::sqrt(std::max(0.0, 1 - height * height));
        return (front * std::cos(angle) + right * std::sin(angle)) * level + up * height;
    }
};

/// From the middle towards each camera, length 1.
std::vector<Vec3> directionsOf(const RigOptions& options) {
    const Standing standing(options.up);
    std::vector<Vec3> directions;
    const double n = options.views;
    for (int i = 0; i < options.views; ++i)
        directions.push_back(options.orbit == RigOrbit::ring
                                 ? standing.at(i * options.arc / n * kPi / 180, 0)
                                 : standing.at(std::fmod(i * kGoldenAngle, 2 * kPi), 1 - (2 * i + 1) / n));
    return directions;
}

struct Room {
    double distance = 0;    ///< perspective: of the eye from the middle
    double orthoWidth = 0;  ///< orthographic
};

/// What `camera`, which looks at the middle of `bounds`, needs to see all of it.
Room roomFor(const Camera& camera, const Box3& bounds) {
    const CameraFrame frame = cameraFrame(camera);
    const Vec3 right = frame.right.normalized(), up = frame.up.normalized();
    const double aspect = double(camera.width) / camera.height, top = std::tan(camera.fov * kPi / 360);
    Room room;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p = Vec3(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                            corner & 4 ? bounds.max.z : bounds.min.z) -
                       camera.target;
        const double height = kRigMargin * std::max(std::abs(p.dot(up)), std::abs(p.dot(right)) / aspect);
        room.distance = std::max(room.distance, height / top - p.dot(frame.forward));
        room.orthoWidth = std::max(room.orthoWidth, 2 * height * aspect);
    }
    return room;
}

Camera lensOf(const RigOptions& options, const Vec3& middle) {
    Camera lens;
    lens.projection = options.projection;
    lens.target = middle;
    lens.up = options.up;
    lens.fov = options.fov;
    lens.orthoWidth = options.orthoWidth > 0 ? options.orthoWidth : 1;
    lens.width = options.width;
    lens.height = options.height;
    return lens;
}

}  // namespace

void RigOptions::validate() const {
    requireField(views >= 1 && views <= 100000, "views", views, "in [1,100000]");
    requireField(std::isfinite(arc) && arc != 0, "arc", arc, "finite and not 0 degrees");
    requireField(std::isfinite(orthoWidth) && orthoWidth >= 0, "orthoWidth", orthoWidth, "0 (automatic) or larger");
    requireField(fov > 0 && fov < 180, "fov", fov, "between 0 and 180 degrees");
    requireField(isDirection(up), "up", up, "finite and not zero");
    requireField(width > 0, "width", width, "at least 1 pixel");
    requireField(height > 0, "height", height, "at least 1 pixel");
}

std::vector<Camera> rigCameras(const RigOptions& options, const Box3& bounds) {
    options.validate();
    if (bounds.isEmpty() || !isFinite(bounds.min) || !isFinite(bounds.max))
        throw InvalidArgument("bounds to photograph are empty or not finite");
    const Vec3 middle = bounds.center();
    const std::vector<Vec3> directions = directionsOf(options);
    std::vector<Camera> cameras(directions.size(), lensOf(options, middle));
    Room room;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        cameras[i].eye = middle + directions[i];
        const Room needed = roomFor(cameras[i], bounds);
        room.distance = std::max(room.distance, needed.distance);
        room.orthoWidth = std::max(room.orthoWidth, needed.orthoWidth);
    }
    const double size = bounds.size().length();
    const bool parallel = options.projection == Camera::Projection::Orthographic;
    const double distance = parallel ? size : room.distance;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        // A box that is a single point still needs some distance to be looked at from.
        cameras[i].eye = middle + directions[i] * (distance > 0 ? distance : 1.0);
        if (options.orthoWidth == 0 && room.orthoWidth > 0) cameras[i].orthoWidth = room.orthoWidth;
    }
    return cameras;
}

std::size_t shoot(const RenderInput& volume, const Rig& rig, const TakePicture& take,
                  const ProgressCallback& progress) {
    rig.shading.validate();
    RenderOptions picture = rig.picture;
    picture.background = grey(0);
    RenderInput lit = volume;
    openvdb::Vec3SGrid::Ptr normals;
    RenderVolume ready(volume);  // also without views: it checks the volume
    if (rig.shading.diffuse > 0 || rig.shading.ambient < 1)
        normals = surfaceNormals(*volume.density, volume.extinctionScale, *volume.radiosity);
    std::size_t done = 0;
    const auto viewProgress = [&](const std::string&, double fraction) {
        return report(progress, "view " + std::to_string(done + 1) + " of " + std::to_string(rig.cameras.size()),
                      (double(done) + fraction) / double(rig.cameras.size()));
    };
    for (; done < rig.cameras.size(); ++done) {
        if (normals && (done == 0 || rig.shading.diffuse > 0)) {
            Shading shading = rig.shading;
            shading.light =
                carriedAlong(rig.shading.light, photoCamera(rig.cameras.front()), photoCamera(rig.cameras[done]));
            lit.radiosity = shaded(*volume.radiosity, *normals, shading);
            ready = RenderVolume(lit);
        }
        const RenderResult result = render(ready, rig.cameras[done], picture, viewProgress);
        if (!result.complete) break;
        take(done, result.image);
    }
    return done;
}

std::vector<Photograph> photographsOf(const RenderInput& volume, const Rig& rig, const ProgressCallback& progress) {
    std::vector<Photograph> photographs;
    const auto keep = [&](std::size_t view, const Image& picture) {
        photographs.push_back({"view " + std::to_string(view + 1), photoCamera(rig.cameras[view]), picture});
    };
    shoot(volume, rig, keep, progress);
    return photographs;
}

Image overBackdrop(const Image& matted, const Color& backdrop) {
    if (matted.channels != 4)
        throw InvalidArgument("a matted picture has 4 channels, not " + std::to_string(matted.channels));
    Image result(matted.width, matted.height, 3);
    for (std::size_t i = 0; i < result.pixels.size() / 3; ++i) {
        const float* const pixel = matted.pixels.data() + 4 * i;
        for (int c = 0; c < 3; ++c) result.pixels[3 * i + c] = pixel[c] + (1 - pixel[3]) * backdrop[c];
    }
    return result;
}

}  // namespace raysweep
