/// Less rings around the axis, which detector pixels leave that measure a little too much or too little in all views:
///
///     p_n(u) <- p_n(u) - ring(u),   ring = d - median_W d,   d = m - mean_W m,   m(u) = mean over n of p_n(u)  (7)
///
/// (docs/ct.md, eq. 7) with n views, u columns of a detector row, W a window of columns. Moving average: M. L. Rivers,
/// Tutorial introduction to X-ray computed microtomography data processing (University of Chicago, 1998); with it alone
/// a ring leaves traces beside it. A filter in Fourier space to the same end: C. Raven, Numerical removal of ring
/// artifacts in microtomography, Rev. Sci. Instrum. 69 (1998), 2978-2980.
#pragma once

#include "raysweep/camera/projections.h"

namespace raysweep {

struct RingFilterOptions {
    /// Columns of moving average and median, odd, >= 3: what is wider than half of it stays. More removes wider rings,
    /// and more of what is round about the axis itself.
    int window = 9;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Subtracts eq. 7's ring from each row: over the views an object's details average out, and those of the detector
/// stay. Rays that were not measured stay so; saturated values, which are bounds and not values, stay as they are.
/// Bodies that are round about the axis and have sharp edges lose some of them.
/// @throw InvalidArgument as RingFilterOptions::validate.
void filterRings(Projections& projections, const RingFilterOptions& options = {});

}  // namespace raysweep
