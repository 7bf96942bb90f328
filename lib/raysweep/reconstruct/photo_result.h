/// What comes out of a reconstruction from photographs, whatever the method.
#pragma once

#include "raysweep/camera/photo_camera.h"
#include "raysweep/render/shading.h"
#include "raysweep/volume/directional_color.h"
#include "raysweep/volume/grids.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace raysweep {

enum class PhotoTermination {
    iterations,  ///< all passes were made
    overfitted,  ///< fit: a finer grid made pixels that are left out worse: the volume is the coarser one
    noRoom,      ///< fit: there is no memory for a finer grid: the volume is the coarser one
    interrupted  ///< the progress callback said stop; the volume is the best of what there was
};

/// How far it was.
struct PhotoPoint {
    int updates = 0;     ///< so far
    double seconds = 0;  ///< spent on them
    int resolution = 0;  ///< voxels along the longest edge of the grid
    /// RMS difference to the pictures since the last point, each just before its update: of RGBA, linear light, all
    /// pixels; of the fit of RGB as displays encode it, before all backdrops (photo_fit.h, eq. 1), of pixels that meet
    /// something.
    double imageError = 0;
    double leftOut = std::numeric_limits<double>::quiet_NaN();  ///< the same of pixels that are not fitted; NaN without
    double opacity = std::numeric_limits<double>::quiet_NaN();  ///< RMS over all voxels of the grid of the difference
                                                                ///< to the reference; NaN without one
    double color = std::numeric_limits<double>::quiet_NaN();    ///< the same of opacity times colour, mean of channels
};

/// The light that photographs were found to be taken in.
struct PhotoLight {
    Shading shading;        ///< as for the first photograph; ambient and diffuse together are 1
    double residual = 0;    ///< RMS of what it leaves of the brightness of the pictures, relative to that
    double aside = 0;       ///< the least that a light leaves whose direction is 30 degrees away
    double ambient = 0;     ///< what ambient light alone leaves
    double confidence = 0;  ///< of the squares that a light leaves which is one radian aside, the part that this one
                            ///< does not leave; less if the opposite light leaves hardly more; in [0,1]
};

/// A photograph's camera, and how far it is from where it was said to be.
struct RefinedPose {
    PhotoCamera camera;
    double turn = 0;    ///< of its axes, degrees
    double motion = 0;  ///< of what it shows, pixels (motionInPicture of the grid's box)
};

struct PhotoTimings {
    double prepared = 0;  ///< s: pictures, hull
    double light = 0;     ///< s: looking for the light
    double updates = 0;   ///< s
    double total = 0;
};

struct PhotoReconstruction {
    openvdb::FloatGrid::Ptr density;  ///< "density", extinction, 1/world unit
    openvdb::FloatGrid::Ptr opacity;  ///< "opacity", of one voxel's edge, in [0,1]
    openvdb::Vec3SGrid::Ptr color;    ///< "Cd", linear light; one voxel further than density
    DirectionalColor directional;     ///< where it was asked for; `color` is its mean over the photographs
    std::vector<PhotoPoint> history;
    PhotoTermination termination = PhotoTermination::iterations;
    std::optional<PhotoLight> light;  ///< where it was asked for
    std::vector<RefinedPose> poses;   ///< of the photographs, if they were to be refined
    PhotoTimings timings;
    double smoothness = 0;  ///< fit: weight of total variation that it ended with
    int resolution = 0;     ///< voxels along the longest edge of the grid
    int updates = 0;
    std::size_t keptVoxels = 0;  ///< in the bricks that had memory
    double samples = 0;          ///< of rays, in all updates
};

}  // namespace raysweep
