#include "scan_options.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/scan/geometry_io.h"

#include <cmath>

namespace raysweep::apps {
namespace {

constexpr int kMostPixels = 1 << 16;

/// W,H[,PITCH]
struct Detector {
    int width = 0, height = 0;
    std::optional<double> pitch;
};

Detector parseDetector(const std::string& text) {
    const std::vector<double> numbers = parseNumbers(text, "--detector", 2, 3, "384,256,1");
    for (int i = 0; i < 2; ++i)
        if (!(numbers[i] >= 1 && numbers[i] <= kMostPixels) || numbers[i] != std::floor(numbers[i]))
            usageError("--detector", "'" + text + "': columns and rows must be whole numbers of at least 1");
    Detector detector{int(numbers[0]), int(numbers[1]), {}};
    if (numbers.size() == 3) {
        if (!(numbers[2] > 0)) usageError("--detector", "'" + text + "': the pitch must be positive");
        detector.pitch = numbers[2];
    }
    return detector;
}

/// WIDTH[,HEIGHT] of a pixel
DetectorPair parsePitch(const std::string& text) {
    const std::vector<double> numbers = parseNumbers(text, "--pitch", 1, 2, "0.5");
    for (const double number : numbers)
        if (!(number > 0)) usageError("--pitch", "'" + text + "': must be positive");
    return {numbers.front(), numbers.back()};
}

CircularOrbit orbitOf(const ScanArguments& a, const MeasuredScan* measured, const Vec3& center) {
    CircularOrbit orbit;
    orbit.center = center;
    orbit.beam = a.parallel ? BeamShape::parallel : BeamShape::cone;
    if (!a.parallel) {
        const std::vector<double> distances = parseNumbers(a.cone, "--cone", 2, 2, "500,1000");
        orbit.sourceToAxis = distances[0];
        orbit.sourceToDetector = distances[1];
    }
    orbit.arc = a.arc.value_or(a.parallel ? 180 : 360);
    orbit.firstAngle = a.firstAngle;
    if (measured) {
        orbit.width = measured->width;
        orbit.height = measured->height;
        orbit.views = measured->views;
        // With another number of views than there are the error is that they do not match.
        if (!a.arc && (a.views == 0 || a.views == measured->views)) orbit.angles = measured->angles;
        for (double& angle : orbit.angles) angle += a.firstAngle;
        if (measured->spacing) {
            orbit.pixelWidth = std::abs((*measured->spacing)[0]);
            orbit.pixelHeight = std::abs((*measured->spacing)[1]);
        }
    }
    if (a.views > 0) orbit.views = a.views;
    if (!a.detector.empty()) {
        const Detector detector = parseDetector(a.detector);
        orbit.width = detector.width;
        orbit.height = detector.height;
        if (detector.pitch) orbit.pixelWidth = orbit.pixelHeight = *detector.pitch;
    }
    if (!a.pitch.empty()) {
        const DetectorPair pitch = parsePitch(a.pitch);
        orbit.pixelWidth = pitch[0];
        orbit.pixelHeight = pitch[1];
    }
    orbit.axisColumn = a.axisColumn;
    orbit.centerRow = a.centerRow;
    if (!a.center.empty()) orbit.center = parseVec3(a.center, "--orbit-center");
    return orbit;
}

}  // namespace

DetectorPair pitchOf(const ProjectionGeometry& geometry) {
    return {geometry.views.front().column.length(), geometry.views.front().row.length()};
}

void requireProjectionOutput(const std::string& path, const std::string& option) {
    requireFileOutput(path, option);
    const std::string extension = lowerExtension(path);
    if (extension != ".mha" && extension != ".exr")
        usageError(option, "'" + path + "' must end in .mha (one file) or .exr (one for each view)");
}

void addScanOptions(CLI::App& app, ScanArguments& a) {
    app.option_defaults()->group("Geometry");
    app.add_option("--geometry", a.geometry,
                   "Where each view's rays run: RTK's ThreeDCircularGeometry .xml, or .json as docs/ct.md says")
        ->type_name("FILE");
    app.add_flag("--parallel", a.parallel, "Instead: parallel rays, turning about z");
    app.add_option("--cone", a.cone,
                   "Instead: rays from a point, turning about z; distances from source to axis and detector")
        ->type_name("SID,SDD");
    app.add_option("--views", a.views, "Number of views")->check(CLI::Range(1, 1 << 20).description(""));
    app.add_option("--arc", a.arc, "Degrees that the views are spread over (default: 180 parallel, 360 cone)")
        ->type_name("DEG");
    app.add_option("--first-angle", a.firstAngle, "Where the source is at first: degrees from +x towards +y")
        ->type_name("DEG")
        ->capture_default_str();
    app.add_option("--detector", a.detector, "Columns, rows, and distance of pixels in world units (default: 1)")
        ->type_name("W,H[,PITCH]");
    app.add_option("--pitch", a.pitch, "Distance of pixels, world units; of columns and rows if they differ")
        ->type_name("W[,H]");
    app.add_option("--center-row", a.centerRow, "Row that the central ray meets (default: the middle)");
    app.add_option(
           "--orbit-center", a.center,
           "Point on the axis that the central ray passes (default: the middle of the volume; ct: of --initial or "
           "--reference, else 0,0,0)")
        ->type_name("X,Y,Z");
    app.option_defaults()->group("Options");
}

void checkScanOptions(const ScanArguments& a) {
    const int ways = int(!a.geometry.empty()) + int(a.parallel) + int(!a.cone.empty());
    if (ways == 0) usageError("--geometry", "is missing: give a file, --parallel, or --cone SID,SDD");
    if (ways > 1) usageError("--geometry", "say it one way only: --geometry, --parallel or --cone");
    if (!a.geometry.empty()) {
        if (a.views > 0 || a.arc || a.firstAngle != 0 || a.axisColumn || a.centerRow || !a.center.empty())
            usageError("--geometry", "says where the views are; leave out --views, --arc and the like");
        if (!a.detector.empty()) parseDetector(a.detector);
        if (!a.pitch.empty()) parsePitch(a.pitch);
        return;
    }
    try {
        orbitOf(a, nullptr, Vec3(0)).validate();
    } catch (const InvalidArgument& e) {
        usageError(a.parallel ? "--parallel" : "--cone", e.what());
    }
}

void commentOnScan(const ScanArguments& a, const CommonOptions& common) {
    if (a.cone.empty()) return;
    const CircularOrbit orbit = orbitOf(a, nullptr, Vec3(0));
    if (orbit.sourceToDetector < orbit.sourceToAxis)
        warning(common,
                "--cone '" + a.cone + "': the detector is nearer to the source than the axis is; are the two swapped?");
}

Vec3 middleOf(const openvdb::FloatGrid& volume) {
    const auto box = volume.evalActiveVoxelBoundingBox();
    const openvdb::Vec3d middle = volume.indexToWorld(0.5 * (box.min().asVec3d() + box.max().asVec3d()));
    return Vec3(middle.x(), middle.y(), middle.z());
}

ProjectionGeometry scanGeometry(const ScanArguments& a, const MeasuredScan* measured, const Vec3& center) {
    if (a.geometry.empty()) {
        if (!measured && a.views == 0) usageError("--views", "is missing: how many views?");
        if (!measured && a.detector.empty()) usageError("--detector", "is missing: how many columns and rows?");
        return circularGeometry(orbitOf(a, measured, center));
    }
    MeasuredScan scan = measured ? *measured : MeasuredScan();
    if (!a.detector.empty()) {
        const Detector detector = parseDetector(a.detector);
        scan.width = detector.width;
        scan.height = detector.height;
        if (detector.pitch) scan.spacing = DetectorPair{*detector.pitch, *detector.pitch};
    }
    if (!a.pitch.empty()) scan.spacing = parsePitch(a.pitch);
    return readGeometry(a.geometry, scan.width, scan.height, scan.spacing, scan.origin);
}

}  // namespace raysweep::apps
