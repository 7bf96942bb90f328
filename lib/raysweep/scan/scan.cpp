#include "raysweep/scan/scan.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/require.h"
#include "raysweep/scan/line_integrals.h"
#include "raysweep/scan/ring_filter.h"

#include <cmath>

namespace raysweep {
namespace {

/// What was read, before anything is done to it.
struct Measured {
    Projections values;
    MeasuredScan scan;
    std::vector<float> flat, dark;  ///< empty: `values` are line integrals already
    std::string format;
    bool complete = true;
};

/// The mean of all frames, for each pixel: of those in which it was measured, NaN without any.
std::vector<float> meanFrame(const Projections& frames) {
    std::vector<float> mean(frames.pixelsPerView());
    for (std::size_t i = 0; i < mean.size(); ++i) {
        double sum = 0;
        int measured = 0;
        for (int n = 0; n < frames.views; ++n) {
            const float value = frames.view(n)[i];
            if (std::isnan(value)) continue;
            sum += value;
            ++measured;
        }
        mean[i] = float(sum / measured);
    }
    return mean;
}

/// The mean of the frames in a file, which must be as large as the projections.
std::vector<float> readFrame(const std::string& path, const char* name, const ProjectionReadOptions& options,
                             const Projections& projections) {
    const Projections frames = readProjections({path}, options).projections;
    const auto sizeOf = [](const Projections& p) { return std::to_string(p.width) + "x" + std::to_string(p.height); };
    if (frames.width != projections.width || frames.height != projections.height)
        throw InvalidArgument("the " + std::string(name) + " frame has " + sizeOf(frames) + " pixels ('" + path +
                              "'), but the projections have " + sizeOf(projections) +
                              "; give frames that the same detector made");
    return meanFrame(frames);
}

Measured readHdf5(const ScanOptions& options, const ProgressCallback& progress) {
    DataExchange file = readDataExchange(options.projections.front(), options.rows, progress);
    Measured measured;
    measured.values = std::move(file.counts);
    measured.flat = std::move(file.flat);
    measured.dark = std::move(file.dark);
    measured.scan.angles = std::move(file.angles);
    measured.format = "Data Exchange";
    measured.complete = file.complete;
    return measured;
}

Measured readFiles(const ScanOptions& options, const ProgressCallback& progress) {
    const ProjectionReadOptions readOptions{options.repair};
    ProjectionFile file = readProjections(options.projections, readOptions, progress);
    Measured measured;
    measured.values = std::move(file.projections);
    measured.scan.spacing = file.spacing;
    measured.scan.origin = file.origin;
    measured.format = file.format;
    measured.complete = file.complete;
    if (file.complete && !options.flat.empty()) {
        measured.flat = readFrame(options.flat, "flat", readOptions, measured.values);
        measured.dark = options.dark.empty() ? std::vector<float>(measured.flat.size())
                                             : readFrame(options.dark, "dark", readOptions, measured.values);
    }
    return measured;
}

Measured readMeasured(const ScanOptions& options, const ProgressCallback& progress) {
    Measured measured =
        isHdf5(options.projections.front()) ? readHdf5(options, progress) : readFiles(options, progress);
    measured.scan.width = measured.values.width;
    measured.scan.height = measured.values.height;
    measured.scan.views = measured.values.views;
    return measured;
}

/// Counts become line integrals; pixels that say nothing are left out.
void prepare(const ScanOptions& options, Measured& measured, Scan& scan) {
    Projections& projections = scan.projections;
    if (measured.flat.empty()) {
        projections = std::move(measured.values);
    } else {
        LineIntegrals integrals = lineIntegrals(std::move(measured.values), measured.flat, measured.dark);
        projections = std::move(integrals.projections);
        scan.found.deadPixels = integrals.deadPixels;
    }
    if (options.scale != 1) {
        for (float& value : projections.values) value *= float(options.scale);
        projections.saturation *= float(options.scale);
    }
    if (options.saturation) projections.saturation = float(*options.saturation);
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

void addWarnings(const ScanOptions& options, const MeasuredScan& measured, Scan& scan) {
    const bool ownPitch = !options.geometry.file.empty() && !options.geometry.pitch;
    for (const auto& warning :
         {detectorBeforeAxis(options.geometry),
          ownPitch ? pitchWarning(measured, scan.geometry) : std::optional<ScanWarning>(), deadPixelWarning(scan)})
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
    if (hdf5 && !(flat.empty() && dark.empty()))
        throw InvalidArgument(std::string(flat.empty() ? "dark" : "flat") + ": HDF5 files hold their own frames");
    if (!dark.empty() && flat.empty()) throw InvalidArgument("dark: needs `flat` as well");
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
    for (const float value : projections.values) {
        counts.notMeasured += std::isnan(value);
        counts.saturated += value >= projections.saturation;
    }
    return counts;
}

Scan readScan(const ScanOptions& options, const ProgressCallback& progress) {
    options.validate();
    Measured measured = readMeasured(options, progress);
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
    scan.found.anglesAssumed = geometry.file.empty() && !geometry.arc && measured.scan.angles.empty();
    scan.found.pitchAssumed = geometry.file.empty() && !geometry.pitch && !measured.scan.spacing;
    addWarnings(options, measured.scan, scan);
    return scan;
}

}  // namespace raysweep
