/// One call from the files of an X-ray scan to line integrals and where their rays ran.
#pragma once

#include "raysweep/camera/projections.h"
#include "raysweep/core/progress.h"
#include "raysweep/scan/data_exchange.h"
#include "raysweep/scan/rotation_center.h"
#include "raysweep/scan/scan_geometry.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// Whether the column onto which the axis falls is looked for in opposite views (findRotationCenter).
enum class AxisSearch {
    automatic,  ///< for parallel beams of HDF5 files, unless `ScanGeometryOptions::axisColumn` is given
    always,     ///< parallel beams only, and not with an `axisColumn`
    never
};

/// What the rows of pictures, or of the slices of a volume, are.
enum class Sinograms {
    automatic,  ///< views of a single picture, unless a geometry file, `views` or `width` say that it is one view; and
                ///< where that many views or angles are given; else detector rows
    always,     ///< views: each picture is the sinogram of a detector row
    never       ///< detector rows: each picture is a view
};

/// Files, and what is done to what is in them, in this order.
struct ScanOptions {
    /// What readProjections reads, one value for each ray, or one HDF5 file (.h5, .hdf5, .hdf, .nxs) in the Data
    /// Exchange layout.
    std::vector<std::string> projections;
    /// What is counted without object: a file of frames, of which the mean is taken; a number; "auto": as much as at
    /// the detector's sides (flatFromSides); or "none": the projections are line integrals already, and so they are if
    /// it is empty. HDF5 files have their own frames, which are taken if it is empty.
    std::string flat;
    std::string dark;  ///< likewise without beam: a file or a number; "none", and empty without frames in the file: 0
    bool unsignedCounts = false;  ///< see DataExchangeOptions
    /// Counts from which on the detector is over-exposed, > 0: the line integral is at most what they say. Default:
    /// where the numbers end (exposureLimit). Of line integrals the same as `saturation`.
    std::optional<double> saturatedAbove;
    Sinograms sinograms = Sinograms::automatic;  ///< not of HDF5
    std::optional<RowRange> rows;                ///< HDF5: the only ones to read, see readDataExchange
    bool repair = false;                         ///< see ProjectionReadOptions; of `flat` and `dark` as well
    double scale = 1;                            ///< factor on line integrals, > 0
    std::optional<double> saturation;            ///< line integral, > 0: see Projections::saturation
    bool findDeadPixels = false;                 ///< see markDeadPixels
    int ringWindow = 0;                          ///< see RingFilterOptions::window; 0: no filter
    AxisSearch axisSearch = AxisSearch::automatic;
    ScanGeometryOptions geometry;

    /// What can be checked without reading a file. @throw InvalidArgument naming the field, and value and bound, or
    /// what it needs.
    void validate() const;
};

/// What is possible, but hardly meant.
struct ScanWarning {
    enum class Kind {
        detectorBeforeAxis,  ///< a cone's detector is nearer to the source than the axis is
        pixelPitch,          ///< projections and geometry file differ in how far pixels are apart
        deadPixels,          ///< more than half of the detector
        values,              ///< they look like something else, see doubtsAbout
        implausible          ///< no measurements, and left out (markImplausible, lineIntegrals)
    };
    Kind kind;
    std::string message;
};

/// Rays that say less than their line integral.
struct RayCounts {
    std::size_t notMeasured = 0;
    std::size_t saturated = 0;    ///< RayBound::atLeast
    std::size_t overexposed = 0;  ///< RayBound::atMost
};

/// What was found in a scan, and what was taken for granted.
struct ScanFindings {
    std::string format;          ///< "MetaImage", "NRRD", "pictures", "Data Exchange"
    std::size_t deadPixels = 0;  ///< of the detector: without gain, or found by `findDeadPixels`
    RayCounts rays;
    std::optional<RotationCenter> axis;    ///< if it was looked for
    std::size_t implausible = 0;           ///< values that can be no measurement; not measured
    std::vector<std::string> assumptions;  ///< what was taken for granted, in words
    bool anglesAssumed = false;  ///< nothing says at what angles the views are: evenly over half or a full turn
    bool pitchAssumed = false;   ///< nothing says how far pixels are apart: 1
    std::vector<ScanWarning> warnings;
};

struct Scan {
    Projections projections;  ///< line integrals, without unit; NaN where not measured
    ProjectionGeometry geometry;
    ScanFindings found;
    bool complete = true;  ///< false if reading was stopped: then there is nothing else in it
};

/// Reads a scan, makes line integrals of counts, leaves out what did not measure, finds the axis if asked to, and
/// works out where the rays ran.
/// @throw InvalidArgument as ScanOptions::validate; for values that cannot be worked with; if no ray was measured; if
/// projections and geometry, or projections and `flat` or `dark`, differ in size; as findRotationCenter and
/// scanGeometry.
/// @throw IoError as readProjections, readDataExchange and readGeometry.
Scan readScan(const ScanOptions& options, const ProgressCallback& progress = {});

/// A warning if a cone's detector stands before the axis; projections of it are possible.
std::optional<ScanWarning> detectorBeforeAxis(const ScanGeometryOptions& options);

RayCounts countRays(const Projections& projections);

}  // namespace raysweep
