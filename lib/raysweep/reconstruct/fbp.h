/// Filtered backprojection: a volume in one go from projections along a turn about an axis. Parallel beams, FBP (Kak
/// and Slaney, Principles of Computerized Tomographic Imaging, 1988, section 3.3; docs/ct.md, eq. 3):
///
///     x(r) = Σ_n Δθ_n (h * w_n p_n)(u_n(r)) / pitch                                                         (3)
///
/// Cones, FDK (L. A. Feldkamp, L. C. Davis and J. W. Kress, "Practical cone-beam algorithm", J. Opt. Soc. Am. A 1,
/// 1984; Kak and Slaney, section 3.6; docs/ct.md, eq. 4), exact in the sources' plane:
///
///     x(r) = Σ_n Δβ_n SID / (SDD pitch) (h * w_n cos φ p_n)(u_n(r), v_n(r)) / depth_n(r)²                   (4)
///
/// n: views; h: ramp filter along detector rows (ramp_filter.h, eq. 5), samples `pitch` apart; u, v: pixel onto which r
/// falls; Δθ_n, Δβ_n: part of half a turn, or of the turn, that view n stands for (scan_angles.h); w_n: what a ray
/// counts, so that each line of sight counts as one, 1/2 in a full turn (redundancy.h, eq. 9); φ: angle of a ray with
/// the one to the axis; depth: 0 at the source, 1 on the detector. Rows lie in the orbit's plane and columns along its
/// axis: detectors that stand otherwise are resampled (aligned_views.h).
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/camera/projections.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/ramp_filter.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/volume/grids.h"

#include <string>

namespace raysweep {

struct FbpOptions {
    RampWindow window = RampWindow::ramLak;  ///< see RampWindow
    double cutoff = 1;         ///< where the window ends, of the highest frequency that the detector resolves, in (0,1]
    bool nonNegative = false;  ///< densities below 0 become 0
    float tolerance = 0;       ///< voxels this close to 0 are left out, 1/world unit, >= 0

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Extinction, per world unit, of the voxels `where`, by eq. 3 or 4: between pixels linearly, 0 beside the detector.
/// Views may be at any angles, detectors displaced and turned in any way; what rays are missing scanWarning says.
/// Saturation is not known to it. The grid "density" has all voxels that are further than the tolerance
/// from 0; the same bits for any number of threads. If `progress` asks to stop, the rest of the volume is empty.
/// Memory: the volume, and a copy of the projections as wide as if detectors reached equally far to both sides of the
/// axis.
/// @throw InvalidArgument if projections and geometry differ in size, naming the first pixel that is not finite, if the
/// grid reaches a source, if no detector sees the axis, if too many lines are measured from no side (DirectScan), if
/// rays run aside or along the axis (alignedViews), if this machine has less memory than that copy takes, as fitOrbit,
/// and as validate.
openvdb::FloatGrid::Ptr filteredBackprojection(const Projections& projections, const ProjectionGeometry& geometry,
                                               const ReconstructionGrid& where, const FbpOptions& options = {},
                                               const ProgressCallback& progress = {});

/// What the scan leaves out that filtered backprojection needs: less than half a turn, for cones and the angle of the
/// fan; lines of sight that a displaced detector, or a turn with gaps, measures from some sides only. Empty if nothing
/// is amiss, or if the projections, which may be null, show nothing along such lines.
/// @throw InvalidArgument as fitOrbit, and as filteredBackprojection for detectors.
std::string scanWarning(const ProjectionGeometry& geometry, const Projections* projections = nullptr);

}  // namespace raysweep
