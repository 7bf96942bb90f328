/// SART, the simultaneous algebraic reconstruction technique: A. H. Andersen and A. C. Kak, "Simultaneous Algebraic
/// Reconstruction Technique (SART): a superior implementation of the ART algorithm", Ultrasonic Imaging 6, 1984;
/// Dachille, Mueller and Kaufman 2000, section 3. Each update goes over the rays i of one view or of several, and
/// corrects every voxel j that they meet by the mean of their residuals, each spread over its ray's length,
///
///     x_j <- clamp(x_j + λ Σ_i a_ij (p_i - Σ_k a_ik x_k) / Σ_k a_ik  /  Σ_i a_ij)                             (2)
///
/// or x <- x + λ Aᵀ((p - A x) / A 1) / Aᵀ 1 (docs/ct.md, eq. 2): p line integrals, a_ij Joseph's weight times length
/// (joseph.h, eq. 1), λ `relaxation`. Rays i whose p_i is a bound (RayBound) take part only while Σ_k a_ik x_k is
/// beyond it. With all views in one update it is SIRT, with some OS-SART.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/camera/projections.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/reconstruct/view_order.h"
#include "raysweep/volume/grids.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace raysweep {

enum class Support {
    automatic,  ///< only voxels of the visual hull are kept (see support.h)
    none        ///< all voxels of the grid
};

struct SartRecord;

struct SartOptions {
    int iterations = 5;      ///< passes over all views, > 0
    int viewsPerUpdate = 1;  ///< views that correct the volume together: 1 SART, more OS-SART, 0 all of them SIRT; >= 0
    double relaxation = 0.5;     ///< part of the correction that is made, in (0,2) (lambda)
    double relaxationDecay = 0;  ///< pass n, from 0, is relaxed by relaxation / (1 + decay n); >= 0
    ViewOrder order = ViewOrder::golden;
    std::uint32_t seed = 1;                                   ///< of the random order
    double lower = -std::numeric_limits<double>::infinity();  ///< least value of a voxel, 1/world unit; 0: non-negative
    double upper = std::numeric_limits<double>::infinity();   ///< largest
    double totalVariation = 0;  ///< after each pass total variation is lowered, by steps that together change the
                                ///< volume by this part of what the pass changed; in [0,1), 0: not at all
    double stopResidual = 0;    ///< stop when the history has a residual below this; 0: never
    Support support = Support::automatic;
    double supportThreshold = 0.001;  ///< pixels at most this part of the largest line integral (usualLargest) see
                                      ///< nothing; in [0,1)
    int historyEvery = 0;             ///< updates from one point of the history to the next; 0: a pass; >= 0
    double tolerance = 0;             ///< voxels this close to 0 are left out of the result, 1/world unit, >= 0
    SartRecord* record = nullptr;     ///< filled with what it takes to make the same updates again; null: not recorded

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

enum class SartTermination {
    iterations,  ///< all passes were made
    residual,    ///< `stopResidual` was reached
    interrupted  ///< the progress callback said stop; the volume is what there was
};

/// How far it was after a pass, or after `historyEvery` updates.
struct SartPoint {
    int updates;      ///< so far
    double residual;  ///< RMS of p - A x over the rays since the last point, each just before its update, relative to
                      ///< the RMS of their line integrals p; NaN if that is 0, or there was no such ray
    double rms;       ///< RMS difference to the reference over all voxels of the grid; NaN without one
};

struct SartResult {
    openvdb::FloatGrid::Ptr volume;  ///< "density", 1/world unit
    std::vector<SartPoint> history;
    SartTermination termination = SartTermination::iterations;
    int updates = 0;             ///< corrections made
    double seconds = 0;          ///< spent on updates
    std::size_t keptVoxels = 0;  ///< in the support, in blocks of 8x8x16
    std::size_t raysUsed = 0;    ///< in the first pass: measured, meeting the support, and not a bound that the volume
                                 ///< already kept
};

/// What a reconstruction starts from and is compared with; both may be null. Their voxels
/// must be where those of the reconstruction are, whatever their indices.
struct SartVolumes {
    openvdb::FloatGrid::ConstPtr initial;    ///< starts from 0 without it
    openvdb::FloatGrid::ConstPtr reference;  ///< for SartPoint::rms
};

/// The volume whose line integrals come near to `projections`.
/// Memory: the volume, and its grid at the end; one more each with `totalVariation` and with a reference; four pictures
/// for each view that corrects together with others. The same bits for any number of threads.
/// @throw InvalidArgument for options out of bounds; projections that do not fit the geometry; a geometry of which no
/// ray meets the grid; grids of other lattices.
SartResult sart(const Projections& projections, const ProjectionGeometry& geometry, const ReconstructionGrid& grid,
                const SartOptions& options, const SartVolumes& volumes = {}, const ProgressCallback& progress = {});

}  // namespace raysweep
