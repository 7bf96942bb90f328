/// What the two files that use ITK share. Nothing else includes it.
#pragma once

#include "raysweep/formats/stored_volume.h"

#include <itkImageIOBase.h>
#include <itkMacro.h>

#include <iostream>
#include <sstream>
#include <string>

namespace raysweep {

[[noreturn]] void failRead(const std::string& path, const std::string& why);

/// While it lives, what ITK and the libraries below it would print is kept here instead: a library does not print, and
/// some of them say what is wrong nowhere else.
class Silence {
  public:
    Silence();
    ~Silence();
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;

    /// What was said so far, in one line.
    std::string said() const;

  private:
    std::ostringstream kept_;
    std::streambuf *cerr_, *cout_;
};

/// The reason in ITK's message, without file names, addresses and the path that the error took.
std::string reasonOf(const itk::ExceptionObject& error);

/// Dimensions, type and place of what `io` has read the header of; no samples yet. Dimensions after the third are left
/// out. @throw InvalidArgument if a voxel has more than one number. @throw IoError if the header makes no sense.
StoredVolume describe(const itk::ImageIOBase& io, const std::string& path);

/// Reads all samples; `to` has room for them.
void readInto(itk::ImageIOBase& io, void* to);

/// Calls `read` and turns ITK's errors into ours. `part` of the file: "header" or "data".
template <class Read>
void guarded(const std::string& path, const std::string& part, const Silence& silence, const Read& read) {
    try {
        read();
    } catch (const itk::ExceptionObject& error) {
        const std::string said = silence.said();
        // What was said first is the cause; then come the functions that it made fail.
        failRead(path, "in its " + part + ": " + (said.empty() ? reasonOf(error) : said.substr(0, said.find(';'))));
    }
}

}  // namespace raysweep
