/// Words in pictures: small letters of one width, drawn pixel by pixel.
#pragma once

#include "raysweep/image/image.h"

#include <string>

namespace raysweep {

constexpr int kLetterWidth = 9, kTextHeight = 15;  ///< pixels

/// Pixels that `text` takes in a line.
int textWidth(const std::string& text);

/// Writes `text` with its upper left corner in column `left` and row `top`; all channels of its pixels become `light`,
/// others stay. What is beyond the picture is left out, and what is no ASCII letter is shown as a question mark.
void drawText(Image& image, int left, int top, const std::string& text, float light);

}  // namespace raysweep
