/// Pictures of how a computation went.
#pragma once

#include "raysweep/illuminate/illuminate.h"

#include <string>

namespace raysweep::apps {

/// Fails early: the file must end in .svg or .png and gnuplot must be there. @throw Error
void requirePlot(const std::string& path);

/// RMS difference and unshot share against sweeps, with the tolerance, as .svg or .png.
/// @throw IoError if gnuplot fails or the file cannot be written
void plotConvergence(const std::string& path, const std::vector<ConvergencePoint>& history, double tolerance);

}  // namespace raysweep::apps
