/// Scans in HDF5 files of the Data Exchange layout, as synchrotrons write and TomoPy reads them.
#pragma once

#include "raysweep/camera/projections.h"
#include "raysweep/core/progress.h"
#include "raysweep/core/sample_type.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// What a detector counted, with the object, without it, and without beam.
struct DataExchange {
    Projections counts;                     ///< raw counts, not line integrals
    SampleType type = SampleType::float32;  ///< of the counts in the file
    std::vector<float> flat, dark;  ///< mean over frames without object, without beam; columns fastest, then rows;
                                    ///< empty: the file has none
    int flatFrames = 0, darkFrames = 0;
    std::vector<double> angles;  ///< of each view, as the file has them; empty: it does not say them
    std::string angleUnits;      ///< as the file calls them; empty: it does not
    int detectorRows = 0;        ///< of the whole detector
    bool sinograms = false;      ///< the file has one detector row after the other, not one view after the other
    bool complete = true;        ///< false if reading was stopped: then values are missing
};

/// True for names of files that are HDF5: .h5, .hdf5, .hdf, .nxs.
bool isHdf5(const std::string& path);

/// Detector rows first to last, both included.
struct RowRange {
    int first = 0, last = 0;
};

struct DataExchangeOptions {
    std::optional<RowRange> rows;  ///< the only ones to read; all without it
    bool angles = true;            ///< false: /exchange/theta is not looked at
    bool flat = true;  ///< frames without object, which must be there; false: those in the file are not looked at
    bool dark = true;  ///< frames without beam, if there are any; false likewise
    /// Integers with a sign hold counts without one: those below 0 are meant to be larger by all that the type can
    /// tell, 65536 for 16 bits.
    bool unsignedCounts = false;
};

/// Reads /exchange/data (views x rows x columns; rows x views x columns if its attribute `axes`, or the sizes of
/// angles and frames, say so; two dimensions: a detector of one row), /exchange/data_white or data_flat and
/// /exchange/data_dark (frames x rows x columns) of any number type, and /exchange/theta. Frames' values that are not
/// finite are left out of the mean. Source: F. De Carlo et al., Scientific data exchange: a schema for HDF5-based
/// storage of raw and analyzed data, J. Synchrotron Rad. 21 (2014), 1224-1230.
/// @throw InvalidArgument if `rows` are not in the file, if counts below 0 are those of another number type
/// (requireCounts), or this machine has no memory for them.
/// @throw IoError naming the dataset that is missing, damaged, never written in part, or of a size that does not fit
/// the others.
DataExchange readDataExchange(const std::string& path, const DataExchangeOptions& options = {},
                              const ProgressCallback& progress = {});

}  // namespace raysweep
