/// What microscopes' programs say of the pages of a TIFF: ImageJ's description and OME-XML.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/formats/rescale.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// Of the first pixel, and from one to the next, row to row, slice to slice; world units.
struct StoredPlace {
    Vec3 origin{0};
    std::array<Vec3, 3> steps{};
};

struct PictureLayout {
    bool known = false;   ///< false: nothing was said, pages are slices
    std::string program;  ///< that said it, for messages
    int channels = 1, slices = 1, frames = 1;
    std::string order = "CZT";              ///< fastest first: channels, slices (z), frames (t)
    std::vector<std::string> channelNames;  ///< may be empty
    Vec3 spacing{0};                        ///< between columns, rows, slices; 0: not said
    std::string unit;                       ///< empty: not said
    std::optional<StoredPlace> place;       ///< where Raysweep wrote it: tells more than the spacing
    Rescaling rescaling;                    ///< from samples to the numbers that they stand for

    /// The page of a channel, slice and frame.
    int page(int channel, int slice, int frame) const;
};

/// @param columnsPerUnit, rowsPerUnit resolution of the first page, 0 if it does not say, for ImageJ
/// @throw IoError if the description contradicts itself. @throw InvalidArgument if it asks for what cannot be done:
/// calibration that is no straight line, several images, pages in an order of their own or in other files
PictureLayout pictureLayout(const std::string& path, const std::string& description, double columnsPerUnit,
                            double rowsPerUnit);

}  // namespace raysweep
