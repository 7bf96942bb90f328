#include "raysweep/camera/projection_geometry.h"

#include "raysweep/core/finite.h"
#include "raysweep/core/require.h"

#include <cmath>
#include <string>

namespace raysweep {
namespace {

/// Sine of the angle below which rays count as running within the detector's plane.
constexpr double kGrazing = 1e-6;

void requireView(const XrayView& view, BeamShape beam, const std::string& name) {
    if (!isFinite(view.source) || !isFinite(view.direction) || !isFinite(view.origin) || !isFinite(view.column) ||
        !isFinite(view.row))
        throw InvalidArgument(name + ": all numbers must be finite");
    const Vec3 normal = view.column.cross(view.row);
    if (!(normal.length() > kGrazing * view.column.length() * view.row.length()))
        throw InvalidArgument(name + ": the detector has no area; its columns and rows must differ in direction");
    if (beam == BeamShape::parallel) {
        if (!(std::abs(view.direction.length() - 1) < 1e-6))
            throw InvalidArgument(name + ": the direction of parallel rays must have length 1");
        if (!(std::abs(view.direction.dot(normal)) > kGrazing * normal.length()))
            throw InvalidArgument(name + ": the rays run within the detector's plane");
    } else {
        const Vec3 toDetector = view.origin - view.source;
        if (!(std::abs(toDetector.dot(normal)) > kGrazing * normal.length() * toDetector.length()))
            throw InvalidArgument(name + ": the source lies in the detector's plane");
    }
}

}  // namespace

void ProjectionGeometry::validate() const {
    if (width <= 0 || height <= 0)
        throw InvalidArgument("a detector of " + std::to_string(width) + "x" + std::to_string(height) +
                              " pixels: both must be at least 1");
    if (views.empty()) throw InvalidArgument("the geometry has no views");
    for (std::size_t n = 0; n < views.size(); ++n) requireView(views[n], beam, "view " + std::to_string(n));
}

void CircularOrbit::validate() const {
    const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
    if (beam == BeamShape::cone) {
        requireField(positive(sourceToAxis), "orbit sourceToAxis", sourceToAxis, "positive and finite");
        requireField(positive(sourceToDetector), "orbit sourceToDetector", sourceToDetector, "positive and finite");
    }
    for (const double angle : angles) requireField(std::isfinite(angle), "orbit angle", angle, "finite");
    const long long count = angles.empty() ? views : static_cast<long long>(angles.size());
    requireField(count > 0 && count <= kMostViews, "orbit views", count, "1 to " + std::to_string(kMostViews));
    requireField(std::isfinite(firstAngle), "orbit firstAngle", firstAngle, "finite");
    requireField(std::isfinite(arc) && arc != 0, "orbit arc", arc, "finite and not 0");
    requireField(width > 0, "orbit width", width, "at least 1");
    requireField(height > 0, "orbit height", height, "at least 1");
    requireField(positive(pixelWidth), "orbit pixelWidth", pixelWidth, "positive and finite");
    requireField(positive(pixelHeight), "orbit pixelHeight", pixelHeight, "positive and finite");
    requireField(std::isfinite(axisColumn.value_or(0)), "orbit axisColumn", axisColumn.value_or(0), "finite");
    requireField(std::isfinite(centerRow.value_or(0)), "orbit centerRow", centerRow.value_or(0), "finite");
    requireField(isFinite(center), "orbit center", center, "finite");
}

ProjectionGeometry circularGeometry(const CircularOrbit& orbit) {
    orbit.validate();
    ProjectionGeometry geometry;
    geometry.beam = orbit.beam;
    geometry.width = orbit.width;
    geometry.height = orbit.height;
    const bool cone = orbit.beam == BeamShape::cone;
    const double axisColumn = orbit.axisColumn.value_or(0.5 * (orbit.width - 1));
    const double centerRow = orbit.centerRow.value_or(0.5 * (orbit.height - 1));
    std::vector<double> angles = orbit.angles;
    for (int n = 0; n < orbit.views && orbit.angles.empty(); ++n)
        angles.push_back(orbit.firstAngle + orbit.arc * n / orbit.views);
    for (const double degrees : angles) {
        const double angle = degrees * kPi / 180;
        const Vec3 toSource(std::cos(angle), std::sin(angle), 0);
        XrayView view;
        view.column = Vec3(-std::sin(angle), std::cos(angle), 0) * orbit.pixelWidth;
        view.row = Vec3(0, 0, -orbit.pixelHeight);
        Vec3 middle = orbit.center;
        if (cone) {
            view.source = orbit.center + toSource * orbit.sourceToAxis;
            middle = view.source - toSource * orbit.sourceToDetector;
        } else {
            view.direction = -toSource;
        }
        view.origin = middle - view.column * axisColumn - view.row * centerRow;
        geometry.views.push_back(view);
    }
    return geometry;
}

ProjectionGeometry selectViews(const ProjectionGeometry& geometry, const std::vector<int>& which) {
    ProjectionGeometry selected = geometry;
    selected.views.clear();
    for (int n : which) selected.views.push_back(geometry.views.at(std::size_t(n)));
    return selected;
}

}  // namespace raysweep
