/// A picture file that is open, whatever reads it. For this module's own sources, and for those who take pictures as
/// numbers (formats/).
#pragma once

#include "raysweep/core/error.h"
#include "raysweep/core/sample_type.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

struct PicturePage {
    int width = 0, height = 0, depth = 1, channels = 0;
    std::optional<SampleType> type;  ///< float32 for half floats; none if the type is not known
    std::string typeName;            ///< as the file's reader calls it
    bool straightAlpha = false;      ///< colours are not multiplied by alpha, the last of 2 or 4 channels

    // What only those need who take samples as numbers.
    double highest = 0;                          ///< that samples can be, where it is less than their type's; 0: that
    bool extra = false;                          ///< a smaller copy or a mask of another page, no picture of its own
    std::string name;                            ///< of the part of a file; may be empty
    std::vector<std::string> channelNames;       ///< may be empty
    int left = 0, top = 0;                       ///< place of the first pixel in a larger picture
    double columnsPerUnit = 0, rowsPerUnit = 0;  ///< resolution, whatever its unit; 0: not said
};

/// Every function throws IoError, which names the file.
class PictureFile {
  public:
    virtual ~PictureFile() = default;

    virtual int pages() = 0;
    virtual PicturePage page(int number) = 0;
    /// What the file says about itself; may be empty.
    virtual std::string description() { return ""; }
    /// All channels of a page, as floats; integers are scaled to [0,1].
    virtual void readFloats(int number, float* to) = 0;
    /// One channel of a page of a known type, as it is stored; row 0 on top.
    virtual void readSamples(int number, int channel, std::byte* to) = 0;
};

/// A picture as its samples are stored: neither decoded, nor inverted, nor multiplied by alpha.
/// @throw IoError if there is none, or it is none, or a JPEG that ends early
std::unique_ptr<PictureFile> openStoredPicture(const std::string& path);

constexpr const char* kGivePicture = "; give an EXR, HDR, PNG, JPEG or TIFF picture";

[[noreturn]] inline void failToRead(const std::string& path, const std::string& why) {
    throw IoError("cannot read '" + path + "': " + why);
}

[[noreturn]] inline void failToWrite(const std::string& path, const std::string& why) {
    throw IoError("cannot write '" + path + "': " + why);
}

}  // namespace raysweep
