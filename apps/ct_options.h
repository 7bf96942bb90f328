/// What `raysweep ct` is told.
#pragma once

#include "scan_options.h"

#include "raysweep/reconstruct/reconstruct.h"
#include "raysweep/scan/scan.h"

#include <string>

namespace raysweep::apps {

/// What the user typed; empty text: not given. Whole after completeOptions, but for the volumes.
struct CtArguments {
    CommonOptions common;
    ScanOptions scan;
    ReconstructOptions reconstruct;
    ScanArguments geometry;
    std::string axisColumn, rows;
    std::string output, method = "sart", order = "golden", support = "auto", window = "ram-lak";
    std::string size, spacing, center, initial, reference, plot, slices, record;
    bool nonNegative = false, half = false, sinograms = false;
};

void addCtOptions(CLI::App& command, CtArguments& arguments);

/// Everything that can be said to be wrong before a file is read. @throw CLI::ValidationError
void completeOptions(CtArguments& arguments, const CLI::App& command);

}  // namespace raysweep::apps
