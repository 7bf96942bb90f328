/// A virtual rig: cameras around a volume, and the pictures that they take.
#pragma once

#include "raysweep/camera/camera.h"
#include "raysweep/camera/photographs.h"
#include "raysweep/render/render.h"
#include "raysweep/render/shading.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace raysweep {

/// Room that cameras leave around a volume, as a factor on its size in the picture.
constexpr double kRigMargin = 1.02;

enum class RigOrbit {
    ring,   ///< evenly on a circle about the axis up: the paper's, all views in one plane
    sphere  ///< evenly on a sphere
};

/// Where cameras stand: all look at the middle of what is photographed, from one distance.
struct RigOptions {
    RigOrbit orbit = RigOrbit::ring;
    int views = 80;    ///< in [1,100000]
    double arc = 360;  ///< ring: degrees from the first view to where one after the last would be, not 0
    Camera::Projection projection = Camera::Projection::Perspective;
    double fov = 40;                ///< perspective: angle between top and bottom edge, degrees, in (0,180)
    double orthoWidth = 0;          ///< orthographic: width of a picture, world units; 0: such that all is seen
    Vec3 up{0, 0, 1};               ///< axis of the ring, and what points up in pictures; any length but 0
    int width = 256, height = 256;  ///< of a picture, pixels

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Cameras that see the whole of `bounds` in every view, as large as the view that needs most room allows. The first of
/// a ring stands in front (with up +z that is at -y; camera.h, framed); they follow counter-clockwise, seen from the
/// tip of up. On a sphere they follow a spiral from above to below in steps of the golden angle: the i-th of N at
/// height 1 - (2 i + 1)/N, so none is at a pole (R. Swinbank and R. J. Purser, Q. J. R. Meteorol. Soc. 132, 2006).
/// @throw InvalidArgument as RigOptions::validate, and if bounds are empty or not finite.
std::vector<Camera> rigCameras(const RigOptions& options, const Box3& bounds);

/// What takes pictures.
struct Rig {
    std::vector<Camera> cameras;
    Shading shading;        ///< `light` as for the first camera; it goes along with the others
    RenderOptions picture;  ///< sampling; its `background` is not looked at: pictures are matted
};

/// Called with each picture that is whole, in order of views: RGBA in linear light, RGB multiplied by alpha.
using TakePicture = std::function<void(std::size_t view, const Image& picture)>;

/// Photographs a volume as `render` shows it. Without diffuse light it is made ready once, else once for each view: the
/// source radiance that rays meet is the volume's, times shading, voxel by voxel, so that shading is interpolated as
/// colours are.
/// @return number of pictures; less than cameras if `progress` asked to stop
/// @throw InvalidArgument as render and Shading::validate, and, with diffuse light, if density and radiosity do not
/// share a transform
std::size_t shoot(const RenderInput& volume, const Rig& rig, const TakePicture& take,
                  const ProgressCallback& progress = {});

/// The same, kept in memory, with cameras and names "view 1" and so on.
std::vector<Photograph> photographsOf(const RenderInput& volume, const Rig& rig, const ProgressCallback& progress = {});

/// RGB of a matted picture before a backdrop of radiance `backdrop`, not negative.
Image overBackdrop(const Image& matted, const Color& backdrop);

}  // namespace raysweep
