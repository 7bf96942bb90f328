#include "raysweep/camera/poses.h"

#include "raysweep/camera/colmap.h"
#include "raysweep/camera/picture_folders.h"
#include "raysweep/camera/projection_matrices.h"
#include "raysweep/camera/text_lines.h"
#include "raysweep/camera/transforms_json.h"
#include "raysweep/core/error.h"
#include "raysweep/core/finite.h"
#include "raysweep/core/text_file.h"

#include <filesystem>
#include <map>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

constexpr const char* kGivePoses =
    "a transforms.json, a folder with a model of COLMAP's, a list of cameras of Middlebury's (_par.txt), or a list of "
    "projection matrices (a name and 12 numbers in each line)";

bool isFolder(const fs::path& path) {
    std::error_code ignored;
    return fs::is_directory(path, ignored);
}

/// The file or model's folder that is meant by a folder.
fs::path fileIn(const fs::path& folder) {
    for (const char* name : {"transforms.json", "transforms_train.json"})
        if (fs::is_regular_file(folder / name)) return folder / name;
    for (const char* name : {"", "sparse/0", "sparse", "colmap/sparse/0"})
        if (isColmapModel((folder / name).string())) return folder / name;
    std::vector<fs::path> lists;
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string(), end = "_par.txt";
        if (name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0)
            lists.push_back(entry.path());
    }
    if (lists.size() == 1) return lists[0];
    throw IoError(std::string(lists.empty() ? "there are no poses in this folder" : "there are several lists in it") +
                  "; give " + kGivePoses);
}

/// True for the files that a model of COLMAP's is made of.
bool isOfColmap(const fs::path& file) {
    const std::string stem = file.stem().string(), extension = file.extension().string();
    return (stem == "cameras" || stem == "images" || stem == "points3D") &&
           (extension == ".txt" || extension == ".bin") && isColmapModel(file.parent_path().string());
}

Poses posesOfText(const std::string& text, const PictureFolders& folders, const std::optional<CameraAxes>& axes) {
    const std::size_t start = text.find_first_not_of(kBlanks);
    if (start == std::string::npos) throw IoError("there is nothing in it; give " + std::string(kGivePoses));
    if (text.find('\0') != std::string::npos) throw IoError("it is no text; give " + std::string(kGivePoses));
    if (text[start] == '{') return posesFromTransforms(text, folders, axes.value_or(CameraAxes::openGl));
    const std::vector<TextLine> lines = meantLinesOf(text);
    const std::size_t words = lines.empty() ? 0 : wordsOf(lines[0].text).size();
    if (words == 1) return posesFromMiddlebury(text, folders, axes.value_or(CameraAxes::openCv));
    if (words == 13) return posesFromProjections(text, folders, axes.value_or(CameraAxes::openCv));
    throw IoError("what it is was not recognised; give " + std::string(kGivePoses));
}

Poses posesAt(const std::string& path, const PoseOptions& options) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw IoError("there is no such file; give " + std::string(kGivePoses));
    if (!options.imageFolder.empty() && !isFolder(options.imageFolder))
        throw IoError("the folder of its pictures, '" + options.imageFolder + "', does not exist");
    const fs::path file = isFolder(path) ? fileIn(path) : fs::path(path);
    PictureFolders folders{options.imageFolder, {}};
    if (isFolder(file) || isOfColmap(file)) {
        const fs::path folder = isFolder(file) ? file : file.parent_path();
        return readColmap(folder.empty() ? "." : folder.string(), folders, options.axes.value_or(CameraAxes::openCv));
    }
    folders.folders = {file.parent_path().string()};
    return posesOfText(bytesOfFile(file.string(), kGivePoses), folders, options.axes);
}

void requireViews(const Poses& poses) {
    if (poses.views.empty()) throw IoError("it has no pictures; give " + std::string(kGivePoses));
    std::map<std::string, std::size_t> seen;
    for (std::size_t n = 0; n < poses.views.size(); ++n) {
        const auto [known, isNew] = seen.emplace(poses.views[n].image, n);
        if (!isNew)
            throw IoError("the picture '" + poses.views[n].image + "' is there twice, as views " +
                          std::to_string(known->second) + " and " + std::to_string(n) +
                          " (counted from 0); take one of them out");
    }
}

}  // namespace

Poses readPoses(const std::string& path, const PoseOptions& options) {
    try {
        const Poses poses = posesAt(path, options);
        requireViews(poses);
        return poses;
    } catch (const Error& error) {
        throw IoError("cannot read poses from '" + path + "': " + error.what());
    } catch (const fs::filesystem_error& error) {
        throw IoError("cannot read poses from '" + path + "': " + error.what());
    }
}

void writeTransforms(const std::string& path, const Poses& poses) {
    if (poses.views.empty()) throw InvalidArgument("there are no poses to write");
    for (const Pose& pose : poses.views) {
        if (pose.image.empty()) throw InvalidArgument("a pose to write has no picture");
        try {
            pose.camera.validate();
        } catch (const InvalidArgument& error) {
            throw InvalidArgument("the pose of '" + pose.image + "': " + error.what());
        }
    }
    for (const Vec3& point : poses.points)
        if (!isFinite(point)) throw InvalidArgument("a point to write with poses is not finite");
    writeText(path, transformsOf(poses, fs::path(path).parent_path().string()));
}

PhotoCamera matchedTo(const PhotoCamera& camera, int width, int height, const std::string& name) {
    const auto size = [](int w, int h) { return std::to_string(w) + "x" + std::to_string(h); };
    if ((long long)width * camera.height != (long long)height * camera.width)
        throw InvalidArgument("the picture '" + name + "' has " + size(width, height) + " pixels, but its camera " +
                              size(camera.width, camera.height) +
                              ", which is no multiple: was it cropped or turned? Give the pictures that the poses "
                              "were found with, or these scaled evenly");
    return width == camera.width ? camera : resized(camera, width, height);
}

Poses withConvention(const Poses& poses, CameraAxes axes) {
    Poses other = poses;
    if (poses.axes == axes) return other;
    other.axes = axes;
    for (Pose& pose : other.views) {
        pose.camera.down = -pose.camera.down;
        pose.camera.forward = -pose.camera.forward;
    }
    return other;
}

}  // namespace raysweep
