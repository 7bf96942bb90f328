#include "raysweep/camera/projection_matrices.h"

#include "raysweep/camera/camera_axes.h"
#include "raysweep/camera/text_lines.h"
#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"

#include <cmath>

namespace raysweep {
namespace {

using Rows = std::array<Vec3, 3>;

/// In the files 0 is the middle of the first pixel, here its edge.
constexpr double kHalfPixel = 0.5;

/// Largest skew over focal length: at the edge of a picture of 50 degrees it moves what is seen by a 20000th of the
/// picture's size.
constexpr double kLargestSkew = 1e-4;

/// The camera that K describes; K's lower right corner is 1.
PhotoCamera cameraOf(const Rows& k, const std::string& image) {
    if (!(std::abs(k[0].y) <= kLargestSkew * std::abs(k[0].x)))
        throw IoError("its pixels are skewed (by " + brief(k[0].y) + " at a focal length of " + brief(k[0].x, 4) +
                      "); only right angles between rows and columns are known");
    const PictureSize size = pictureSize(image);
    PhotoCamera camera;
    camera.width = size.width;
    camera.height = size.height;
    camera.focalX = k[0].x;
    camera.focalY = k[1].y;
    camera.principalX = k[0].z + kHalfPixel;
    camera.principalY = k[1].z + kHalfPixel;
    return camera;
}

/// K, with R's rows and t: the point X is seen at K (R X + t).
struct Calibration {
    Rows k, rotation;
    Vec3 translation;
};

Calibration calibrationOf(const std::vector<double>& numbers) {
    const auto row = [&](std::size_t at) { return Vec3(numbers[at], numbers[at + 1], numbers[at + 2]); };
    Calibration c{{row(0), row(3), row(6)}, {row(9), row(12), row(15)}, row(18)};
    if (c.k[1].x != 0 || c.k[2].x != 0 || c.k[2].y != 0 || c.k[2].z == 0)
        throw IoError("K must be an upper triangle, fx s cx 0 fy cy 0 0 1");
    for (Vec3& k : c.k) k = k / numbers[8];
    return c;
}

/// K R = M by Gram and Schmidt from the last row on, with the sign of M that makes it a rotation.
Calibration decomposed(const std::vector<double>& p) {
    const auto row = [&](std::size_t n) { return Vec3(p[4 * n], p[4 * n + 1], p[4 * n + 2]); };
    Rows m = {row(0), row(1), row(2)};
    Vec3 last(p[3], p[7], p[11]);
    double determinant = m[0].dot(m[1].cross(m[2]));
    if (!(std::abs(determinant) > 1e-12 * m[0].length() * m[1].length() * m[2].length()))
        throw IoError("its matrix is no perspective camera's: the left 3x3 part has no inverse");
    if (determinant < 0) {
        for (Vec3& r : m) r = -r;
        last = -last;
        determinant = -determinant;
    }
    Calibration c;
    const double scale = m[2].length();
    c.rotation[2] = m[2] / scale;
    const double m13 = m[1].dot(c.rotation[2]);
    const Vec3 second = m[1] - c.rotation[2] * m13;
    c.rotation[1] = second.normalized();
    const double m02 = m[0].dot(c.rotation[1]), m03 = m[0].dot(c.rotation[2]);
    const Vec3 first = m[0] - c.rotation[1] * m02 - c.rotation[2] * m03;
    c.rotation[0] = first.normalized();
    c.k = {Vec3(first.length(), m02, m03) / scale, Vec3(0, second.length(), m13) / scale, Vec3(0, 0, 1)};
    const Vec3 position =
        -(m[1].cross(m[2]) * last.x + m[2].cross(m[0]) * last.y + m[0].cross(m[1]) * last.z) / determinant;
    for (int n = 0; n < 3; ++n) c.translation[n] = -c.rotation[std::size_t(n)].dot(position);
    return c;
}

Pose poseOf(const std::string& name, const Calibration& c, const PictureFolders& folders, CameraAxes axes) {
    Pose pose;
    pose.image = findPicture(folders, name);
    pose.camera = cameraOf(c.k, pose.image);
    setWorldToCamera(pose.camera, c.rotation, c.translation, axes);
    pose.camera.validate();
    return pose;
}

/// Of lines with a name and numbers. @param calibration function of the numbers
template <class OfNumbers>
Poses posesOf(const std::vector<TextLine>& lines, std::size_t count, const OfNumbers& calibration,
              const PictureFolders& folders, CameraAxes axes) {
    Poses poses;
    poses.axes = axes;
    for (const TextLine& line : lines) {
        const std::vector<std::string> words = wordsOf(line.text);
        try {
            if (words.size() != count + 1)
                throw IoError("there are " + std::to_string(words.size()) + " words, not a name and " +
                              std::to_string(count) + " numbers");
            std::vector<double> numbers;
            for (std::size_t n = 1; n <= count; ++n) numbers.push_back(numberOf(words[n]));
            poses.views.push_back(poseOf(words[0], calibration(numbers), folders, axes));
        } catch (const Error& error) {
            throw IoError("line " + std::to_string(line.number) + " ('" + words[0] + "'): " + error.what());
        }
    }
    return poses;
}

}  // namespace

Poses posesFromMiddlebury(const std::string& text, const PictureFolders& folders, CameraAxes axes) {
    std::vector<TextLine> lines = meantLinesOf(text);
    if (lines.empty()) throw IoError("there is nothing in it");
    const long long count = countOf(wordsOf(lines[0].text)[0]);
    lines.erase(lines.begin());
    if (count != (long long)lines.size())
        throw IoError("its first line says " + std::to_string(count) + " pictures, but there are " +
                      std::to_string(lines.size()) + " lines of them; was it cut?");
    return posesOf(lines, 21, calibrationOf, folders, axes);
}

Poses posesFromProjections(const std::string& text, const PictureFolders& folders, CameraAxes axes) {
    return posesOf(meantLinesOf(text), 12, decomposed, folders, axes);
}

}  // namespace raysweep
