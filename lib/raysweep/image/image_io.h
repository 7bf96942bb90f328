/// Pictures in files. In memory a picture is always linear; what a format stores is decided here and nowhere else.
#pragma once

#include "raysweep/image/image.h"

#include <string>

namespace raysweep {

/// Reads EXR, HDR, PNG, JPEG, TIFF. Float formats are taken as linear; integer formats as sRGB, and are decoded. Alpha
/// that the format stores apart from colour (PNG) is multiplied in after decoding, so RGBA is premultiplied whatever
/// the format.
/// @throw IoError if the file is missing, is not a picture, ends early, or holds inks (CMYK).
Image readImage(const std::string& path);

/// Reads how much of each pixel something covers, one channel in [0,1]: alpha if the picture has any that is not 1,
/// else its grey as it is stored. Coverage is no light, so integers are not decoded.
/// @throw InvalidArgument for a coloured picture without alpha, and for values outside [0,1].
/// @throw IoError as readImage.
Image readCoverage(const std::string& path);

struct PictureSize {
    int width, height;  ///< pixels
};

/// The size of the picture that `readImage` would read, from the file's beginning alone. @throw IoError likewise.
PictureSize pictureSize(const std::string& path);

/// Whether that picture has alpha: 2 or 4 channels. What it says is not looked at. @throw IoError as pictureSize.
bool pictureHasAlpha(const std::string& path);

/// Writes by extension: `.exr` 32 bit float as it is; `.png` 8 bit sRGB (values beyond [0,1] are clipped, NaN becomes
/// 0, RGBA is stored with alpha apart from colour). The file appears whole or not at all.
/// @throw InvalidArgument if the picture is empty, inconsistent, or has more channels than the format can hold.
/// @throw IoError if the extension is another one, or the file cannot be written.
void writeImage(const std::string& path, const Image& image);

/// Formats that `writeImage` knows.
enum class ImageFormat {
    Unknown,
    Exr,  ///< linear, any value
    Png   ///< sRGB, 8 bit
};

/// The format that the extension of `path` stands for, whatever its case.
ImageFormat imageFormat(const std::string& path);

/// What a display shows of `image`: colours times 2^exposure, clipped to [0,1], still linear (`writeImage` encodes).
/// Alpha is dropped: a rendered RGBA picture has its background composited already, so RGB is what the eye sees.
/// @param exposure in stops (EV).
/// @throw InvalidArgument if `exposure` is not finite.
Image toneMap(const Image& image, double exposure);

/// The sRGB transfer curve (IEC 61966-2-1), [0,1] to [0,1].
float srgbFromLinear(float linear);
float linearFromSrgb(float encoded);

}  // namespace raysweep
