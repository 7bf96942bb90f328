#include "raysweep/reconstruct/fbp.h"

#include "raysweep/core/require.h"
#include "raysweep/reconstruct/backprojection.h"
#include "raysweep/reconstruct/direct_scan.h"

#include <cmath>
#include <vector>

namespace raysweep {

void FbpOptions::validate() const {
    requireField(cutoff > 0 && cutoff <= 1, "cutoff", cutoff, "in (0,1]");
    requireField(tolerance >= 0 && std::isfinite(tolerance), "tolerance", tolerance, "0 or more, and finite");
}

std::string scanWarning(const ProjectionGeometry& geometry, const Projections* projections) {
    return DirectScan(geometry, fitOrbit(geometry)).warning(projections);
}

openvdb::FloatGrid::Ptr filteredBackprojection(const Projections& projections, const ProjectionGeometry& geometry,
                                               const ReconstructionGrid& where, const FbpOptions& options,
                                               const ProgressCallback& progress) {
    options.validate();
    where.validate();
    requireMatching(geometry, projections);
    const DirectScan scan(geometry, fitOrbit(geometry));
    requireUsable(scan, projections);
    const auto pixels = [&](std::size_t n, std::vector<float>&) { return projections.view(int(n)); };
    return backprojection(scan, pixels, where, options, progress);
}

}  // namespace raysweep
