/// raysweep ct: a volume from its X-rays.
#include "ct_options.h"
#include "hints.h"
#include "plot.h"
#include "volume_output.h"

#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/output_file.h"
#include "raysweep/formats/dense_files.h"
#include "raysweep/image/image_io.h"
#include "raysweep/reconstruct/sart_record.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/middle_slices.h"
#include "raysweep/volume/record_file.h"
#include "raysweep/volume/statistics.h"
#include "raysweep/volume/voxel_check.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <memory>

namespace raysweep::apps {
namespace {

openvdb::FloatGrid::Ptr readVolume(const std::string& path) {
    if (path.empty()) return nullptr;
    const openvdb::FloatGrid::Ptr grid = selectDensity(readVdb(path));
    checkFinite(*grid, path);
    if (grid->evalActiveVoxelBoundingBox().empty()) throw InvalidArgument("'" + path + "' has no active voxels");
    return grid;
}

/// Reads the volumes that were named into the options. @return the one that says where things are, if any.
openvdb::FloatGrid::ConstPtr readVolumes(CtArguments& a) {
    SartVolumes& volumes = a.reconstruct.volumes;
    volumes = {readVolume(a.initial), readVolume(a.reference)};
    return volumes.initial ? volumes.initial : volumes.reference;
}

Scan read(CtArguments& a) {
    if (const auto frame = readVolumes(a)) a.scan.geometry = centeredAt(middleOf(*frame), a.scan.geometry);
    TerminalProgress progress(a.common);
    return readScan(a.scan, progress.callback());
}

void comment(const CtArguments& a, const Scan& scan, const CLI::App& command) {
    const auto inOurWords = [&](const std::string& text) { return inWordsOf(command, InvalidArgument(text)); };
    if (const auto& axis = scan.found.axis)
        detail(a.common, "the axis falls onto column " + brief(axis->column, 5) + " (opposite views differ by " +
                             brief(100 * axis->mismatch) + " %)");
    for (const std::string& assumed : scan.found.assumptions) message(a.common, "assumed: " + inOurWords(assumed));
    for (const ScanWarning& unlikely : scan.found.warnings)
        warning(a.common, inOurWords(unlikely.message) + (unlikely.kind == ScanWarning::Kind::deadPixels
                                                              ? "; are --flat and --dark what they should be?"
                                                              : ""));
    if (scan.found.deadPixels > 0)
        detail(a.common, std::to_string(scan.found.deadPixels) + " dead pixels were left out");
}

bool isInterrupted(const Reconstruction& result) {
    return result.termination == ReconstructionTermination::interrupted;
}

void comment(const CtArguments& a, const Reconstruction& result) {
    for (const ReconstructionWarning& unlikely : result.warnings) warning(a.common, unlikely.message);
    if (!result.history.empty()) {
        const SartPoint& last = result.history.back();
        detail(a.common, std::to_string(last.updates) + " updates; " +
                             (std::isnan(last.residual) ? "no residual, as nothing was measured"
                                                        : "residual " + brief(last.residual, 3)) +
                             (std::isnan(last.rms) ? "" : ", RMS difference " + brief(last.rms, 4)));
    }
    if (isInterrupted(result)) message(a.common, "stopped; '" + a.output + "' holds the volume so far");
}

const char* nameOf(ReconstructionTermination termination) {
    switch (termination) {
        case ReconstructionTermination::done:
            return "done";
        case ReconstructionTermination::iterations:
            return "iterations";
        case ReconstructionTermination::residual:
            return "residual";
        default:
            return "interrupted";
    }
}

nlohmann::ordered_json describe(const Scan& scan) {
    nlohmann::ordered_json json = {{"format", scan.found.format},
                                   {"views", scan.projections.views},
                                   {"width", scan.projections.width},
                                   {"height", scan.projections.height},
                                   {"pixels_dead", scan.found.deadPixels},
                                   {"values_not_measured", scan.found.rays.notMeasured},
                                   {"values_implausible", scan.found.implausible},
                                   {"values_saturated", scan.found.rays.saturated},
                                   {"values_overexposed", scan.found.rays.overexposed},
                                   {"pixels_bounded", scan.found.rays.saturated + scan.found.rays.overexposed},
                                   {"assumed", scan.found.assumptions}};
    if (const auto& axis = scan.found.axis) {
        json["axis_column"] = axis->column;
        json["axis_mismatch"] = axis->mismatch;
    }
    return json;
}

/// What is not known is null.
template <class Value>
nlohmann::ordered_json historyOf(const Reconstruction& result, Value SartPoint::*value) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const SartPoint& point : result.history)
        json.push_back(std::isfinite(double(point.*value)) ? nlohmann::ordered_json(point.*value)
                                                           : nlohmann::ordered_json(nullptr));
    return json;
}

nlohmann::ordered_json describe(const CtArguments& a, const Scan& scan, const Reconstruction& result,
                                double readSeconds, std::size_t peakBytes) {
    const ReconstructionGrid& grid = result.grid;
    nlohmann::ordered_json json = {{"method", a.method},
                                   {"dims", {grid.dims.x, grid.dims.y, grid.dims.z}},
                                   {"center", {grid.center.x, grid.center.y, grid.center.z}},
                                   {"spacing", {grid.spacing.x, grid.spacing.y, grid.spacing.z}},
                                   {"voxels_active", result.volume->activeVoxelCount()},
                                   {"rows_cut", result.rowsCut},
                                   {"seconds", readSeconds + result.seconds.total},
                                   {"timings", {{"read", readSeconds}, {"reconstruct", result.seconds.total}}},
                                   {"peak_bytes", peakBytes},
                                   {"input", describe(scan)}};
    if (result.fieldRadius > 0) json["field_radius"] = result.fieldRadius;
    const bool compared = a.reconstruct.volumes.reference != nullptr;
    if (a.reconstruct.method == ReconstructionMethod::fbp) {
        json["termination"] = nameOf(result.termination);
        if (compared) json["rms"] = result.rms;
        return json;
    }
    json["updates"] = result.updates;
    json["seconds_per_update"] = result.updates > 0 ? result.seconds.updates / result.updates : 0.0;
    json["voxels_kept"] = result.keptVoxels;
    json["termination"] = nameOf(result.termination);
    json["updates_history"] = historyOf(result, &SartPoint::updates);
    json["residual_history"] = historyOf(result, &SartPoint::residual);
    if (compared) json["rms_history"] = historyOf(result, &SartPoint::rms);
    return json;
}

void plotHistory(const std::string& path, const std::vector<SartPoint>& history) {
    Curve residual{"residual / RMS of the line integrals", {}}, rms{"RMS difference to the reference", {}};
    for (const SartPoint& point : history) {
        residual.points.emplace_back(point.updates, point.residual);
        if (!std::isnan(point.rms)) rms.points.emplace_back(point.updates, point.rms);
    }
    plotCurves(path, {"updates", ""}, {residual, rms});
}

void requireOutputs(const CtArguments& a) {
    requireDenseOutput(a.output);  // or a .vdb
    if (!a.plot.empty()) requirePlot(a.plot);
    if (!a.slices.empty()) requireWritable(a.slices);
    if (!a.record.empty()) requireRecord(a.record);
}

/// A dense file has all voxels of `dims`, a .vdb those that are not nothing.
void write(const CtArguments& a, const openvdb::FloatGrid::Ptr& volume, const Index3& dims) {
    requireFiniteResult(*volume, kTooLarge);
    if (!isVdb(a.output)) {
        DenseSource source(volume, {IndexBox{Index3(0), dims - Index3(1)}, std::nullopt});
        return writeDense(a.output, source);
    }
    volume->setSaveFloatAsHalf(a.half);
    if (a.half && clampForHalf(*volume) > 0) warning(a.common, "values beyond half floats were set to 65504");
    volume->insertMeta("raysweep_version", openvdb::StringMetadata(RAYSWEEP_VERSION));
    writeVdb(a.output, {volume});
}

int run(CtArguments& a, const CLI::App& command) {
    const ThreadLimit limit = start(a.common);
    requireOutputs(a);

    resetPeak();
    const std::size_t before = residentBytes();
    const Timer timer;
    const Scan scan = read(a);
    if (!scan.complete || TerminalProgress::interrupted()) {
        message(a.common, "stopped; nothing was written");
        return kInterrupted;
    }
    const double readSeconds = timer.seconds();
    comment(a, scan, command);
    if (!a.record.empty()) requireRecordable(scan);
    SartRecord record;
    if (!a.record.empty()) a.reconstruct.sart.record = &record;
    const Reconstruction result = [&] {
        TerminalProgress progress(a.common);
        return reconstruct(scan, a.reconstruct, progress.callback());
    }();
    const std::size_t peak = peakResidentBytes();
    if (isInterrupted(result) && result.volume->empty()) {
        message(a.common, "stopped before there was anything to write");
        return kInterrupted;
    }

    write(a, result.volume, result.grid.dims);
    if (!a.record.empty()) writeRecord(a.record, record, scan);
    comment(a, result);
    writeReport(a.common, describe(a, scan, result, readSeconds, peak > before ? peak - before : 0));
    if (!a.slices.empty()) writeImage(a.slices, middleSlices(*result.volume, result.grid.dims));
    if (!a.plot.empty()) plotHistory(a.plot, result.history);
    return isInterrupted(result) ? kInterrupted : kDone;
}

}  // namespace

void addCt(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("ct", "Reconstruct a volume from its X-rays");
    const auto arguments = std::make_shared<CtArguments>();
    addCtOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        completeOptions(*arguments, *command);
        exitCode = run(*arguments, *command);
    });
}

}  // namespace raysweep::apps
