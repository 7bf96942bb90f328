/// The files of a scan, as they are: values, frames, angles, and what was taken for granted in reading them.
#pragma once

#include "raysweep/core/sample_type.h"
#include "raysweep/scan/scan.h"

#include <string>
#include <vector>

namespace raysweep {

/// What was read, before anything is done to it.
struct MeasuredFiles {
    Projections values;
    SampleType type = SampleType::float32;  ///< of the file's numbers
    MeasuredScan scan;
    std::vector<float> flat, dark;  ///< empty: `values` are line integrals already
    std::string format;
    std::vector<std::string> assumptions;  ///< see ScanFindings
    bool complete = true;                  ///< false if reading was stopped
};

/// What `ScanOptions::flat` and `dark` name.
enum class FrameSource {
    none,    ///< values are line integrals; of `dark`: 0
    own,     ///< the HDF5 file has frames
    number,  ///< the same for each pixel
    sides,   ///< estimated (flatFromSides)
    file
};

FrameSource flatSource(const ScanOptions& options);
FrameSource darkSource(const ScanOptions& options);

/// @throw as readScan
MeasuredFiles readMeasuredFiles(const ScanOptions& options, const ProgressCallback& progress);

}  // namespace raysweep
