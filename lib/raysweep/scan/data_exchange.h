/// Scans in HDF5 files of the Data Exchange layout, as synchrotrons write and TomoPy reads them.
#pragma once

#include "raysweep/camera/projections.h"
#include "raysweep/core/progress.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// What a detector counted, with the object, without it, and without beam.
struct DataExchange {
    Projections counts;             ///< raw counts, not line integrals
    std::vector<float> flat, dark;  ///< mean over frames without object, without beam; columns fastest, then rows
    int flatFrames = 0, darkFrames = 0;
    std::vector<double> angles;  ///< of each view, degrees; empty if the file does not say them
    bool complete = true;        ///< false if reading was stopped: then values are missing
};

/// True for names of files that are HDF5: .h5, .hdf5, .hdf, .nxs.
bool isHdf5(const std::string& path);

/// Detector rows first to last, both included.
struct RowRange {
    int first = 0, last = 0;
};

/// Reads /exchange/data (views x rows x columns), /exchange/data_white and /exchange/data_dark (frames x rows x
/// columns) of any number type, and /exchange/theta (degrees) if there is one. Source: F. De Carlo et al., Scientific
/// data exchange: a schema for HDF5-based storage of raw and analyzed data, J. Synchrotron Rad. 21 (2014), 1224-1230.
/// @param rows the only ones to read; all without it.
/// @throw InvalidArgument if `rows` are not in the file.
/// @throw IoError naming the dataset that is missing, damaged, never written in part, or of a size that does not fit
/// the others.
DataExchange readDataExchange(const std::string& path, const std::optional<RowRange>& rows = {},
                              const ProgressCallback& progress = {});

}  // namespace raysweep
