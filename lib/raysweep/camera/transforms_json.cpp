#include "raysweep/camera/transforms_json.h"

#include "raysweep/camera/camera_axes.h"
#include "raysweep/core/error.h"
#include "raysweep/core/finite.h"
#include "raysweep/core/json_fields.h"
#include "raysweep/image/image_io.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

/// What Nerfstudio and COLMAP call cameras whose lens is that of `Distortion`.
const std::set<std::string> kPerspectiveModels = {"OPENCV", "PINHOLE",     "SIMPLE_PINHOLE", "SIMPLE_RADIAL",
                                                  "RADIAL", "PERSPECTIVE", "pinhole",        "perspective"};
constexpr const char* kOrthographic = "ORTHOGRAPHIC";

/// A frame's fields, and those of the file, which hold for all frames that have none of their own.
struct FrameFields {
    JsonFields& frame;
    JsonFields& file;

    /// Which of the two has it; null if neither.
    JsonFields* find(const std::string& key) { return frame.has(key) ? &frame : file.has(key) ? &file : nullptr; }
    std::optional<double> number(const std::string& key) {
        JsonFields* const fields = find(key);
        return fields ? std::optional(fields->number(key)) : std::nullopt;
    }
    /// A number of pixels; instant-ngp writes them with a point. 0 if there is none.
    int pixels(const std::string& key) {
        const double value = number(key).value_or(0);
        if (!(value >= 0 && value <= std::numeric_limits<int>::max() && value == std::floor(value)))
            find(key)->fail(key, "a whole number of pixels");
        return int(value);
    }
};

/// Half the picture's edge over the tangent of half the angle that it is seen under.
double focalOf(FrameFields& fields, const std::string& key, int pixels) {
    const double angle = *fields.number(key);
    if (!(angle > 0 && angle < kPi)) fields.find(key)->fail(key, "an angle between 0 and pi (radians)");
    return 0.5 * pixels / std::tan(0.5 * angle);
}

void setLens(PhotoCamera& camera, FrameFields& fields) {
    const JsonFields* const withModel = fields.find("camera_model");
    const std::string model = withModel ? fields.find("camera_model")->text("camera_model") : "OPENCV";
    if (model != kOrthographic && !kPerspectiveModels.count(model))
        throw IoError("the camera model '" + model +
                      "' is not known; known are OPENCV, PINHOLE, SIMPLE_PINHOLE and ORTHOGRAPHIC: undistort the "
                      "pictures first");
    if (model == kOrthographic) camera.projection = Camera::Projection::Orthographic;
    JsonFields* const fisheye = fields.find("is_fisheye");
    if (fisheye && fisheye->at("is_fisheye") == json(true))
        throw IoError("'is_fisheye' is true, but fisheye lenses are not known; undistort the pictures first");
    for (const char* key : {"k3", "k4", "k5", "k6"})
        if (fields.number(key).value_or(0) != 0)
            throw IoError(
                "the coefficient '" + std::string(key) +
                "' is not 0, but lenses are known with k1, k2, p1 and p2 alone; undistort the pictures first");
    camera.distortion = {fields.number("k1").value_or(0), fields.number("k2").value_or(0),
                         fields.number("p1").value_or(0), fields.number("p2").value_or(0)};
}

/// Size, focal length and principal point. What is missing follows from square pixels and the picture's middle.
void setIntrinsics(PhotoCamera& camera, FrameFields& fields, const std::string& image) {
    camera.width = fields.pixels("w");
    camera.height = fields.pixels("h");
    if (camera.width == 0 || camera.height == 0) {
        const PictureSize size = pictureSize(image);
        camera.width = size.width;
        camera.height = size.height;
    }
    const bool orthographic = camera.projection == Camera::Projection::Orthographic;
    if (const auto focal = fields.number("fl_x"))
        camera.focalX = *focal;
    else if (!orthographic && fields.find("camera_angle_x"))
        camera.focalX = focalOf(fields, "camera_angle_x", camera.width);
    else
        throw IoError(orthographic ? "an orthographic camera needs 'fl_x', its pixels per world unit"
                                   : "it has neither 'fl_x' nor 'camera_angle_x', nor has the file: one is needed");
    if (const auto focal = fields.number("fl_y"))
        camera.focalY = *focal;
    else if (!orthographic && !fields.find("fl_x") && fields.find("camera_angle_y"))
        camera.focalY = focalOf(fields, "camera_angle_y", camera.height);
    else
        camera.focalY = camera.focalX;
    camera.principalX = fields.number("cx").value_or(0.5 * camera.width);
    camera.principalY = fields.number("cy").value_or(0.5 * camera.height);
}

Vec3 vectorOf(const json& array, const char* what) {
    const auto isNumber = [&](std::size_t n) { return array[n].is_number(); };
    if (!array.is_array() || array.size() != 3 || !isNumber(0) || !isNumber(1) || !isNumber(2))
        throw IoError(std::string(what) + " must be an array of three numbers");
    return Vec3(array[0].get<double>(), array[1].get<double>(), array[2].get<double>());
}

/// Camera to world, by rows.
void setPose(PhotoCamera& camera, JsonFields& frame, CameraAxes convention) {
    const json& rows = frame.at("transform_matrix");
    bool good = rows.is_array() && (rows.size() == 3 || rows.size() == 4);
    for (std::size_t i = 0; good && i < rows.size(); ++i) {
        good = rows[i].is_array() && rows[i].size() == 4;
        for (std::size_t j = 0; good && j < 4; ++j) good = rows[i][j].is_number();
    }
    if (!good) frame.fail("transform_matrix", "four rows of four numbers");
    if (rows.size() == 4 && rows[3] != json::array({0.0, 0.0, 0.0, 1.0}))
        frame.fail("transform_matrix", "one whose last row is 0, 0, 0, 1");
    const auto column = [&](std::size_t j) {
        return Vec3(rows[0][j].get<double>(), rows[1][j].get<double>(), rows[2][j].get<double>());
    };
    setAxes(camera, {column(0), column(1), column(2)}, convention);
    camera.position = column(3);
}

Pose poseOf(const json& entry, const std::string& name, JsonFields& file, const PictureFolders& folders,
            CameraAxes axes) {
    JsonFields frame(entry, name + ".");
    std::string picture;
    const auto optionalPicture = [&](const char* key) {
        return frame.has(key) ? findPicture(folders, frame.text(key)) : std::string();
    };
    try {
        FrameFields fields{frame, file};
        Pose pose;
        picture = frame.text("file_path");
        pose.image = findPicture(folders, picture);
        pose.mask = optionalPicture("mask_path");
        pose.onWhite = optionalPicture("file_path_white");
        pose.onBlack = optionalPicture("file_path_black");
        setLens(pose.camera, fields);
        setIntrinsics(pose.camera, fields, pose.image);
        setPose(pose.camera, frame, axes);
        pose.camera.validate();
        return pose;
    } catch (const Error& error) {
        throw IoError(name + (picture.empty() ? "" : " ('" + picture + "')") + ": " + error.what());
    }
}

std::optional<Box3> boundsOf(JsonFields& file) {
    for (const char* key : {"bounds", "aabb"}) {
        if (!file.has(key)) continue;
        const json& corners = file.at(key);
        if (!corners.is_array() || corners.size() != 2) file.fail(key, "an array of two corners, [[x,y,z],[x,y,z]]");
        const Box3 box(vectorOf(corners[0], key), vectorOf(corners[1], key));
        if (!isFinite(box.min) || !isFinite(box.max) || !box.hasVolume())
            file.fail(key, "a box: the second corner above the first along every axis");
        return box;
    }
    return std::nullopt;
}

json arrayOf(const Vec3& v) {
    return json::array({v.x, v.y, v.z});
}

ordered_json intrinsicsOf(const PhotoCamera& camera) {
    ordered_json object;
    const bool orthographic = camera.projection == Camera::Projection::Orthographic;
    object["camera_model"] = orthographic ? kOrthographic : camera.distortion.isNone() ? "PINHOLE" : "OPENCV";
    object["w"] = camera.width;
    object["h"] = camera.height;
    object["fl_x"] = camera.focalX;
    object["fl_y"] = camera.focalY;
    object["cx"] = camera.principalX;
    object["cy"] = camera.principalY;
    if (camera.distortion.isNone()) return object;
    object["k1"] = camera.distortion.k1;
    object["k2"] = camera.distortion.k2;
    object["p1"] = camera.distortion.p1;
    object["p2"] = camera.distortion.p2;
    return object;
}

json transformOf(const PhotoCamera& camera) {
    json rows = json::array();
    for (int i = 0; i < 3; ++i)
        rows.push_back(json::array({camera.right[i], -camera.down[i], -camera.forward[i], camera.position[i]}));
    rows.push_back(json::array({0.0, 0.0, 0.0, 1.0}));
    return rows;
}

ordered_json frameOf(const Pose& pose, const fs::path& folder) {
    ordered_json frame;
    const auto add = [&](const char* key, const std::string& file) {
        if (!file.empty()) frame[key] = fs::absolute(file).lexically_normal().lexically_proximate(folder).string();
    };
    add("file_path", pose.image);
    add("mask_path", pose.mask);
    add("file_path_white", pose.onWhite);
    add("file_path_black", pose.onBlack);
    frame["transform_matrix"] = transformOf(pose.camera);
    return frame;
}

}  // namespace

Poses posesFromTransforms(const std::string& text, const PictureFolders& folders, CameraAxes axes) {
    const json document = parseJson(text);
    JsonFields file(document, "");
    Poses poses;
    poses.axes = axes;
    poses.bounds = boundsOf(file);
    const json& frames = file.at("frames");
    if (!frames.is_array() || frames.empty()) file.fail("frames", "an array of at least one frame");
    for (const json& entry : frames)
        poses.views.push_back(poseOf(entry, "frames[" + std::to_string(poses.views.size()) + "]", file, folders, axes));
    if (file.has("points")) {
        const json& points = file.at("points");
        if (!points.is_array()) file.fail("points", "an array of points");
        for (const json& point : points) poses.points.push_back(vectorOf(point, "each of 'points'"));
    }
    return poses;
}

std::string transformsOf(const Poses& poses, const std::string& folder) {
    const fs::path base = fs::absolute(folder.empty() ? "." : folder).lexically_normal();
    const ordered_json shared = intrinsicsOf(poses.views.front().camera);
    bool allAlike = true;
    for (const Pose& pose : poses.views) allAlike = allAlike && intrinsicsOf(pose.camera) == shared;
    std::string text = "{\n";
    const auto addFields = [&](const ordered_json& object) {
        for (const auto& item : object.items()) text += "\"" + item.key() + "\": " + item.value().dump() + ",\n";
    };
    if (allAlike) addFields(shared);
    if (poses.bounds) addFields({{"bounds", json::array({arrayOf(poses.bounds->min), arrayOf(poses.bounds->max)})}});
    if (!poses.points.empty()) {
        json points = json::array();
        for (const Vec3& point : poses.points) points.push_back(arrayOf(point));
        addFields({{"points", points}});
    }
    text += "\"frames\": [";
    const char* separator = "\n";
    for (const Pose& pose : poses.views) {
        ordered_json frame = frameOf(pose, base);
        if (!allAlike) frame.update(intrinsicsOf(pose.camera));
        text += separator + frame.dump();
        separator = ",\n";
    }
    return text + "\n]\n}\n";
}

}  // namespace raysweep
