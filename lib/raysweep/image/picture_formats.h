/// Pictures that are no EXR. OpenImageIO, which reads them, brings some 220 shared libraries along: loading them takes
/// longer than most commands. So it is in a module of its own, which is loaded when it is needed.
#pragma once

#include "raysweep/image/picture_file.h"

#include <memory>

namespace raysweep {

/// What to do with alpha that a format stores apart from colour.
enum class Alpha { multiplied, asStored };

/// Eight bits per channel, as they are to stand in the file.
struct EncodedPicture {
    int width, height, channels;
    const unsigned char* bytes;
};

/// What the module gives. To be counted up whenever something that passes between library and module changes.
constexpr int kPictureFormatsVersion = 4;
struct PictureFormats {
    int version;
    /// @throw IoError
    std::unique_ptr<PictureFile> (*open)(const std::string& path, Alpha alpha);
    /// For its samples as they are stored, which readSamples gives. @throw IoError
    std::unique_ptr<PictureFile> (*openStored)(const std::string& path);
    /// Writes to `temporary`, by its extension; messages name `path`. @throw IoError
    void (*write)(const std::string& path, const std::string& temporary, const EncodedPicture& picture);
};

}  // namespace raysweep
