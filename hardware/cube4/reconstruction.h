/// SART on the machine (paper, section 3; docs/ct.md, eq. 2): a view's rays are projected through voxel memory,
/// compared with what was measured, and their corrections backprojected.
///
///     x <- clamp(x + λ Aᵀ((p - A x) / A 1) / Aᵀ 1)
///
/// The machine's rays are not those of a detector's pixels: there is one for each voxel of a slice. Measured values are
/// interpolated to them (a warp). Where the detector's pixels, seen along the rays, are voxels of a slice, they are the
/// same rays, and then A is Joseph's projector.
///
/// A cone's rays go through the volume in regions (perspective.h). Their sums are interpolated to the detector's
/// pixels, and the pixels' corrections spread to them by the adjoint (cone_warp.h). Rays of a view that have different
/// major axes are fronts of their own: all are projected, then all are backprojected, and their corrections are added
/// up in the voxels before the last pass makes them part of x.
#pragma once

#include "cube4/backprojector.h"
#include "cube4/base_plane.h"
#include "cube4/dense_volume.h"
#include "cube4/fixed_point.h"
#include "cube4/perspective.h"

#include <memory>
#include <optional>
#include <vector>

namespace raysweep::cube4 {

/// A view of parallel rays, and what was measured. World units.
struct MeasuredView {
    PixelRays rays;
    int width = 0, height = 0;
    std::vector<float> values;  ///< line integrals, row by row; NaN: not measured
};

/// A view of rays from a point, and what was measured.
struct MeasuredCone {
    PointRays rays;
    std::vector<float> values;  ///< as of a MeasuredView
};

struct ReconstructionSetup {
    int pipelines = 16;
    bool overlap = true;
    RaySampling sampling;                ///< of cones
    double lower = 0, upper = 0;         ///< bounds of voxels, 1/world unit; infinite for none
    double saturation = 0;               ///< a line integral that only says "at least"; infinite for none
    std::optional<NumberFormat> format;  ///< none: floats
    double largestValue = 1;             ///< of a voxel, that the format holds
    double largestCorrection = 1;        ///< of a ray
    Ray<double> largestSums;             ///< along a ray, so far as they are known: sums have to hold them

    /// @throw InvalidArgument naming field, value and bound
    void validate() const;
};

/// The machine with a volume in it.
class Reconstruction {
  public:
    /// @param origin world position of the centre of voxel `box.low`
    /// @param initial values to start from, or empty for 0  @param support 1 where voxels take part, or empty for all
    Reconstruction(const DenseBox& box, const Vec3& origin, const ReconstructionSetup& setup,
                   const DenseField& initial = {}, const DenseField& support = {});
    ~Reconstruction();
    Reconstruction(Reconstruction&&) noexcept;

    /// Projects, compares, backprojects. @return RMS of p - A x over the rays that were used
    double update(const MeasuredView& view, double relaxation, Trace* trace = nullptr);

    /// Line integrals of the volume along the rays of a view's pixels, as the machine finds them: those of its own
    /// rays, interpolated. NaN where a pixel's ray meets none.
    std::vector<float> project(const MeasuredView& view);

    /// The same for cones. @throw InvalidArgument for a source inside the volume, or less than a voxel from it
    double update(const MeasuredCone& view, double relaxation, Trace* trace = nullptr);
    std::vector<float> project(const MeasuredCone& view);

    DenseField volume() const;
    double largestValue() const, largestCorrection() const;  ///< that there have been
    Ray<double> largestSums() const;  ///< of values and of weights along a ray, that there have been
    const Counters& projectCounters() const;
    const Counters& backprojectCounters() const;
    std::size_t bytesPerModule() const, bufferBytes() const;

    struct Machine;

  private:
    std::unique_ptr<Machine> machine_;
};

}  // namespace raysweep::cube4
