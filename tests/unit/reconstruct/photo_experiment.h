/// The paper's experiment in small: translucent triangles, photographed by the renderer.
#pragma once

#include <vector>

#include "raysweep/camera/photographs.h"
#include "raysweep/phantoms/triangles.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/render/rig.h"

namespace raysweep::test {

struct PhotoExperiment {
    ColorVolume volume;
    ReconstructionGrid grid;  ///< its voxels
    Shading shading;
    std::vector<Photograph> photographs;
};

struct PhotoExperimentOptions {
    int size = 16;   ///< voxels along an edge
    int count = 30;  ///< triangles
    int views = 16;
    int pixels = 24;  ///< along an edge of a picture
    double diffuse = 0;
    RigOrbit orbit = RigOrbit::ring;
    Camera::Projection projection = Camera::Projection::Orthographic;
};

inline PhotoExperiment photoExperiment(const PhotoExperimentOptions& options) {
    PhotoExperiment made;
    TrianglesOptions triangles;
    triangles.size = options.size;
    triangles.count = options.count;
    triangles.thickness = 1.5;
    made.volume = makeTriangles(triangles);
    made.grid = {Index3(options.size), Vec3(0), Vec3(2.0 / options.size)};
    made.shading = {1 - options.diffuse, options.diffuse, Vec3(0.5, 0.7, -0.5).normalized()};
    RigOptions rig;
    rig.orbit = options.orbit;
    rig.views = options.views;
    rig.width = rig.height = options.pixels;
    rig.projection = options.projection;
    const Rig camera{rigCameras(rig, Box3(Vec3(-1), Vec3(1))), made.shading, {}};
    shoot({made.volume.density, 1, made.volume.color}, camera, [&](std::size_t n, const Image& picture) {
        made.photographs.push_back({"view " + std::to_string(n), photoCamera(camera.cameras[n]), picture});
    });
    return made;
}

}  // namespace raysweep::test
