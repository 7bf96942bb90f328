/// One call from a scan and a method to a volume.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/fbp.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/reconstruct/sart.h"
#include "raysweep/scan/scan.h"

#include <cstddef>
#include <string>
#include <vector>

namespace raysweep {

enum class ReconstructionMethod {
    sart,    ///< view after view corrects the volume
    osSart,  ///< some views together
    sirt,    ///< all views together
    fbp      ///< filtered backprojection, of cones Feldkamp's (FDK): in one step
};

struct ReconstructOptions {
    ReconstructionMethod method = ReconstructionMethod::sart;
    int subset = 0;    ///< osSart: views that correct together, >= 0; 0: a tenth of them
    SartOptions sart;  ///< sart, osSart and sirt; `viewsPerUpdate` follows from the method
    FbpOptions fbp;    ///< fbp, and `startFiltered`
    GridOptions
        grid;  ///< what is not asked for follows from `volumes.initial`, else `volumes.reference`, else the scan
    SartVolumes volumes;         ///< iterative methods start from `initial`; both may be null
    bool startFiltered = false;  ///< iterative methods start from filtered backprojection; then without `initial`

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

enum class ReconstructionTermination {
    done,        ///< fbp
    iterations,  ///< all passes were made
    residual,    ///< `stopResidual` was reached
    interrupted  ///< the progress callback said stop; the volume is what there was
};

/// What is possible, but hardly meant.
struct ReconstructionWarning {
    enum class Kind {
        saturation,   ///< filtered backprojection takes saturated values as if they were measured
        shortScan,    ///< see scanWarning
        truncation,   ///< the object is wider than the detector, see Truncation
        raysBeside,   ///< iterative methods: the object is larger than the grid, see RaysBeside
        voxelSize,    ///< far from what the detector resolves
        opaqueVoxel,  ///< a single voxel stops nearly all of a ray
        fewViews,     ///< the grid falls onto the detector in less than half of the views
        emptyVolume
    };
    Kind kind;
    std::string message;
};

struct ReconstructionTimings {
    double filtered = 0, updates = 0;  ///< s: filtered backprojection; corrections of iterative methods
    double total = 0;                  ///< s: all of the call but the comparison and the warnings
};

struct Reconstruction {
    openvdb::FloatGrid::Ptr volume;  ///< "density", 1/world unit
    ReconstructionGrid grid;         ///< where it was reconstructed
    ReconstructionTermination termination = ReconstructionTermination::done;
    double fieldRadius = 0;  ///< of what was measured from all sides, if the object is wider than the detector: nothing
                             ///< is kept further from the axis; world units, else 0
    double rowsCut = 0;      ///< then the share of ends of detector rows that lie within the object
    int viewsSeeing = 0;     ///< views in which the grid falls onto the detector
    double rms = 0;          ///< difference to the reference over all voxels of the grid, as SartPoint::rms,
                             ///< 1/world unit; NaN without one. Only fbp takes a reference whose voxels do not
                             ///< coincide with the grid's: then it is that of compareGrids
    std::vector<SartPoint> history;  ///< iterative methods only, as the next three
    int updates = 0;                 ///< corrections made
    std::size_t keptVoxels = 0;      ///< see SartResult
    std::size_t raysUsed = 0;        ///< likewise
    ReconstructionTimings seconds;
    std::vector<ReconstructionWarning> warnings;
};

/// The least memory that a reconstruction needs beside its scan, bytes: the volume if it is held whole; if only what no
/// view looks past is kept (Support::automatic), a sixteenth of it, the least that an object takes up.
double leastBytes(const ReconstructionGrid& grid, const ReconstructOptions& options);

/// The volume whose X-rays the scan's are. Filtered backprojection gives rays that were not measured a value
/// (fillUnmeasured, in a copy); iterative methods leave them out. An object that is wider than the detector is
/// continued beyond it (Truncation): rows before they are filtered, and the voxels that iterative methods work on, with
/// which their residuals and RMS differences are. A direct method then needs memory for projections as wide as the
/// object. The same bits for any number of threads.
/// @throw InvalidArgument as ReconstructOptions::validate, ProjectionGeometry::validate, requireMatching and
/// reconstructionGrid; if the detector misses the grid in every view, this machine has less memory than leastBytes, a
/// given volume has no active voxels, or densities leave the range of floats; as sart and filteredBackprojection.
Reconstruction reconstruct(const Scan& scan, const ReconstructOptions& options = {},
                           const ProgressCallback& progress = {});

}  // namespace raysweep
