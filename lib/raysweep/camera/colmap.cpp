#include "raysweep/camera/colmap.h"

#include "raysweep/camera/camera_axes.h"
#include "raysweep/camera/text_lines.h"
#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"
#include "raysweep/core/natural_order.h"
#include "raysweep/core/text_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

/// A camera model: its name in text, its number in binary files, its count of parameters.
struct Model {
    const char* name;
    int number;
    std::size_t parameters;  ///< 0: not known here
};

constexpr Model kModels[] = {
    {"SIMPLE_PINHOLE", 0, 3},
    {"PINHOLE", 1, 4},
    {"SIMPLE_RADIAL", 2, 4},
    {"RADIAL", 3, 5},
    {"OPENCV", 4, 8},
    {"OPENCV_FISHEYE", 5, 0},
    {"FULL_OPENCV", 6, 0},
    {"FOV", 7, 0},
    {"SIMPLE_RADIAL_FISHEYE", 8, 0},
    {"RADIAL_FISHEYE", 9, 0},
    {"THIN_PRISM_FISHEYE", 10, 0},
    {"RAD_TAN_THIN_PRISM_FISHEYE", 11, 0},
};

using Cameras = std::map<long long, PhotoCamera>;

/// A picture of the model: which camera took it, and from where (world to camera).
struct ColmapImage {
    std::array<double, 4> quaternion;  ///< w, x, y, z
    Vec3 translation;
    long long camera;
    std::string name;
};

const Model& requireKnown(const Model* model, const std::string& name) {
    if (model && model->parameters > 0) return *model;
    throw IoError("the camera model " + name +
                  " is not known; known are SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV: let COLMAP "
                  "undistort the pictures");
}

const Model& modelNamed(const std::string& name) {
    const auto found =
        std::find_if(std::begin(kModels), std::end(kModels), [&](const Model& m) { return m.name == name; });
    return requireKnown(found == std::end(kModels) ? nullptr : found, name);
}

const Model& modelNumbered(int number) {
    const auto found =
        std::find_if(std::begin(kModels), std::end(kModels), [&](const Model& m) { return m.number == number; });
    if (found == std::end(kModels)) return requireKnown(nullptr, "of number " + std::to_string(number));
    return requireKnown(found, found->name);
}

/// Pixel coordinates are COLMAP's own: 0 is the picture's edge.
PhotoCamera cameraOf(const Model& model, long long width, long long height, const std::vector<double>& p) {
    constexpr long long kLargest = std::numeric_limits<int>::max();
    if (width <= 0 || height <= 0 || width > kLargest || height > kLargest)
        throw IoError("a picture of " + std::to_string(width) + "x" + std::to_string(height) + " pixels");
    const bool twoFocals = model.number == 1 || model.number == 4;
    const std::size_t rest = twoFocals ? 4 : 3;
    PhotoCamera camera;
    camera.width = int(width);
    camera.height = int(height);
    camera.focalX = p[0];
    camera.focalY = p[twoFocals ? 1 : 0];
    camera.principalX = p[rest - 2];
    camera.principalY = p[rest - 1];
    if (p.size() > rest) camera.distortion.k1 = p[rest];
    if (p.size() > rest + 1) camera.distortion.k2 = p[rest + 1];
    if (p.size() > rest + 3) camera.distortion.p1 = p[rest + 2], camera.distortion.p2 = p[rest + 3];
    camera.validate();
    return camera;
}

void addCamera(Cameras& cameras, long long id, const PhotoCamera& camera) {
    if (!cameras.emplace(id, camera).second) throw IoError("it is there twice");
}

/// Calls `body`; its errors say where.
template <class Body>
void within(const std::string& where, const Body& body) {
    try {
        body();
    } catch (const Error& error) {
        throw IoError(where + ": " + error.what());
    }
}

void requireWords(const std::vector<std::string>& words, std::size_t least, const char* what) {
    if (words.size() < least) throw IoError("it has " + std::to_string(words.size()) + " words, but should be " + what);
}

Cameras camerasFromText(const std::string& text) {
    Cameras cameras;
    for (const TextLine& line : meantLinesOf(text))
        within("line " + std::to_string(line.number), [&] {
            const std::vector<std::string> words = wordsOf(line.text);
            requireWords(words, 4, "CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]");
            const Model& model = modelNamed(words[1]);
            if (words.size() != 4 + model.parameters)
                throw IoError("the model " + words[1] + " has " + std::to_string(model.parameters) +
                              " parameters, but there are " + std::to_string(words.size() - 4));
            std::vector<double> parameters;
            for (std::size_t n = 4; n < words.size(); ++n) parameters.push_back(numberOf(words[n]));
            addCamera(cameras, countOf(words[0]), cameraOf(model, countOf(words[2]), countOf(words[3]), parameters));
        });
    return cameras;
}

/// What is left of `text` behind so many words: names may have spaces in them.
std::string behindWords(const std::string& text, int words) {
    std::size_t at = text.find_first_not_of(kBlanks);
    for (int n = 0; n < words; ++n) at = text.find_first_not_of(kBlanks, text.find_first_of(kBlanks, at));
    return text.substr(at, text.find_last_not_of(kBlanks) + 1 - at);
}

ColmapImage imageOf(const std::string& line) {
    const std::vector<std::string> words = wordsOf(line);
    requireWords(words, 10, "IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME");
    const auto number = [&](std::size_t n) { return numberOf(words[n]); };
    return {{number(1), number(2), number(3), number(4)},
            Vec3(number(5), number(6), number(7)),
            countOf(words[8]),
            behindWords(line, 9)};
}

/// Two lines for each picture, of which the second, what it shows of the points, may be empty.
std::vector<ColmapImage> imagesFromText(const std::string& text) {
    std::vector<ColmapImage> images;
    bool isSecond = false;
    for (const TextLine& line : linesOf(text)) {
        const std::vector<std::string> words = wordsOf(line.text);
        if (!isSecond && (words.empty() || words[0][0] == '#')) continue;
        within("line " + std::to_string(line.number), [&] {
            if (!isSecond)
                images.push_back(imageOf(line.text));
            else if (words.size() % 3 != 0)
                throw IoError("the points of '" + images.back().name +
                              "' should be here, three numbers for each; the line may be empty, but not missing");
        });
        isSecond = !isSecond;
    }
    return images;
}

std::vector<Vec3> pointsFromText(const std::string& text) {
    std::vector<Vec3> points;
    for (const TextLine& line : meantLinesOf(text))
        within("line " + std::to_string(line.number), [&] {
            const std::vector<std::string> words = wordsOf(line.text);
            requireWords(words, 8, "POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]");
            points.emplace_back(numberOf(words[1]), numberOf(words[2]), numberOf(words[3]));
        });
    return points;
}

/// Values of a binary file, one behind the other; COLMAP's byte order and that of all machines this runs on is little
/// endian.
class Bytes {
  public:
    explicit Bytes(const std::string& bytes) : bytes_(bytes) {}

    template <class Value>
    Value take() {
        Value value;
        std::memcpy(&value, bytes_.data() + skip(sizeof value), sizeof value);
        return value;
    }
    double number() {
        const double value = take<double>();
        if (!std::isfinite(value)) throw IoError("a number is not finite; the file is damaged");
        return value;
    }
    std::string text() {
        const std::size_t end = bytes_.find('\0', at_);
        if (end == std::string::npos) skip(bytes_.size());
        const std::string value = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        return value;
    }
    /// @return where what is skipped begins
    std::size_t skip(std::uint64_t count, std::uint64_t size = 1) {
        if (count > (bytes_.size() - at_) / size)
            throw IoError("the file ends early, at byte " + std::to_string(bytes_.size()) + "; copy it again");
        at_ += std::size_t(count * size);
        return at_ - std::size_t(count * size);
    }
    /// Calls `body(n)` as often as the file says, for things that are called `what`; nothing may be left.
    template <class Body>
    void each(const char* what, const Body& body) {
        const auto count = take<std::uint64_t>();
        for (std::uint64_t n = 0; n < count; ++n)
            within(std::string(what) + " " + std::to_string(n + 1) + " of " + std::to_string(count), [&] { body(); });
        if (at_ < bytes_.size())
            throw IoError(std::to_string(bytes_.size() - at_) + " bytes are left over behind " + std::to_string(count) +
                          " of " + what + "; the file is damaged, or of another version");
    }

  private:
    const std::string& bytes_;
    std::size_t at_ = 0;
};

Cameras camerasFromBinary(const std::string& file) {
    Cameras cameras;
    Bytes bytes(file);
    bytes.each("camera", [&] {
        const auto id = bytes.take<std::uint32_t>();
        const Model& model = modelNumbered(bytes.take<std::int32_t>());
        const auto width = bytes.take<std::int64_t>(), height = bytes.take<std::int64_t>();
        std::vector<double> parameters(model.parameters);
        for (double& parameter : parameters) parameter = bytes.number();
        addCamera(cameras, id, cameraOf(model, width, height, parameters));
    });
    return cameras;
}

std::vector<ColmapImage> imagesFromBinary(const std::string& file) {
    constexpr std::uint64_t kPoint2D = 2 * sizeof(double) + sizeof(std::int64_t);
    std::vector<ColmapImage> images;
    Bytes bytes(file);
    bytes.each("image", [&] {
        ColmapImage image;
        bytes.take<std::uint32_t>();  // its number
        for (double& q : image.quaternion) q = bytes.number();
        for (int axis = 0; axis < 3; ++axis) image.translation[axis] = bytes.number();
        image.camera = bytes.take<std::uint32_t>();
        image.name = bytes.text();
        bytes.skip(bytes.take<std::uint64_t>(), kPoint2D);
        images.push_back(image);
    });
    return images;
}

std::vector<Vec3> pointsFromBinary(const std::string& file) {
    constexpr std::uint64_t kTrack = 2 * sizeof(std::uint32_t);
    std::vector<Vec3> points;
    Bytes bytes(file);
    bytes.each("point", [&] {
        bytes.take<std::uint64_t>();  // its number
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis) point[axis] = bytes.number();
        bytes.skip(3);         // colour
        bytes.take<double>();  // error; NaN where it was not computed
        bytes.skip(bytes.take<std::uint64_t>(), kTrack);
        points.push_back(point);
    });
    return points;
}

/// The rows of the rotation: the camera's axes in world space.
FileAxes axesOf(const std::array<double, 4>& quaternion) {
    double norm = 0;
    for (const double q : quaternion) norm += q * q;
    norm = std::sqrt(norm);
    if (!(std::abs(norm - 1) <= 1e-3))
        throw IoError("the quaternion of its rotation has the length " + brief(norm, 4) + ", not 1");
    const double w = quaternion[0] / norm, x = quaternion[1] / norm, y = quaternion[2] / norm, z = quaternion[3] / norm;
    return {Vec3(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            Vec3(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            Vec3(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))};
}

Pose poseOf(const ColmapImage& image, const Cameras& cameras, const PictureFolders& pictures, CameraAxes convention) {
    const auto camera = cameras.find(image.camera);
    if (camera == cameras.end())
        throw IoError("its camera " + std::to_string(image.camera) + " is not among the model's cameras");
    Pose pose;
    pose.camera = camera->second;
    setWorldToCamera(pose.camera, axesOf(image.quaternion), image.translation, convention);
    pose.image = findPicture(pictures, image.name);
    return pose;
}

template <class Parse>
auto parsedFile(const std::string& path, const Parse& parse) {
    try {
        return parse(bytesOfFile(path, "a file of COLMAP's"));
    } catch (const Error& error) {
        throw IoError("'" + path + "': " + error.what());
    }
}

bool isFile(const std::string& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
}

}  // namespace

bool isColmapModel(const std::string& folder) {
    for (const char* extension : {".bin", ".txt"})
        if (isFile(folder + "/cameras" + extension) && isFile(folder + "/images" + extension)) return true;
    return false;
}

Poses readColmap(const std::string& folder, const PictureFolders& pictures, CameraAxes axes) {
    const bool binary = isFile(folder + "/cameras.bin") && isFile(folder + "/images.bin");
    const std::string extension = binary ? ".bin" : ".txt", pointFile = folder + "/points3D" + extension;
    const Cameras cameras = parsedFile(folder + "/cameras" + extension, binary ? camerasFromBinary : camerasFromText);
    auto images = parsedFile(folder + "/images" + extension, binary ? imagesFromBinary : imagesFromText);
    std::sort(images.begin(), images.end(),
              [](const ColmapImage& a, const ColmapImage& b) { return naturallyBefore(a.name, b.name); });
    PictureFolders all = pictures;
    for (const char* place : {"/images", "/../images", "/../../images", ""}) all.folders.push_back(folder + place);
    Poses poses;
    poses.axes = axes;
    for (const ColmapImage& image : images)
        within("'" + folder + "/images" + extension + "', picture '" + image.name + "'",
               [&] { poses.views.push_back(poseOf(image, cameras, all, axes)); });
    if (isFile(pointFile)) poses.points = parsedFile(pointFile, binary ? pointsFromBinary : pointsFromText);
    return poses;
}

}  // namespace raysweep
