/// What filtered backprojection does with views that come one by one.
#pragma once

#include "raysweep/camera/projections.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/direct_scan.h"
#include "raysweep/reconstruct/fbp.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/volume/grids.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace raysweep {

/// The pixels of view n of a scan's detector, all finite: somewhere, or in `room`.
using ViewPixels = std::function<const float*(std::size_t n, std::vector<float>& room)>;

/// @throw InvalidArgument naming the first pixel that is not finite, if no detector sees the axis, or if too many lines
/// are measured from no side.
void requireUsable(const DirectScan& scan, const Projections& projections);

/// See filteredBackprojection; `where` and `options` are valid, the scan is usable.
/// @throw InvalidArgument if the grid reaches a source, or this machine has less memory than the filtered views need.
openvdb::FloatGrid::Ptr backprojection(const DirectScan& scan, const ViewPixels& pixels,
                                       const ReconstructionGrid& where, const FbpOptions& options,
                                       const ProgressCallback& progress);

}  // namespace raysweep
