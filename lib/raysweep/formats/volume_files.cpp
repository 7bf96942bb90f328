#include "raysweep/formats/volume_files.h"

#include "raysweep/core/error.h"
#include "raysweep/core/natural_order.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/itk_volume.h"
#include "raysweep/formats/meta_image.h"
#include "raysweep/formats/nifti_volume.h"
#include "raysweep/formats/nrrd_volume.h"
#include "raysweep/formats/picture_volume.h"
#include "raysweep/formats/read_failure.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

enum class Kind { unknown, nrrd, metaImage, nifti, dicom, picture };

const char* const kKnown = "NRRD, MetaImage, NIfTI, DICOM, TIFF, PNG";

/// True if the file starts as DICOM files do.
bool hasDicomMark(const std::string& path) {
    char start[132] = {};
    std::ifstream in(path, std::ios::binary);
    return in.read(start, sizeof start) && std::memcmp(start + 128, "DICM", 4) == 0;
}

Kind kindOf(const std::string& path) {
    const std::string name = lowerCase(path);
    const auto ends = [&](std::initializer_list<const char*> endings) {
        return std::any_of(endings.begin(), endings.end(), [&](const char* end) { return endsWith(name, end); });
    };
    if (ends({".nrrd", ".nhdr"})) return Kind::nrrd;
    if (ends({".mha", ".mhd"})) return Kind::metaImage;
    if (ends({".nii", ".nii.gz", ".hdr", ".img", ".hdr.gz", ".img.gz"})) return Kind::nifti;
    if (ends({".tif", ".tiff", ".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".exr"})) return Kind::picture;
    return ends({".dcm"}) || hasDicomMark(path) ? Kind::dicom : Kind::unknown;
}

[[noreturn]] void failUnknown(const std::string& path) {
    const std::string name = lowerCase(path);
    if (endsWith(name, ".vdb")) failRead(path, "it is a .vdb already", Remedy::isVolumeAlready);
    failRead(path, std::string("it is of no kind that is known (") + kKnown + ")", Remedy::describeSamples);
}

/// Files in a folder, hidden ones left out, in natural order.
std::vector<std::string> filesIn(const std::string& folder) {
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename().string()[0] != '.')
            files.push_back(entry.path().string());
    std::sort(files.begin(), files.end(), naturallyBefore);
    return files;
}

/// Files of one kind, in natural order.
struct VolumeFiles {
    Kind kind = Kind::unknown;
    std::vector<std::string> files;
};

/// Those of `files` that make the folder's volume: its DICOM images if there are any, else its pictures.
VolumeFiles volumeIn(const std::string& folder, const std::vector<std::string>& files) {
    std::vector<std::string> dicom, pictures, volumes;
    std::set<std::string> extensions;
    for (const std::string& file : files) {
        const Kind kind = kindOf(file);
        if (kind == Kind::dicom) dicom.push_back(file);
        if (kind == Kind::picture) pictures.push_back(file), extensions.insert(lowerCase(fs::path(file).extension()));
        if (kind == Kind::nrrd || kind == Kind::metaImage || kind == Kind::nifti) volumes.push_back(file);
    }
    if (!dicom.empty()) return {Kind::dicom, dicom};
    if (extensions.size() > 1)
        failRead(folder, "the folder has pictures of several kinds (" + *extensions.begin() + ", " +
                             *extensions.rbegin() + "); give those that make the volume");
    if (!pictures.empty()) return {Kind::picture, pictures};
    if (!volumes.empty()) failRead(folder, "it is a folder; give the file in it, '" + volumes.front() + "'");
    failRead(folder, "the folder has no DICOM images and no pictures (TIFF, PNG), but " +
                         (files.empty() ? "no files at all"
                                        : std::to_string(files.size()) + " other file" + (files.size() > 1 ? "s" : "") +
                                              ", such as '" + fs::path(files.front()).filename().string() + "'"));
}

/// All must be of the same kind.
VolumeFiles volumeOf(std::vector<std::string> files) {
    std::sort(files.begin(), files.end(), naturallyBefore);
    Kind kind = Kind::unknown;
    for (const std::string& file : files) {
        if (fs::is_directory(file)) failRead(file, "it is a folder; give files, or one folder");
        requireRegularFile(file);
        const Kind own = kindOf(file);
        if (own == Kind::unknown) failUnknown(file);
        if (kind == Kind::unknown) kind = own;
        if (own != kind)
            throw InvalidArgument("'" + files.front() + "' and '" + file +
                                  "' are of different kinds; several files must be pictures, or DICOM images");
    }
    if (files.size() > 1 && kind != Kind::picture && kind != Kind::dicom)
        throw InvalidArgument("'" + files[1] +
                              "': only pictures and DICOM images make one volume of several files; "
                              "import the others one by one");
    return {kind, std::move(files)};
}

}  // namespace

StoredVolume readVolumeFiles(const std::vector<std::string>& given, const VolumeRequest& request,
                             const ProgressCallback& progress) {
    const bool folder = given.size() == 1 && fs::is_directory(given.front());
    const auto [kind, files] = folder ? volumeIn(given.front(), filesIn(given.front())) : volumeOf(given);
    for (const std::string& file : files) noteInput(file);
    if (!request.series.empty() && kind != Kind::dicom)
        throw InvalidArgument("a series can be chosen from DICOM images only, and '" + files.front() + "' is none");
    switch (kind) {
        case Kind::nrrd:
            return readNrrd(files.front(), request.choice, progress);
        case Kind::metaImage:
            return readMetaImage(files.front(), request.choice, progress);
        case Kind::nifti:
            return readNifti(files.front(), request.choice, progress);
        case Kind::dicom:
            return readDicomSeries(files, {request.series, request.positions, request.choice}, progress);
        case Kind::picture:
            return readPictures(files, request.choice, progress);
        case Kind::unknown:
            break;
    }
    failUnknown(files.front());
}

}  // namespace raysweep
