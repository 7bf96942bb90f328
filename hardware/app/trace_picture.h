/// Which partial beam is in which stage, cycle by cycle.
#pragma once

#include "cube4/backprojector.h"

#include <string>

namespace raysweep::apps {

/// A line for each cycle, a column for each stage: slice.row.part, or a dot.
std::string traceTable(const cube4::Trace& trace);

/// The same as an SVG; beams of one row have one colour. @throw IoError
void drawTrace(const std::string& path, const cube4::Trace& trace);

}  // namespace raysweep::apps
