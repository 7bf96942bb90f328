/// Pictures of a lit volume.
#pragma once

#include "raysweep/camera/camera.h"
#include "raysweep/camera/photo_camera.h"
#include "raysweep/core/progress.h"
#include "raysweep/core/types.h"
#include "raysweep/image/image.h"
#include "raysweep/volume/grids.h"

#include <memory>

namespace raysweep {

/// What is looked at.
struct RenderInput {
    /// Non-negative and finite where active, 0 elsewhere (other inactive values count as 0); any linear transform.
    openvdb::FloatGrid::ConstPtr density;
    double extinctionScale = 1;  ///< extinction per unit density, 1/world unit, not negative
    /// Source radiance S, W/m^2/sr: FloatGrid or Vec3SGrid, non-negative and finite; any linear transform. It should
    /// reach one voxel beyond `density`, or edges are mixed with its background. An empty grid with background 1 makes
    /// S = 1 everywhere.
    openvdb::GridBase::ConstPtr radiosity;
    /// Power emitted per volume q, isotropic, W/world unit^3: what shines by itself, with smoke or without, and is no
    /// part of radiosity. FloatGrid or Vec3SGrid, non-negative and finite, 0 where inactive; any linear transform and
    /// resolution. May be null.
    openvdb::GridBase::ConstPtr emission = nullptr;

    /// @throw InvalidArgument for null grids, other grid types, non-linear transforms, NaN, infinite or negative values
    /// (with its voxel)
    void validate() const;
};

/// A volume made ready for pictures: checked, and copied to where rays find it quickly, which takes 6 bytes per voxel
/// of its leaves for each of density and the channels of radiosity and emission. For several pictures of one volume;
/// its grids must stay as they are.
class RenderVolume {
  public:
    /// @throw InvalidArgument as RenderInput::validate, and if it needs more memory than there is
    explicit RenderVolume(const RenderInput& input);

    struct Content;
    const Content& content() const { return *content_; }

  private:
    std::shared_ptr<const Content> content_;
};

struct RenderOptions {
    double step = 0.5;               ///< distance between samples, voxels of the density, in [0.01,8]; with emission at
                                     ///< most 1/4, and of emission so many of its own voxels, too, at most 1/8
    int samples = 1;                 ///< rays per pixel along each side: n means n x n on a regular grid, in [1,64]
    Color background = grey(0);      ///< radiance behind the volume, not negative
    bool lambert = false;            ///< multiply S by the cosine between view and surface normal, see `render`
    double minTransmittance = 1e-4;  ///< a ray that lets less than this through ends, in [0,1); with emission, which
                                     ///< may be much brighter than what hides it, 1e-4 of this

    /// @throw InvalidArgument that names field, value and bound.
    void validate() const;
};

struct RenderResult {
    Image image;           ///< RGBA, linear
    double seconds = 0;    ///< wall-clock time
    bool complete = true;  ///< false when stopped by the progress callback: the pixels not yet reached are 0
};

/// Emission and absorption along each pixel's rays (Dachille, Mueller, Kaufman 2000, section 2.3; S stands for the
/// power that they store in voxels, see docs/illumination.md), with density, S and q interpolated linearly between
/// voxel centres (paper, eq. 1; docs/illumination.md, eq. L1):
///
///     L = integral of (S(s) sigma(s) + q(s) / (4 pi)) T(s) ds + T(end) background
///         with T(s) = exp(-integral of sigma from the eye to s)
///       = sum over steps, front to back, of S T (1 - exp(-sigma ds))
///         + sum over steps through the emission of q / (4 pi) integral of T ds + T background
///
/// Each step takes sigma and S, or q, at its middle. Those through smoke take its exact opacity, so S = background = 1
/// gives 1 in every pixel whatever the density and the step. Samples lie at fixed distances from the eye, so skipping
/// empty space changes nothing. A ray that ends early passes what little it had left on to what it met.
///
/// The picture is RGBA, alpha = 1 - T: a fire without smoke is not opaque. RGB is what arrives at the eye: **the
/// background is composited already**; to put the volume over another picture render it over black, then RGB is
/// premultiplied in the usual sense.
///
/// With `lambert` S is multiplied by max(0, -d.n), d the direction of view, n = -grad sigma/|grad sigma| (central
/// differences over one voxel each way): the paper's cosine factor, for surfaces in classified solids. Where density is
/// flat there is no normal and the factor is 1.
///
/// The same bits for any number of threads.
/// @param progress called between groups of buckets, squares of pixels; when it returns false the picture is returned
/// as it is.
/// @throw InvalidArgument for options or camera out of range.
RenderResult render(const RenderVolume& volume, const Camera& camera, const RenderOptions& options = {},
                    const ProgressCallback& progress = {});

/// As a photograph shows it, through any lens. @throw InvalidArgument for options or camera out of range.
RenderResult render(const RenderVolume& volume, const PhotoCamera& camera, const RenderOptions& options = {},
                    const ProgressCallback& progress = {});

/// One picture. @throw InvalidArgument for what cannot be made ready, too.
RenderResult render(const RenderInput& input, const Camera& camera, const RenderOptions& options = {},
                    const ProgressCallback& progress = {});

/// The box in world space around the active voxels and tiles of `grid`; empty if there are none.
Box3 worldBounds(const openvdb::GridBase& grid);
/// The same around all that can be seen: density and emission.
Box3 worldBounds(const RenderInput& input);

}  // namespace raysweep
