#include "raysweep/formats/volume_files.h"

#include "raysweep/core/error.h"
#include "raysweep/core/natural_order.h"
#include "raysweep/formats/itk_volume.h"
#include "raysweep/image/image_io.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

enum class Kind { unknown, nrrd, metaImage, nifti, dicom, picture };

const char* const kKnown = "NRRD, MetaImage, NIfTI, DICOM, TIFF, PNG";

[[noreturn]] void failRead(const std::string& path, const std::string& why, Remedy remedy = Remedy::none) {
    throw IoError("cannot read '" + path + "': " + why, remedy);
}

std::string lower(std::string text) {
    for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// True if the file starts as DICOM files do.
bool hasDicomMark(const std::string& path) {
    char start[132] = {};
    std::ifstream in(path, std::ios::binary);
    return in.read(start, sizeof start) && std::memcmp(start + 128, "DICM", 4) == 0;
}

Kind kindOf(const std::string& path) {
    const std::string name = lower(path);
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
    const std::string name = lower(path);
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

/// Those of `files` that make the folder's volume: its DICOM images if there are any, else its pictures.
std::vector<std::string> volumeIn(const std::string& folder, const std::vector<std::string>& files) {
    std::vector<std::string> dicom, pictures, volumes;
    std::set<std::string> extensions;
    for (const std::string& file : files) {
        const Kind kind = kindOf(file);
        if (kind == Kind::dicom) dicom.push_back(file);
        if (kind == Kind::picture) pictures.push_back(file), extensions.insert(lower(fs::path(file).extension()));
        if (kind == Kind::nrrd || kind == Kind::metaImage || kind == Kind::nifti) volumes.push_back(file);
    }
    if (!dicom.empty()) return dicom;
    if (extensions.size() > 1)
        failRead(folder, "the folder has pictures of several kinds (" + *extensions.begin() + ", " +
                             *extensions.rbegin() + "); give those that make the volume");
    if (!pictures.empty()) return pictures;
    if (!volumes.empty()) failRead(folder, "it is a folder; give the file in it, '" + volumes.front() + "'");
    failRead(folder, "the folder has no DICOM images and no pictures (TIFF, PNG), but " +
                         (files.empty() ? "no files at all"
                                        : std::to_string(files.size()) + " other file" + (files.size() > 1 ? "s" : "") +
                                              ", such as '" + fs::path(files.front()).filename().string() + "'"));
}

StoredVolume readPictures(const std::vector<std::string>& files, const ProgressCallback& progress) {
    PictureStack stack = readPictureStack(files, progress);
    StoredVolume volume;
    volume.dims = Index3(stack.width, stack.height, stack.slices);
    volume.type = stack.type;
    volume.samples = std::move(stack.samples);
    volume.complete = stack.complete;
    volume.format = "pictures";
    return volume;
}

/// All of the same kind, which is returned.
Kind commonKind(const std::vector<std::string>& files) {
    const Kind kind = kindOf(files.front());
    for (const std::string& file : files) {
        if (fs::is_directory(file)) failRead(file, "it is a folder; give files, or one folder");
        if (!fs::exists(file)) failRead(file, "there is no such file");
        const Kind own = kindOf(file);
        if (own == Kind::unknown) failUnknown(file);
        if (own != kind)
            throw InvalidArgument("'" + files.front() + "' and '" + file +
                                  "' are of different kinds; several files must be pictures, or DICOM images");
    }
    if (files.size() > 1 && kind != Kind::picture && kind != Kind::dicom)
        throw InvalidArgument("'" + files[1] +
                              "': only pictures and DICOM images make one volume of several files; "
                              "import the others one by one");
    return kind;
}

}  // namespace

StoredVolume readVolumeFiles(const std::vector<std::string>& given, const std::string& series, bool positions,
                             const ProgressCallback& progress) {
    const bool folder = given.size() == 1 && fs::is_directory(given.front());
    std::vector<std::string> files = folder ? volumeIn(given.front(), filesIn(given.front())) : given;
    std::sort(files.begin(), files.end(), naturallyBefore);
    const Kind kind = commonKind(files);
    if (!series.empty() && kind != Kind::dicom)
        throw InvalidArgument("a series can be chosen from DICOM images only, and '" + files.front() + "' is none");
    switch (kind) {
        case Kind::nrrd:
            return readItkVolume(files.front(), ItkFormat::nrrd, progress);
        case Kind::metaImage:
            return readItkVolume(files.front(), ItkFormat::metaImage, progress);
        case Kind::nifti:
            return readItkVolume(files.front(), ItkFormat::nifti, progress);
        case Kind::dicom:
            return readDicomSeries(files, series, positions, progress);
        case Kind::picture:
            return readPictures(files, progress);
        case Kind::unknown:
            break;
    }
    failUnknown(files.front());
}

}  // namespace raysweep
