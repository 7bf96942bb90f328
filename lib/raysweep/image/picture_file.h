/// A picture file that is open, whatever reads it. For this module's own sources.
#pragma once

#include "raysweep/core/error.h"
#include "raysweep/core/sample_type.h"

#include <cstddef>
#include <optional>
#include <string>

namespace raysweep {

struct PicturePage {
    int width = 0, height = 0, depth = 1, channels = 0;
    std::optional<SampleType> type;  ///< float32 for half floats; none if the type is not known
    std::string typeName;            ///< as the file's reader calls it
    bool straightAlpha = false;      ///< colours are not multiplied by alpha, the last of 2 or 4 channels
};

/// Every function throws IoError, which names the file.
class PictureFile {
  public:
    virtual ~PictureFile() = default;

    virtual int pages() = 0;
    virtual PicturePage page(int number) = 0;
    /// All channels of a page, as floats; integers are scaled to [0,1].
    virtual void readFloats(int number, float* to) = 0;
    /// A page of one channel and a known type as it is stored.
    virtual void readSamples(int number, std::byte* to) = 0;
};

constexpr const char* kGivePicture = "; give an EXR, HDR, PNG, JPEG or TIFF picture";

[[noreturn]] inline void failToRead(const std::string& path, const std::string& why) {
    throw IoError("cannot read '" + path + "': " + why);
}

[[noreturn]] inline void failToWrite(const std::string& path, const std::string& why) {
    throw IoError("cannot write '" + path + "': " + why);
}

}  // namespace raysweep
