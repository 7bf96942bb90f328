// RTK places source and detector in a system that turns with the gantry; a point of the world has the coordinates
// R p there, R = Rz(-inPlane) Rx(-outOfPlane) Ry(-gantry):
//   source    (SourceOffsetX, SourceOffsetY, SourceToIsocenterDistance)
//   detector  (ProjectionOffsetX, ProjectionOffsetY, SourceToIsocenterDistance - SourceToDetectorDistance) + (u, v, 0)
// with (u, v) from the image's origin and spacing. Parallel rays run along -z, and meet a detector at z =
// -SourceToIsocenterDistance.
#include "raysweep/scan/rtk_geometry.h"

#include "raysweep/core/error.h"

#include <pugixml.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace raysweep {
namespace {

using Matrix34 = std::array<double, 12>;  ///< row by row

/// What a file says, as far as it was read. RTK's names, degrees.
struct Parameters {
    double gantryAngle = 0, outOfPlaneAngle = 0, inPlaneAngle = 0;
    double sourceToIsocenter = 0, sourceToDetector = 0;
    double sourceOffsetX = 0, sourceOffsetY = 0, projectionOffsetX = 0, projectionOffsetY = 0;
    double cylinderRadius = 0;
};

struct Field {
    const char* name;
    double Parameters::*value;
};
constexpr Field kFields[] = {
    {"GantryAngle", &Parameters::gantryAngle},
    {"Angle", &Parameters::gantryAngle},  // its name in files of long ago
    {"OutOfPlaneAngle", &Parameters::outOfPlaneAngle},
    {"InPlaneAngle", &Parameters::inPlaneAngle},
    {"SourceToIsocenterDistance", &Parameters::sourceToIsocenter},
    {"SourceToDetectorDistance", &Parameters::sourceToDetector},
    {"SourceOffsetX", &Parameters::sourceOffsetX},
    {"SourceOffsetY", &Parameters::sourceOffsetY},
    {"ProjectionOffsetX", &Parameters::projectionOffsetX},
    {"ProjectionOffsetY", &Parameters::projectionOffsetY},
    {"RadiusCylindricalDetector", &Parameters::cylinderRadius},
};

/// All numbers in `text`, which has nothing else.
std::vector<double> numbersIn(const std::string& text, const std::string& where) {
    std::vector<double> numbers;
    const char *at = text.data(), *end = at + text.size();
    for (;;) {
        at = std::find_if_not(at, end, [](char c) { return std::strchr(" \t\r\n", c) && c; });
        if (at == end) return numbers;
        double value = 0;
        const auto [next, failed] = std::from_chars(*at == '+' ? at + 1 : at, end, value);
        if (failed != std::errc() || !std::isfinite(value))
            throw IoError(where + ": '" + std::string(at, std::find(at, end, '\n')) + "' is no finite number");
        numbers.push_back(value);
        at = next;
    }
}

/// Once in each view, and once for all of them: of two, nobody knows which is meant.
void requireOnce(const pugi::xml_node& element, const std::string& where) {
    if (element.next_sibling(element.name())) throw IoError(where + ": <" + element.name() + "> is given twice");
}

/// Takes the value of `element` into `parameters`.
void take(const pugi::xml_node& element, const std::string& where, Parameters& parameters) {
    if (std::strncmp(element.name(), "Collimation", 11) == 0) return;  // jaws: where the beam ends, not where rays run
    const auto field = std::find_if(std::begin(kFields), std::end(kFields),
                                    [&](const Field& f) { return std::strcmp(f.name, element.name()) == 0; });
    if (field == std::end(kFields))
        throw IoError(where + ": <" + element.name() + "> is not known in RTK's geometries of version 3");
    const std::vector<double> numbers = numbersIn(element.text().get(), where + ", <" + element.name() + ">");
    if (numbers.size() != 1) throw IoError(where + ": <" + element.name() + "> must hold one number");
    parameters.*(field->value) = numbers[0];
    if (parameters.cylinderRadius != 0)
        throw InvalidArgument(where + ": RadiusCylindricalDetector is " + element.text().get() +
                              ", but only flat detectors (0) are known; resample the projections to a flat one");
}

Vec3 turned(const Vec3& v, int axis, double degrees) {
    const double c = std::cos(degrees * kPi / 180), s = std::sin(degrees * kPi / 180);
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    Vec3 result = v;
    result[a] = c * v[a] - s * v[b];
    result[b] = s * v[a] + c * v[b];
    return result;
}

/// From the gantry's system to the world: the inverse of R.
Vec3 worldFromGantry(const Parameters& p, const Vec3& v) {
    return turned(turned(turned(v, 2, p.inPlaneAngle), 0, p.outOfPlaneAngle), 1, p.gantryAngle);
}

XrayView viewOf(const Parameters& p, const DetectorPair& spacing, const DetectorPair& origin) {
    const bool parallel = p.sourceToDetector == 0;
    const double depth = parallel ? -p.sourceToIsocenter : p.sourceToIsocenter - p.sourceToDetector;
    XrayView view;
    if (parallel)
        view.direction = worldFromGantry(p, Vec3(0, 0, -1));
    else
        view.source = worldFromGantry(p, Vec3(p.sourceOffsetX, p.sourceOffsetY, p.sourceToIsocenter));
    view.origin = worldFromGantry(p, Vec3(p.projectionOffsetX + origin[0], p.projectionOffsetY + origin[1], depth));
    view.column = worldFromGantry(p, Vec3(spacing[0], 0, 0));
    view.row = worldFromGantry(p, Vec3(0, spacing[1], 0));
    return view;
}

/// How far, in pixels, `matrix` puts points on the rays of the detector's corners beside these pixels.
double disagreement(const Matrix34& matrix, const XrayView& view, bool parallel, const RtkDetector& detector) {
    double worst = 0;
    for (const int x : {0, detector.width - 1})
        for (const int y : {0, detector.height - 1})
            for (const double toSource : {0.0, 0.5}) {
                const Vec3 pixel = view.pixel(x, y);
                const double across = view.column.length() * detector.width + view.row.length() * detector.height;
                const Vec3 point = pixel + (parallel ? -view.direction * across : view.source - pixel) * toSource;
                double image[3];
                for (std::size_t r = 0; r < 3; ++r)
                    image[r] = matrix[4 * r] * point.x + matrix[4 * r + 1] * point.y + matrix[4 * r + 2] * point.z +
                               matrix[4 * r + 3];
                const double u = ((image[0] / image[2]) - (*detector.origin)[0]) / (*detector.spacing)[0] - x;
                const double v = ((image[1] / image[2]) - (*detector.origin)[1]) / (*detector.spacing)[1] - y;
                const double distance = std::hypot(u, v);
                worst = std::max(worst, std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance);
            }
    return worst;
}

/// Ten times what six digits of each number leave open on a detector of 4096 pixels.
constexpr double kMatrixTolerance = 0.05;

void requireMatrix(const pugi::xml_node& element, const std::string& where, const XrayView& view, bool parallel,
                   const RtkDetector& detector) {
    const std::vector<double> numbers = numbersIn(element.text().get(), where + ", <Matrix>");
    if (numbers.size() != 12) throw IoError(where + ": <Matrix> must hold 3 x 4 numbers");
    Matrix34 matrix;
    std::copy(numbers.begin(), numbers.end(), matrix.begin());
    const double pixels = disagreement(matrix, view, parallel, detector);
    if (!(pixels <= kMatrixTolerance))
        throw InvalidArgument(where + ": <Matrix> contradicts the angles and distances by " + std::to_string(pixels) +
                              " pixels; correct one, or leave the matrix out");
}

pugi::xml_node rootOf(pugi::xml_document& document, const std::string& text) {
    const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
    if (!result) {
        const auto at = text.begin() + std::min<std::ptrdiff_t>(result.offset, std::ptrdiff_t(text.size()));
        throw IoError("it is not valid XML, line " + std::to_string(1 + std::count(text.begin(), at, '\n')) + ": " +
                      result.description());
    }
    const pugi::xml_node root = document.document_element();
    if (std::strcmp(root.name(), "RTKThreeDCircularGeometry") != 0)
        throw IoError("its root is <" + std::string(root.name()) +
                      ">, not <RTKThreeDCircularGeometry>: it is no geometry of RTK");
    const int version = root.attribute("version").as_int(0);
    if (version != 2 && version != 3)
        throw IoError("its version is '" + std::string(root.attribute("version").value()) +
                      "', but only 2 and 3 are known; write it again with a newer RTK");
    return root;
}

/// With an origin if it has none: the detector is centred then.
RtkDetector completed(RtkDetector detector) {
    if (detector.width <= 0 || detector.height <= 0 || !detector.spacing)
        throw InvalidArgument(
            "RTK's geometries say nothing about the detector's pixels; read them together with projections in "
            "MetaImage format, which have a spacing, or give columns, rows and pixel size");
    for (const double step : *detector.spacing)
        if (step == 0 || !std::isfinite(step)) throw InvalidArgument("the pixel size must be finite and not 0");
    const DetectorPair middle = {-0.5 * (detector.width - 1) * (*detector.spacing)[0],
                                 -0.5 * (detector.height - 1) * (*detector.spacing)[1]};
    if (!detector.origin) detector.origin = middle;
    return detector;
}

}  // namespace

ProjectionGeometry geometryFromRtk(const std::string& text, const RtkDetector& given) {
    const RtkDetector detector = completed(given);
    pugi::xml_document document;
    const pugi::xml_node root = rootOf(document, text);
    ProjectionGeometry geometry;
    geometry.width = detector.width;
    geometry.height = detector.height;
    Parameters parameters;
    for (const pugi::xml_node& element : root.children()) {
        if (element.type() != pugi::node_element) continue;
        if (std::strcmp(element.name(), "Projection") != 0) {
            requireOnce(element, "the values of all views");
            take(element, "the values of all views", parameters);
            continue;
        }
        const std::string where = "view " + std::to_string(geometry.views.size());
        for (const pugi::xml_node& child : element.children())
            if (child.type() == pugi::node_element) {
                requireOnce(child, where);
                if (std::strcmp(child.name(), "Matrix") != 0) take(child, where, parameters);
            }
        const bool parallel = parameters.sourceToDetector == 0;
        const BeamShape beam = parallel ? BeamShape::parallel : BeamShape::cone;
        if (!geometry.views.empty() && beam != geometry.beam)
            throw InvalidArgument(where + ": SourceToDetectorDistance is 0 in some views (parallel beam), but not in " +
                                  "others (cone beam)");
        geometry.beam = beam;
        geometry.views.push_back(viewOf(parameters, *detector.spacing, *detector.origin));
        if (const pugi::xml_node matrix = element.child("Matrix"))
            requireMatrix(matrix, where, geometry.views.back(), parallel, detector);
    }
    geometry.validate();
    return geometry;
}

}  // namespace raysweep
