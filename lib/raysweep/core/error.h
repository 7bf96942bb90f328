/// The two ways a call can fail. A message says what was wrong, where, and what to do. One about a field of options
/// begins with that, and other fields that it speaks of are between backticks ("dark: needs `flat` as well"), so that a
/// program can call them as its users know them.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace raysweep {

/// What the library can do about an error if it is asked to. A program knows by which of its options, and adds that to
/// the message; the library's messages name none.
enum class Remedy {
    none,
    chooseMatting,        ///< say how photographs tell the object from its backdrop
    chooseSeries,         ///< say which DICOM series is meant
    describeSamples,      ///< say how many samples of which type a file without a header holds
    fillLevelSet,         ///< take the inside of a level set
    giveExtinction,       ///< say what the extinction is
    giveGrid,             ///< say how many voxels there shall be, and how large
    giveSpacing,          ///< say how far voxels are apart
    isNoLevelSet,         ///< do not ask for the inside of what is no level set
    isVolumeAlready,      ///< the file needs no import
    keepVoxels,           ///< light it without interpolating radiosity to other voxels
    leaveOutRays,         ///< count rays that are NaN or infinite as not measured
    lightFirst,           ///< light the volume
    mapValues,            ///< map the values, for instance to [0,1], when they are imported
    repairVoxels,         ///< set such voxels to 0
    spaceSlicesEvenly,    ///< give the spacing, and take slices as equally spaced
    spaceSlicesByNumber,  ///< give the spacing, and take slices in the order of their numbers
    useOpenCvAxes,        ///< take poses as those of cameras with y down and z ahead
    useOpenGlAxes,        ///< take poses as those of cameras with y up and z back
    useOriginal           ///< use the file that this one was made from
};

struct Error : std::runtime_error {
    /// what() is `message` and `rest`; what a program adds about the remedy belongs between them.
    explicit Error(const std::string& message, Remedy remedy = Remedy::none, const std::string& rest = "")
        : std::runtime_error(message + rest), remedy(remedy), remedyAt(message.size()) {}

    Remedy remedy;
    std::size_t remedyAt;  ///< in what()
    std::string subject;   ///< the file or field of options that it is about; empty: not known
};

/// An argument, option or voxel value that cannot be worked with.
struct InvalidArgument : Error {
    using Error::Error;
};

/// A file that cannot be read or written as asked.
struct IoError : Error {
    using Error::Error;
};

/// `error` said of a `subject`, a file or a field of options: "SUBJECT: message".
template <class AnyError>
AnyError about(const std::string& subject, const AnyError& error) {
    const std::string text = error.what();
    AnyError more(subject + ": " + text.substr(0, error.remedyAt), error.remedy, text.substr(error.remedyAt));
    more.subject = subject;
    return more;
}

}  // namespace raysweep
