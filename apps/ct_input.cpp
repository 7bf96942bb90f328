#include "ct_input.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/scan/data_exchange.h"
#include "raysweep/scan/geometry_io.h"
#include "raysweep/scan/line_integrals.h"
#include "raysweep/scan/ring_filter.h"
#include "raysweep/scan/rotation_center.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace raysweep::apps {
namespace {

const std::string kAuto = "auto";

bool isHdf5(const std::string& path) {
    const std::string extension = lowerExtension(path);
    return extension == ".h5" || extension == ".hdf5" || extension == ".hdf" || extension == ".nxs";
}

/// What was read, before anything is done to it.
struct Measured {
    Projections values;
    MeasuredScan scan;
    std::vector<float> flat, dark;  ///< empty: `values` are line integrals already
    std::string format;
    bool complete = true;
};

/// The mean of all frames, for each pixel.
std::vector<float> meanFrame(const Projections& frames) {
    std::vector<float> mean(frames.pixelsPerView());
    for (std::size_t i = 0; i < mean.size(); ++i) {
        double sum = 0;
        for (int n = 0; n < frames.views; ++n) sum += frames.view(n)[i];
        mean[i] = float(sum / frames.views);
    }
    return mean;
}

Measured readHdf5(const CtInputArguments& a, const ProgressCallback& progress) {
    std::optional<RowRange> rows;
    if (!a.rows.empty()) {
        const std::vector<int> ends = parseWhole(a.rows, "--rows", 2, 0, 1 << 20, "100,199");
        rows = RowRange{ends[0], ends[1]};
    }
    DataExchange scan = readDataExchange(a.files[0], rows, progress);
    Measured measured;
    measured.values = std::move(scan.counts);
    measured.flat = std::move(scan.flat);
    measured.dark = std::move(scan.dark);
    measured.scan.angles = std::move(scan.angles);
    measured.format = "Data Exchange";
    measured.complete = scan.complete;
    return measured;
}

Measured readFiles(const CtInputArguments& a, const ProgressCallback& progress) {
    const ProjectionReadOptions options{a.repair};
    ProjectionFile file = readProjections(a.files, options, progress);
    Measured measured;
    measured.values = std::move(file.projections);
    measured.scan.spacing = file.spacing;
    measured.scan.origin = file.origin;
    measured.format = file.format;
    measured.complete = file.complete;
    if (!a.flat.empty()) {
        measured.flat = meanFrame(readProjections({a.flat}).projections);
        measured.dark = a.dark.empty() ? std::vector<float>(measured.flat.size())
                                       : meanFrame(readProjections({a.dark}).projections);
    }
    return measured;
}

/// Counts become line integrals; pixels that say nothing are left out.
void prepare(const CtInputArguments& a, Measured& measured, CtInput& input) {
    if (!measured.flat.empty()) {
        LineIntegrals integrals = lineIntegrals(std::move(measured.values), measured.flat, measured.dark);
        input.projections = std::move(integrals.projections);
        input.deadPixels = integrals.deadPixels;
    } else {
        input.projections = std::move(measured.values);
    }
    if (a.scale) {
        for (float& value : input.projections.values) value *= float(*a.scale);
        input.projections.saturation *= float(*a.scale);
    }
    if (a.saturation) input.projections.saturation = float(*a.saturation);
    if (a.deadPixels) input.deadPixels += markDeadPixels(input.projections);
    if (a.ringWindow > 0) filterRings(input.projections, RingFilterOptions{a.ringWindow});
    for (const float value : input.projections.values) {
        input.notMeasured += std::isnan(value);
        input.saturated += value >= input.projections.saturation;
    }
    if (input.notMeasured == input.projections.values.size())
        throw InvalidArgument("'" + a.files[0] + "': no ray was measured: all values are NaN or infinite, or of dead " +
                              "pixels");
}

/// Pixels that are not as far apart as the projections say, if the geometry has its own distances.
void commentOnPixels(const MeasuredScan& measured, const ProjectionGeometry& geometry, const CommonOptions& common) {
    constexpr double kSame = 0.01;                                             // relative
    if (!measured.spacing || *measured.spacing == DetectorPair{1, 1}) return;  // 1: also where a file says nothing
    const double column = geometry.views[0].column.length(), row = geometry.views[0].row.length();
    const double fileColumn = std::abs((*measured.spacing)[0]), fileRow = std::abs((*measured.spacing)[1]);
    if (std::abs(column / fileColumn - 1) > kSame || std::abs(row / fileRow - 1) > kSame)
        warning(common, "pixels are " + brief(column) + " x " + brief(row) + " apart in the geometry, but " +
                            brief(fileColumn) + " x " + brief(fileRow) +
                            " in the projections; are both in the same unit (mm, cm)?");
}

/// Degrees of each view, as far as options or the file say.
std::vector<double> anglesOf(const ScanArguments& scan, const MeasuredScan& measured) {
    if (!scan.arc && !measured.angles.empty()) return measured.angles;
    std::vector<double> angles;
    for (int n = 0; n < measured.views; ++n)
        angles.push_back(scan.firstAngle + scan.arc.value_or(180) * n / measured.views);
    return angles;
}

}  // namespace

void addCtInputOptions(CLI::App& app, CtInputArguments& a) {
    app.add_option(
           "projections", a.files,
           "Projections: MetaImage or NRRD (columns, rows, views), pictures (TIFF, EXR) or a folder of them, one "
           "for each view, or HDF5 in the Data Exchange layout")
        ->required()
        ->type_name("PROJ");
    addScanOptions(app, a.scan);
    app.option_defaults()->group("Geometry");
    app.add_option("--axis-column", a.axisColumn,
                   "Detector column onto which the axis falls, 0 is the middle of the first; auto: found from opposite "
                   "views (default: the middle, auto for HDF5)")
        ->type_name("COLUMN|auto");
    app.option_defaults()->group("Measurement");
    app.add_option("--flat", a.flat, "Frames without object: then PROJ holds counts, not line integrals")
        ->type_name("FILE");
    app.add_option("--dark", a.dark, "Frames without beam")->type_name("FILE");
    app.add_option("--rows", a.rows,
                   "HDF5: these detector rows only, first to last; --center-row counts from the first of them")
        ->type_name("R0,R1");
    app.add_option("--scale", a.scale, "Factor on line integrals")->type_name("X");
    app.add_option("--saturation", a.saturation, "Line integrals at or above it say only: at least as much");
    app.add_flag("--dead-pixels", a.deadPixels, "Look for pixels that do not measure, and leave them out");
    app.add_option("--ring-filter", a.ringWindow,
                   "Take out what makes rings narrower than half of so many columns (9 is a good start)")
        ->type_name("COLUMNS");
    app.add_flag("--repair", a.repair, "Leave out values that are infinite or not a number, instead of an error");
    app.option_defaults()->group("Options");
}

void completeOptions(CtInputArguments& a) {
    const bool hdf5 = isHdf5(a.files[0]);
    if (hdf5 && a.files.size() > 1) usageError("PROJ", "give one HDF5 file");
    if (hdf5 && (!a.flat.empty() || !a.dark.empty()))
        usageError("--flat", "HDF5 files hold their own flat and dark frames");
    if (!hdf5 && !a.rows.empty()) usageError("--rows", "is for HDF5 files");
    if (!a.dark.empty() && a.flat.empty()) usageError("--dark", "needs --flat as well");
    if (!a.rows.empty() && !a.scan.cone.empty() && !a.scan.centerRow)
        usageError("--rows", "with --cone needs --center-row, counted from the first of these rows");
    const auto requirePositive = [](const std::optional<double>& value, const char* option) {
        if (value && !(*value > 0 && std::isfinite(*value))) usageError(option, "must be positive and finite");
    };
    requirePositive(a.scale, "--scale");
    requirePositive(a.saturation, "--saturation");
    if (hdf5 && a.scan.geometry.empty() && a.scan.cone.empty()) a.scan.parallel = true;
    if (a.axisColumn.empty() && hdf5 && a.scan.parallel) a.axisColumn = kAuto;
    if (a.axisColumn == kAuto && !a.scan.parallel) usageError("--axis-column", "auto is for parallel beams");
    if (!a.axisColumn.empty() && a.axisColumn != kAuto)
        a.scan.axisColumn = parseNumber(a.axisColumn, "--axis-column", "296.5");
    if (a.ringWindow != 0) {
        try {
            RingFilterOptions{a.ringWindow}.validate();
        } catch (const InvalidArgument& e) {
            usageError("--ring-filter", e.what());
        }
    }
    checkScanOptions(a.scan);
}

CtInput readCtInput(const CtInputArguments& a, const CommonOptions& common, const Vec3& center,
                    const ProgressCallback& progress) {
    Measured measured = isHdf5(a.files[0]) ? readHdf5(a, progress) : readFiles(a, progress);
    CtInput input;
    input.format = measured.format;
    input.complete = measured.complete;
    if (!input.complete) return input;
    measured.scan.width = measured.values.width;
    measured.scan.height = measured.values.height;
    measured.scan.views = measured.values.views;
    prepare(a, measured, input);
    ScanArguments scan = a.scan;
    if (a.axisColumn == kAuto) {
        const RotationCenter center = findRotationCenter(input.projections, anglesOf(scan, measured.scan));
        scan.axisColumn = input.axisColumn = center.column;
        input.axisMismatch = center.mismatch;
        detail(common, "the axis falls onto column " + brief(center.column, 5) + " (opposite views differ by " +
                           brief(100 * center.mismatch) + " %)");
    }
    input.geometry = scanGeometry(scan, &measured.scan, center);
    requireMatching(input.geometry, input.projections);
    commentOnScan(a.scan, common);
    if (!a.scan.geometry.empty() && a.scan.pitch.empty()) commentOnPixels(measured.scan, input.geometry, common);
    return input;
}

nlohmann::ordered_json CtInput::report() const {
    nlohmann::ordered_json json = {{"format", format},
                                   {"views", projections.views},
                                   {"width", projections.width},
                                   {"height", projections.height},
                                   {"pixels_dead", deadPixels},
                                   {"values_not_measured", notMeasured},
                                   {"values_saturated", saturated}};
    if (axisColumn) {
        json["axis_column"] = *axisColumn;
        json["axis_mismatch"] = axisMismatch;
    }
    return json;
}

}  // namespace raysweep::apps
