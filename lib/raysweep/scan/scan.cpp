#include "raysweep/scan/scan.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/require.h"
#include "raysweep/scan/line_integrals.h"
#include "raysweep/scan/ring_filter.h"
#include "raysweep/scan/scan_reader.h"
#include "raysweep/scan/value_checks.h"

#include <cmath>

namespace raysweep {
namespace {

/// Line integrals of what was read, without what can be no measurement.
Projections integralsOf(const ScanOptions& options, MeasuredFiles& measured, Scan& scan) {
    if (measured.flat.empty()) {
        Projections projections = std::move(measured.values);
        scan.found.implausible = markImplausible(projections);
        if (!isFloatingPoint(measured.type))
            measured.assumptions.push_back("the file's " + nameOf(measured.type) +
                                           " numbers are line integrals as they are; if they are counts, say with " +
                                           "`flat` what is counted without object");
        for (const std::string& doubt : doubtsAbout(projections))
            scan.found.warnings.push_back({ScanWarning::Kind::values, doubt});
        return projections;
    }
    LineIntegralOptions how;
    if (!isFloatingPoint(measured.type)) how.leastCount = 1;
    if (const auto limit = options.saturatedAbove ? options.saturatedAbove
                                                  : exposureLimit(measured.values, measured.type, measured.flat))
        how.saturatedAbove = *limit;
    LineIntegrals integrals = lineIntegrals(std::move(measured.values), measured.flat, measured.dark, how);
    scan.found.deadPixels = integrals.deadPixels;
    scan.found.implausible = integrals.implausible;
    for (const std::string& doubt : doubtsAbout(integrals.projections, true))
        scan.found.warnings.push_back({ScanWarning::Kind::values, doubt});
    return std::move(integrals.projections);
}

/// Counts become line integrals; pixels that say nothing are left out.
void prepare(const ScanOptions& options, MeasuredFiles& measured, Scan& scan) {
    Projections& projections = scan.projections = integralsOf(options, measured, scan);
    if (options.scale != 1) {
        for (float& value : projections.values) value *= float(options.scale);
        projections.saturation *= float(options.scale);
    }
    if (options.saturation) projections.saturation = float(*options.saturation);
    if (options.saturatedAbove && measured.flat.empty()) projections.saturation = float(*options.saturatedAbove);
    if (options.findDeadPixels) scan.found.deadPixels += markDeadPixels(projections);
    if (options.ringWindow > 0) filterRings(projections, RingFilterOptions{options.ringWindow});
    scan.found.rays = countRays(projections);
    if (scan.found.rays.notMeasured == projections.values.size())
        throw InvalidArgument("'" + options.projections.front() +
                              "': no ray was measured: all values are NaN or infinite, or of dead pixels");
}

bool looksForAxis(const ScanOptions& options) {
    if (options.axisSearch != AxisSearch::automatic) return options.axisSearch == AxisSearch::always;
    return isHdf5(options.projections.front()) && options.geometry.file.empty() &&
           options.geometry.beam == BeamShape::parallel && !options.geometry.axisColumn;
}

/// Degrees of each view, as far as options or the file say.
std::vector<double> anglesOf(const ScanGeometryOptions& options, const MeasuredScan& measured) {
    if (!options.arc && !measured.angles.empty()) return measured.angles;
    std::vector<double> angles;
    for (int n = 0; n < measured.views; ++n)
        angles.push_back(options.firstAngle + options.arc.value_or(180) * n / measured.views);
    return angles;
}

/// Pixels that are not as far apart as the projections say, if the geometry has its own distances.
std::optional<ScanWarning> pitchWarning(const MeasuredScan& measured, const ProjectionGeometry& geometry) {
    constexpr double kSame = 0.01;                                                // relative
    if (!measured.spacing || *measured.spacing == DetectorPair{1, 1}) return {};  // 1: also where a file says nothing
    const DetectorPair pitch = pitchOf(geometry);
    const double column = std::abs((*measured.spacing)[0]), row = std::abs((*measured.spacing)[1]);
    if (std::abs(pitch[0] / column - 1) <= kSame && std::abs(pitch[1] / row - 1) <= kSame) return {};
    return ScanWarning{ScanWarning::Kind::pixelPitch, "pixels are " + brief(pitch[0]) + " x " + brief(pitch[1]) +
                                                          " apart in the geometry, but " + brief(column) + " x " +
                                                          brief(row) +
                                                          " in the projections; are both in the same unit (mm, cm)?"};
}

std::optional<ScanWarning> deadPixelWarning(const Scan& scan) {
    const std::size_t dead = scan.found.deadPixels, all = scan.projections.pixelsPerView();
    if (2 * dead <= all) return {};
    return ScanWarning{ScanWarning::Kind::deadPixels,
                       std::to_string(dead) + " of " + std::to_string(all) + " pixels are dead"};
}

std::optional<ScanWarning> implausibleWarning(const Scan& scan) {
    const std::size_t found = scan.found.implausible;
    if (found == 0) return {};
    return ScanWarning{ScanWarning::Kind::implausible,
                       std::to_string(found) + (found > 1 ? " values" : " value") +
                           " can be no measurement, so much larger than the others, and " + (found > 1 ? "are" : "is") +
                           " left out as not measured"};
}

/// What nothing says of where the rays ran.
void addAssumptions(const ScanOptions& options, const MeasuredScan& measured, Scan& scan) {
    const ScanGeometryOptions& geometry = options.geometry;
    scan.found.anglesAssumed = geometry.file.empty() && !geometry.arc && measured.angles.empty();
    scan.found.pitchAssumed = geometry.file.empty() && !geometry.pitch && !measured.spacing;
    if (scan.found.anglesAssumed)
        scan.found.assumptions.push_back(
            "the " + std::to_string(scan.projections.views) + " views are evenly spread over " +
            (geometry.beam == BeamShape::parallel ? "180" : "360") + " degrees; `arc` or `angles` say otherwise");
    if (scan.found.pitchAssumed) scan.found.assumptions.push_back("pixels are 1 apart; `pitch` says otherwise");
}

void addWarnings(const ScanOptions& options, const MeasuredScan& measured, Scan& scan) {
    const bool ownPitch = !options.geometry.file.empty() && !options.geometry.pitch;
    for (const auto& warning : {detectorBeforeAxis(options.geometry),
                                ownPitch ? pitchWarning(measured, scan.geometry) : std::optional<ScanWarning>(),
                                deadPixelWarning(scan), implausibleWarning(scan)})
        if (warning) scan.found.warnings.push_back(*warning);
}

void requirePositive(double value, const char* field) {
    requireField(value > 0 && std::isfinite(value), field, value, "positive and finite");
}

}  // namespace

void ScanOptions::validate() const {
    if (projections.empty()) throw InvalidArgument("projections: give at least one file");
    const bool hdf5 = isHdf5(projections.front());
    if (hdf5 && projections.size() > 1) throw InvalidArgument("projections: give one HDF5 file");
    if (!dark.empty() && flatSource(*this) == FrameSource::none) throw InvalidArgument("dark: needs `flat` as well");
    if (darkSource(*this) == FrameSource::sides) throw InvalidArgument("dark: give a file, or a number");
    if (saturatedAbove) requirePositive(*saturatedAbove, "saturatedAbove");
    if (saturatedAbove && saturation && flatSource(*this) == FrameSource::none)
        throw InvalidArgument("saturatedAbove: of line integrals it is `saturation`; give one of the two");
    if (hdf5 && sinograms == Sinograms::always)
        throw InvalidArgument("sinograms: HDF5 files say themselves how they are ordered");
    if (rows && !hdf5) throw InvalidArgument("rows: only of HDF5 files");
    if (rows && geometry.file.empty() && geometry.beam == BeamShape::cone && !geometry.centerRow)
        throw InvalidArgument("rows: of a cone need `centerRow` as well, counted from the first of them");
    requirePositive(scale, "scale");
    if (saturation) requirePositive(*saturation, "saturation");
    if (ringWindow != 0) RingFilterOptions{ringWindow}.validate();
    if (axisSearch == AxisSearch::always && !(geometry.file.empty() && geometry.beam == BeamShape::parallel))
        throw InvalidArgument("axisSearch: the axis is only found for parallel beams that turn about z");
    if (axisSearch == AxisSearch::always && geometry.axisColumn)
        throw InvalidArgument("axisSearch: always, but `axisColumn` says where the axis is; give one of the two");
    geometry.validate();
}

std::optional<ScanWarning> detectorBeforeAxis(const ScanGeometryOptions& options) {
    if (!options.file.empty() || options.beam != BeamShape::cone || options.sourceToDetector >= options.sourceToAxis)
        return {};
    return ScanWarning{ScanWarning::Kind::detectorBeforeAxis,
                       "the detector is nearer to the source (" + brief(options.sourceToDetector, 4) +
                           ") than the axis is (" + brief(options.sourceToAxis, 4) + "); are the two swapped?"};
}

RayCounts countRays(const Projections& projections) {
    RayCounts counts;
    for (std::size_t p = 0; p < projections.values.size(); ++p) {
        counts.notMeasured += std::isnan(projections.values[p]);
        const RayBound bound = projections.boundOf(p);
        counts.saturated += bound == RayBound::atLeast;
        counts.overexposed += bound == RayBound::atMost;
    }
    return counts;
}

Scan readScan(const ScanOptions& options, const ProgressCallback& progress) {
    options.validate();
    MeasuredFiles measured = readMeasuredFiles(options, progress);
    Scan scan;
    scan.complete = measured.complete;
    if (!scan.complete) return scan;
    scan.found.format = measured.format;
    prepare(options, measured, scan);
    ScanGeometryOptions geometry = options.geometry;
    if (looksForAxis(options)) {
        scan.found.axis = findRotationCenter(scan.projections, anglesOf(geometry, measured.scan));
        geometry.axisColumn = scan.found.axis->column;
    }
    scan.geometry = scanGeometry(geometry, measured.scan);
    requireMatching(scan.geometry, scan.projections);
    scan.found.assumptions = std::move(measured.assumptions);
    addAssumptions(options, measured.scan, scan);
    addWarnings(options, measured.scan, scan);
    return scan;
}

}  // namespace raysweep
