#include "raysweep/scan/scan_geometry.h"

#include "raysweep/core/require.h"
#include "raysweep/scan/geometry_io.h"

#include <cmath>

namespace raysweep {
namespace {

CircularOrbit orbitOf(const ScanGeometryOptions& options, const MeasuredScan& measured) {
    CircularOrbit orbit;
    orbit.beam = options.beam;
    orbit.sourceToAxis = options.sourceToAxis;
    orbit.sourceToDetector = options.sourceToDetector;
    orbit.views = options.views > 0 ? options.views : measured.views > 0 ? measured.views : int(measured.angles.size());
    orbit.firstAngle = options.firstAngle;
    orbit.arc = options.arc.value_or(options.beam == BeamShape::parallel ? 180 : 360);
    // With another number of views than there are the error is that they do not match.
    if (!options.arc && std::size_t(orbit.views) == measured.angles.size()) orbit.angles = measured.angles;
    for (double& angle : orbit.angles) angle += options.firstAngle;
    orbit.width = options.width > 0 ? options.width : measured.width;
    orbit.height = options.height > 0 ? options.height : measured.height;
    if (options.pitch || measured.spacing) {
        const DetectorPair pitch = options.pitch ? *options.pitch : *measured.spacing;
        orbit.pixelWidth = std::abs(pitch[0]);
        orbit.pixelHeight = std::abs(pitch[1]);
    }
    orbit.axisColumn = options.axisColumn;
    orbit.centerRow = options.centerRow;
    orbit.center = options.center.value_or(Vec3(0));
    return orbit;
}

}  // namespace

void ScanGeometryOptions::validate() const {
    requireField(views >= 0, "views", views, "at least 0");
    requireField(width >= 0, "width", width, "at least 0");
    requireField(height >= 0, "height", height, "at least 0");
    if (pitch)
        for (const double distance : *pitch)
            requireField(distance > 0 && std::isfinite(distance), "pitch", distance, "positive and finite");
    if (arc && !angles.empty()) throw InvalidArgument("arc: leave it out if there are `angles`");
    if (file.empty()) {
        const MeasuredScan anything{1, 1, 1, {}, {}, {}};  // what is not known yet is right
        orbitOf(*this, anything).validate();
    } else if (views > 0 || firstAngle != 0 || arc || !angles.empty() || angleUnit || axisColumn || centerRow ||
               center) {
        throw InvalidArgument(
            "'" + file +
            "' says where the views are; leave out `views`, `firstAngle`, `arc`, `angles`, `axisColumn`, " +
            "`centerRow` and `center`");
    }
}

ProjectionGeometry scanGeometry(const ScanGeometryOptions& options, const MeasuredScan& measured) {
    options.validate();
    if (options.file.empty()) {
        if (options.angles.empty() || !measured.angles.empty()) return circularGeometry(orbitOf(options, measured));
        MeasuredScan told = measured;
        told.angles = viewAngles(readAngleFile(options.angles), "", options.angleUnit).degrees;
        if (options.views > 0 && std::size_t(options.views) != told.angles.size())
            throw InvalidArgument("views " + std::to_string(options.views) + ": '" + options.angles + "' has " +
                                  std::to_string(told.angles.size()) + " angles; leave out one of the two");
        return circularGeometry(orbitOf(options, told));
    }
    const int width = options.width > 0 ? options.width : measured.width;
    const int height = options.height > 0 ? options.height : measured.height;
    return readGeometry(options.file, width, height, options.pitch ? options.pitch : measured.spacing, measured.origin);
}

DetectorPair pitchOf(const ProjectionGeometry& geometry) {
    return {geometry.views.front().column.length(), geometry.views.front().row.length()};
}

}  // namespace raysweep
