/// What the values of a scan look like: what they are meant to be, and which of them can be no measurement.
#pragma once

#include "raysweep/camera/projections.h"
#include "raysweep/core/sample_type.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// Makes NaN, "not measured", of line integrals that no scan has: larger than 1000 and than 100 times what 98 % of
/// those that are not 0 are below; or than a million times their median; or beyond 1e30. A single such pixel would be
/// all that there is of a volume. @return how many
std::size_t markImplausible(Projections& lineIntegrals);

/// What of line integrals suggests that they are something else, in words; empty: nothing. Counts and transmissions are
/// evenly large at the detector's sides and smaller within; large negative values beyond the noise are none.
/// @param corrected they were made of counts, by frames without object: they are no counts any more
std::vector<std::string> doubtsAbout(const Projections& lineIntegrals, bool corrected = false);

/// What is counted without object, for each pixel, estimated from the detector's sides, where there must be none: the
/// mean of the outermost columns (a fiftieth of them on either side, in all views), of each row.
/// @throw InvalidArgument if these are not brighter than what is between them, or differ from view to view.
std::vector<float> flatFromSides(const Projections& counts);

/// The count at which a detector ends, if some of `counts` are as large: the largest of the file's integer type, or
/// that of 8, 10, 12, 14 or 16 bits if no count is larger and at least 10 of each million, and 3, are as large. Nothing
/// if the frames without object reach it too: they are what the beam is.
std::optional<double> exposureLimit(const Projections& counts, SampleType type, const std::vector<float>& flat);

}  // namespace raysweep
