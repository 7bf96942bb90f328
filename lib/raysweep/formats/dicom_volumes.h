/// Which pictures of a DICOM series make one volume. For the module that reads DICOM.
#pragma once

#include "raysweep/formats/dicom_header.h"
#include "raysweep/formats/volume_choice.h"

#include <string>
#include <vector>

namespace raysweep {

/// By number, those of one number by file and place in it.
void sortByNumber(std::vector<DicomFrame>& frames);

/// By position along the normal of the first, those of one position by number.
/// @throw InvalidArgument if one does not say where it is, or they are turned against each other
void sortByPosition(std::vector<DicomFrame>& frames);

/// Those of one volume. Several (echoes, instants, ...) show as several pictures in each place; what tells these apart
/// numbers the volumes: an attribute of the same values everywhere, else their order by number.
/// @param frames sorted by position @throw InvalidArgument where there are several and `choice` is none of them
std::vector<DicomFrame> chooseFrames(std::vector<DicomFrame> frames, const VolumeChoice& choice);

/// From one slice to the next; not along the normal where the gantry was tilted. At least two, sorted by position.
/// Slices may be off by a tenth of it: scanners round positions, and a missing slice shows as half of it or more.
/// @throw InvalidArgument if they are not equally spaced: it names the place
Vec3 stepOf(const std::vector<DicomFrame>& slices);

}  // namespace raysweep
