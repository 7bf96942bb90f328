/// Where photographs were taken from, as files say it.
#pragma once

#include "raysweep/camera/camera.h"
#include "raysweep/camera/photo_camera.h"
#include "raysweep/core/types.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// How the three axes of a pose lie to the picture. The x axis points to its right either way.
enum class CameraAxes {
    openGl,  ///< y up, the camera looks along -z: NeRF, Nerfstudio, Blender
    openCv   ///< y down, the camera looks along +z: COLMAP, projection matrices
};

/// A picture and where it was taken from.
struct Pose {
    std::string image;    ///< file
    std::string mask;     ///< file of a picture that is bright where the object is; empty: none
    std::string onWhite;  ///< file of the same view before a white backdrop; empty: none
    std::string onBlack;  ///< before a black one
    PhotoCamera camera;
};

struct Poses {
    std::vector<Pose> views;
    std::vector<Vec3> points;    ///< what the program that found the poses saw in several pictures, world units; may
                                 ///< hold the object's surroundings and blunders
    std::optional<Box3> bounds;  ///< of the object, if the file says so
    CameraAxes axes = CameraAxes::openCv;  ///< as which the file's were taken
};

struct PoseOptions {
    std::string imageFolder;         ///< where pictures are looked for first; empty: where the file says
    std::optional<CameraAxes> axes;  ///< of the file; as its format has them, if not given
};

/// Reads one of these, by what is in it:
/// - transforms.json of NeRF, instant-ngp and Nerfstudio, and what `writeTransforms` writes;
/// - COLMAP's models as text or binary: the folder, a file of it, or a folder with sparse/0 in it;
/// - Middlebury's lists: a line with the number of pictures, then in each "name K R t" by rows, projection K [R t];
/// - lists of projection matrices, "name P" by rows in each line.
/// The latter two are taken to have integers in the middle of pixels, as OpenCV and Matlab's tools do, so half a pixel
/// is added (their formats do not say it, and Middlebury's calibration is no better than a pixel); the others have them
/// at edges, as this library does. A picture's size is read from itself where the file has none.
/// @throw IoError that names file, line or frame, and what to do, if there is no pose, a picture is missing or named
/// twice, a model is not known (fisheye lenses), or a rotation is none (to 1e-3).
Poses readPoses(const std::string& path, const PoseOptions& options = {});

/// Writes a transforms.json; reading it again gives the same bits (`axes` aside, which are always OpenGL's). Pictures
/// are named relative to its folder. What Nerfstudio's files do not know: "camera_model": "ORTHOGRAPHIC" with fl_x and
/// fl_y in pixels per world unit, "bounds": [[x,y,z],[x,y,z]], "points": [[x,y,z],...], and in frames
/// "file_path_white" and "file_path_black".
/// @throw InvalidArgument if a camera is invalid or there is none. @throw IoError if the file cannot be written.
void writeTransforms(const std::string& path, const Poses& poses);

/// `camera` for a picture of another size: what was found in large pictures serves for the same ones made smaller.
/// @param name of the picture, for messages
/// @throw InvalidArgument unless the sizes have one ratio: a picture that was cropped is not meant.
PhotoCamera matchedTo(const PhotoCamera& camera, int width, int height, const std::string& name);

/// The poses as if the file's axes had been `axes`.
Poses withConvention(const Poses& poses, CameraAxes axes);

}  // namespace raysweep
