#include "scan_options.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/scan/projection_io.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace raysweep::apps {
namespace {

constexpr int kMostPixels = 1 << 16;
const std::map<std::string, AngleUnit> kAngleUnits = {{"deg", AngleUnit::degrees}, {"rad", AngleUnit::radians}};

/// W,H[,PITCH]
void parseDetector(const std::string& text, ScanGeometryOptions& options) {
    const std::vector<double> numbers = parseNumbers(text, "--detector", 2, 3, "384,256,1");
    for (int i = 0; i < 2; ++i)
        if (!(numbers[i] >= 1 && numbers[i] <= kMostPixels) || numbers[i] != std::floor(numbers[i]))
            usageError("--detector", "'" + text + "': columns and rows must be whole numbers of at least 1");
    options.width = int(numbers[0]);
    options.height = int(numbers[1]);
    if (numbers.size() == 2) return;
    if (!(numbers[2] > 0)) usageError("--detector", "'" + text + "': the pitch must be positive");
    options.pitch = DetectorPair{numbers[2], numbers[2]};
}

/// WIDTH[,HEIGHT] of a pixel
DetectorPair parsePitch(const std::string& text) {
    const std::vector<double> numbers = parseNumbers(text, "--pitch", 1, 2, "0.5");
    for (const double number : numbers)
        if (!(number > 0)) usageError("--pitch", "'" + text + "': must be positive");
    return {numbers.front(), numbers.back()};
}

/// One of the three ways to say where the rays run.
void requireOneWay(const ScanArguments& a) {
    const ScanGeometryOptions& options = a.options;
    const int ways = int(!options.file.empty()) + int(a.parallel) + int(!a.cone.empty());
    if (ways == 0) usageError("--geometry", "is missing: give a file, --parallel, or --cone SID,SDD");
    if (ways > 1) usageError("--geometry", "say it one way only: --geometry, --parallel or --cone");
    if (!options.file.empty() && (options.views > 0 || options.arc || options.firstAngle != 0 || options.axisColumn ||
                                  !options.angles.empty() || options.centerRow || !a.center.empty()))
        usageError("--geometry", "says where the views are; leave out --views, --arc, --angles and the like");
}

}  // namespace

void requireProjectionOutput(const std::string& path, const std::string& option) {
    requireFileOutput(path, option);
    const std::string extension = lowerExtension(path);
    if (extension != ".mha" && extension != ".exr")
        usageError(option, "'" + path + "' must end in .mha (one file) or .exr (one for each view)");
}

void addScanOptions(CLI::App& app, ScanArguments& a) {
    app.option_defaults()->group("Geometry");
    app.add_option("--geometry", a.options.file,
                   "Where each view's rays run: RTK's ThreeDCircularGeometry .xml, or .json as docs/ct.md says")
        ->type_name("FILE");
    app.add_flag("--parallel", a.parallel, "Instead: parallel rays, turning about z");
    app.add_option("--cone", a.cone,
                   "Instead: rays from a point, turning about z; distances from source to axis and detector")
        ->type_name("SID,SDD");
    app.add_option("--views", a.options.views, "Number of views")->check(CLI::Range(1, 1 << 20).description(""));
    app.add_option("--arc", a.options.arc, "Degrees that the views are spread over (default: 180 parallel, 360 cone)")
        ->type_name("DEG");
    app.add_option("--angles", a.options.angles,
                   "Text file with the angle of each view, in degrees unless they cover a turn in radians; instead of "
                   "--arc")
        ->type_name("FILE");
    app.add_option("--angle-unit", a.angleUnit, "Unit of the angles in files, if they are not what they look like")
        ->check(CLI::IsMember(kAngleUnits).description(""))
        ->type_name("deg|rad");
    app.add_option("--first-angle", a.options.firstAngle, "Where the source is at first: degrees from +x towards +y")
        ->type_name("DEG")
        ->capture_default_str();
    app.add_option("--detector", a.detector, "Columns, rows, and distance of pixels in world units (default: 1)")
        ->type_name("W,H[,PITCH]");
    app.add_option("--pitch", a.pitch, "Distance of pixels, world units; of columns and rows if they differ")
        ->type_name("W[,H]");
    app.add_option("--center-row", a.options.centerRow, "Row that the central ray meets (default: the middle)");
    app.add_option(
           "--orbit-center", a.center,
           "Point on the axis that the central ray passes (default: the middle of the volume; ct: of --initial or "
           "--reference, else 0,0,0)")
        ->type_name("X,Y,Z");
    for (const char* name : {"--geometry", "--angles"}) reads(app.get_option(name));
    app.option_defaults()->group("Options");
}

std::vector<std::string> projectionNames(const std::string& path, const ScanArguments& a) {
    constexpr int kMost = 10000;
    return projectionFiles(path, std::clamp(a.options.views, 1, kMost));
}

void completeScanOptions(ScanArguments& a) {
    requireOneWay(a);
    if (!a.cone.empty()) {
        const std::vector<double> distances = parseNumbers(a.cone, "--cone", 2, 2, "500,1000");
        a.options.beam = BeamShape::cone;
        a.options.sourceToAxis = distances[0];
        a.options.sourceToDetector = distances[1];
    }
    if (a.options.arc && !a.options.angles.empty()) usageError("--arc", "leave it out if there are --angles");
    if (!a.angleUnit.empty()) a.options.angleUnit = kAngleUnits.at(a.angleUnit);
    if (!a.detector.empty()) parseDetector(a.detector, a.options);
    if (!a.pitch.empty()) a.options.pitch = parsePitch(a.pitch);
    if (!a.center.empty()) a.options.center = parseVec3(a.center, "--orbit-center");
    try {
        a.options.validate();
    } catch (const InvalidArgument& e) {
        usageError(!a.options.file.empty() ? "--geometry" : a.parallel ? "--parallel" : "--cone", e.what());
    }
}

void requireWhole(const ScanArguments& a) {
    if (!a.options.file.empty()) return;
    if (a.options.views == 0 && a.options.angles.empty()) usageError("--views", "is missing: how many views?");
    if (a.detector.empty()) usageError("--detector", "is missing: how many columns and rows?");
}

ScanGeometryOptions centeredAt(const Vec3& center, ScanGeometryOptions options) {
    if (options.file.empty() && !options.center) options.center = center;
    return options;
}

}  // namespace raysweep::apps
