/// From what a detector counted to line integrals, and what to do about pixels that did not measure.
#pragma once

#include "raysweep/camera/projections.h"

#include <cstddef>
#include <limits>
#include <vector>

namespace raysweep {

struct LineIntegralOptions {
    /// Transmission, in (0,1), below which counts say only that there was no more: the line integral is at least
    /// -log of it. The default, 4 counts of a 16 bit detector at 2/3 of its range, is about what dark frames vary by.
    double minimumTransmission = 1e-4;
    /// Counts above the dark ones, >= 0, below which there may have been more or less by chance: 1 of integers, 0 of
    /// numbers that tell finer. They say "at least" as well.
    double leastCount = 0;
    /// Counts from which on the detector counts no more: the line integral is at most what they say.
    double saturatedAbove = std::numeric_limits<double>::infinity();
    /// Transmission, > 1, above which counts are no measurement, but of a pixel that was hit or is broken; as much
    /// below 0 likewise.
    double maximumTransmission = 10;
    /// A pixel whose flat minus dark is below this part of the detector's median, in [0,1), is dead; one with more than
    /// the median over the square of it likewise.
    double deadGain = 0.05;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

struct LineIntegrals {
    Projections projections;      ///< `saturation` is -log(minimumTransmission)
    std::size_t deadPixels = 0;   ///< of the detector; NaN in all views
    std::size_t implausible = 0;  ///< values beyond `maximumTransmission`; NaN
};

/// -log((counts - dark) / (flat - dark)) for each ray, without unit. Counts at or below the dark ones, and all others
/// below `minimumTransmission` or `leastCount`, say "at least": they become what these are. Counts that are not finite,
/// or beyond `maximumTransmission`, become NaN, "not measured".
/// @param flat,dark counts without object and without beam: one of each for each pixel, columns fastest.
/// @throw InvalidArgument if sizes do not fit, or no pixel is alive (flat and dark frames swapped, for instance).
LineIntegrals lineIntegrals(Projections counts, const std::vector<float>& flat, const std::vector<float>& dark,
                            const LineIntegralOptions& options = {});

/// Finds pixels that count, but not what falls onto them: those that are the same in all views while one of the two
/// pixels to the left and one of the two to the right vary; and those that differ from the median of the neighbours by
/// more than twice the range of these in more than half of the views. Neighbours are the other pixels of the 5 x 3
/// around. All values of such pixels become NaN. Wider clusters are not found. Fewer than 8 views prove nothing: then
/// no pixel is dead.
/// @return how many pixels were found, without those that were NaN in all views already.
std::size_t markDeadPixels(Projections& projections);

/// Gives values to rays that were not measured, for algorithms that need all of them (filtered backprojection):
/// between the nearest measured ones of the row in a straight line, beyond the last one constant; a row without any is
/// that of the nearest row which has some. Nothing is measured thereby: iterative reconstruction leaves NaN out
/// instead.
/// @return how many values. @throw InvalidArgument naming the first view in which nothing was measured.
std::size_t fillUnmeasured(Projections& projections);

}  // namespace raysweep
