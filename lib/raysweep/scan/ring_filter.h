/// Less rings around the axis, which detector pixels leave that measure a little too much or too little in all views.
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

/// Subtracts from each pixel, in all views, what the mean of its values over the views stands out by from those around
/// it in its row: over the views an object's details average out, and those of the detector stay. What stands out is
/// what remains without the moving average, and of that without the median. Rays that were not measured stay so;
/// saturated values, which are bounds and not values, stay as they are. Bodies that are round about the axis and have
/// sharp edges lose some of them. Source: M. L. Rivers, Tutorial introduction to X-ray computed microtomography data
/// processing (University of Chicago, 1998), which has the moving average only, so that a ring leaves traces beside it.
/// A filter in Fourier space to the same end: C. Raven, Numerical removal of ring artifacts in microtomography, Rev.
/// Sci. Instrum. 69 (1998), 2978-2980.
/// @throw InvalidArgument as RingFilterOptions::validate.
void filterRings(Projections& projections, const RingFilterOptions& options = {});

}  // namespace raysweep
