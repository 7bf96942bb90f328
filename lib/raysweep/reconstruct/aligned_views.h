/// Detectors whose rows lie in the orbit's plane and whose columns run along its axis, which is what filtered
/// backprojection filters along. A detector that stands otherwise, rolled, on its side or inclined, is resampled to
/// such a one at the same distance, by Lanczos' kernel of three lobes (C. E. Duchon, "Lanczos filtering in one and two
/// dimensions", J. Appl. Meteorol. 18, 1979).
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/reconstruct/orbit_fit.h"
#include "raysweep/reconstruct/redundancy.h"
#include "raysweep/reconstruct/view_matrix.h"

#include <vector>

namespace raysweep {

struct AlignedView {
    XrayView xray;  ///< of the aligned detector
    int width = 0, height = 0;
    int before = 0;          ///< columns without rays before those of the detector, see widen
    bool resampled = false;  ///< false: it is the view's own detector
    ViewMatrix measured;     ///< resampled: onto which pixel of the view's own detector a point falls
    DetectorReach reach;     ///< columns of the aligned detector, pixels, from edge to edge, that all rows measure; if
                             ///< rows have little in common, that any measures
};

/// The part of a detector that counts, from edge to edge: its outermost pixels reach half a pixel further than their
/// centres.
struct DetectorPart {
    double left = 0, right = 0;  ///< columns
    double top = 0, bottom = 0;  ///< rows
};

DetectorPart wholeDetector(const ProjectionGeometry& geometry);

/// @param parts of each view's own detector that `reach` is of; none: the whole
/// @throw InvalidArgument naming the first view whose rays run away from the axis, or more along it or aside than
/// towards it: no aligned detector faces those.
std::vector<AlignedView> alignedViews(const ProjectionGeometry& geometry, const OrbitFit& orbit,
                                      const std::vector<DetectorPart>& parts = {});

/// Adds columns at both sides of a detector, on which no ray falls: what filtering spreads there counts as well.
void widen(AlignedView& view, int before, int after);

/// What the aligned detector would have measured: rows of `view.width`, 0 where no ray falls. Beyond the edges of the
/// view's own detector along the axis its outermost value is repeated: objects are often longer than the detector.
/// @param pixels of the view's own detector, `geometry.width` x `geometry.height`
void alignedRows(const AlignedView& view, const ProjectionGeometry& geometry, const float* pixels, float* rows);

}  // namespace raysweep
