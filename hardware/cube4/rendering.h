/// Pictures of a lit volume by the machine: a host that loads it, lets parallel rays step through it, and warps the
/// base plane to a picture (Lacroute's shear and warp, as Cube-4 uses it).
#pragma once

#include "cube4/dense_volume.h"
#include "cube4/fixed_point.h"
#include "cube4/perspective.h"
#include "cube4/renderer.h"

#include "raysweep/image/image.h"

#include <optional>
#include <vector>

namespace raysweep::cube4 {

/// What is seen.
struct LitVolume {
    DenseBox box;
    Vec3 origin{0};                     ///< world position of the centre of voxel `box.low`
    DenseField extinction;              ///< 1/world unit
    std::vector<DenseField> radiosity;  ///< source radiance of one or three wavelengths
};

/// A parallel view. World units.
struct ParallelView {
    Vec3 direction{0, 0, -1};           ///< of sight
    Vec3 origin{0}, column{0}, row{0};  ///< centre of pixel (0,0), top left, and from it to the next
    int width = 0, height = 0;
};

struct RenderSetup {
    int pipelines = 16;
    bool lambert = false;                ///< shading, see shade.h
    double depth = 0;                    ///< where samples lie between one slice and the next along the sight, [0,1)
    double background = 0;               ///< radiance behind the volume
    RaySampling sampling;                ///< of rays from an eye
    std::optional<NumberFormat> format;  ///< none: floats
    Trace* trace = nullptr;

    /// @throw InvalidArgument naming field, value and bound
    void validate() const;
};

struct Rendering {
    Image image;      ///< RGBA, linear, the background composited, as raysweep's render() has it
    double step = 0;  ///< distance of samples along a ray, world units
    Counters counters;
    std::size_t passes = 0, voxels = 0;  ///< voxels of a pass
    std::size_t bytesPerModule = 0, bufferBytes = 0;
};

/// One pass for each wavelength. @throw InvalidArgument for a view whose pixels have no area
Rendering renderView(const LitVolume& volume, const ParallelView& view, const RenderSetup& setup);

/// In perspective: the pixels' rays come from the eye `view.source`. Samples are in slices, and rays go through the
/// volume in regions (perspective.h), a front for each major axis that they have. Nothing nearer than a voxel is seen.
/// @throw InvalidArgument for pixels without area, shading, or samples between slices
Rendering renderView(const LitVolume& volume, const PointRays& view, const RenderSetup& setup);

/// A view in perspective. @param fov between top and bottom edge, degrees, in (0,180)
/// @throw InvalidArgument for a direction without length, or an `up` along it
PointRays viewFrom(const Vec3& eye, const Vec3& direction, const Vec3& up, double fov, const Imath::V2i& pixels);

/// A parallel view of all of a volume, from a direction.
/// @param width, height pixels  @throw InvalidArgument for a direction without length, or an `up` along it
ParallelView viewOf(const LitVolume& volume, const Vec3& direction, const Vec3& up, int width, int height);

}  // namespace raysweep::cube4
