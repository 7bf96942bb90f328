/// raysweep ct: a volume from its X-rays.
#include "ct_input.h"
#include "plot.h"
#include "slices.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/parallel.h"
#include "raysweep/image/image_io.h"
#include "raysweep/projector/footprint.h"
#include "raysweep/projector/joseph.h"
#include "raysweep/reconstruct/fbp.h"
#include "raysweep/reconstruct/sart.h"
#include "raysweep/scan/line_integrals.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/statistics.h"
#include "raysweep/volume/voxel_check.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

namespace raysweep::apps {
namespace {

enum class Method { sart, osSart, sirt, fbp, fdk };

const std::map<std::string, Method> kMethods = {{"fbp", Method::fbp},
                                                {"fdk", Method::fdk},
                                                {"os-sart", Method::osSart},
                                                {"sart", Method::sart},
                                                {"sirt", Method::sirt}};
const std::map<std::string, ViewOrder> kOrders = {
    {"golden", ViewOrder::golden}, {"random", ViewOrder::random}, {"sequential", ViewOrder::sequential}};
const std::map<std::string, Support> kSupports = {{"auto", Support::automatic}, {"none", Support::none}};
const std::map<std::string, RampWindow> kWindows = {{"cosine", RampWindow::cosine},
                                                    {"hamming", RampWindow::hamming},
                                                    {"hann", RampWindow::hann},
                                                    {"ram-lak", RampWindow::ramLak},
                                                    {"shepp-logan", RampWindow::sheppLogan}};

constexpr int kLongest = 1 << 14;     ///< voxels along an axis
const std::string kFiltered = "fbp";  ///< --initial: start from filtered backprojection

/// What the user typed; empty text: not given.
struct CtArguments {
    CommonOptions common;
    CtInputArguments input;
    SartOptions sart;
    FbpOptions fbp;
    std::string output, method = "sart", order = "golden", support = "auto", window = "ram-lak";
    std::string size, center, initial, reference, plot, slices;
    std::optional<double> spacing;
    int subset = 0;  ///< os-sart: views that correct together
    bool nonNegative = false, half = false;
};

bool isDirect(Method method) {
    return method == Method::fbp || method == Method::fdk;
}

bool isVdb(const std::string& path) {
    return lowerExtension(path) == ".vdb";
}

void addMethodOptions(CLI::App& app, CtArguments& a) {
    app.option_defaults()->group("Method");
    app.add_option("--method", a.method,
                   "sart: view after view; os-sart: some together; sirt: all together; fbp, fdk (cones): in one step")
        ->check(CLI::IsMember(kMethods).description(""))
        ->type_name("sart|os-sart|sirt|fbp|fdk")
        ->capture_default_str();
    app.add_option("--iterations", a.sart.iterations, "Passes over all views")->capture_default_str();
    app.add_option("--relaxation", a.sart.relaxation, "Part of each correction that is made")->capture_default_str();
    app.add_option("--decay", a.sart.relaxationDecay, "Pass n, from 0, is relaxed by relaxation / (1 + decay n)")
        ->capture_default_str();
    app.add_option("--order", a.order, "In which order views correct the volume")
        ->check(CLI::IsMember(kOrders).description(""))
        ->type_name("golden|random|sequential")
        ->capture_default_str();
    app.add_option("--subset", a.subset, "os-sart: views that correct together (default: a tenth of them)");
    app.add_flag("--nonnegative", a.nonNegative, "No voxel below 0");
    app.add_option("--upper", a.sart.upper, "No voxel above it, 1/world unit (default: none)");
    app.add_option("--tv", a.sart.totalVariation,
                   "After each pass lower the total variation, by steps of this part of what the pass changed")
        ->capture_default_str();
    app.add_option("--stop-residual", a.sart.stopResidual,
                   "Stop when line integrals are met to this part of their RMS; 0: never")
        ->capture_default_str();
    app.add_option("--support", a.support, "auto: only voxels that no view sees past are kept; none: all")
        ->check(CLI::IsMember(kSupports).description(""))
        ->type_name("auto|none")
        ->capture_default_str();
    app.add_option("--support-threshold", a.sart.supportThreshold,
                   "Line integrals up to this part of the largest are nothing")
        ->capture_default_str();
    app.add_option("--initial", a.initial, "Start from a volume, or from filtered backprojection")
        ->type_name("VOL.vdb|fbp");
    app.add_option("--window", a.window, "fbp, fdk: by what the ramp filter is softened")
        ->check(CLI::IsMember(kWindows).description(""))
        ->type_name("ram-lak|shepp-logan|cosine|hamming|hann")
        ->capture_default_str();
    app.add_option("--cutoff", a.fbp.cutoff,
                   "fbp, fdk: where the filter ends, part of the detector's highest frequency")
        ->capture_default_str();
}

void addOptions(CLI::App& app, CtArguments& a) {
    addCtInputOptions(app, a.input);
    app.add_option("-o,--output", a.output, "The .vdb file to write: a grid density, 1/world unit")
        ->required()
        ->type_name("VOL.vdb");
    addMethodOptions(app, a);
    app.option_defaults()->group("Volume");
    app.add_option("--size", a.size,
                   "Voxels along x, y, z (default: as --initial or --reference, else all that the detector sees)")
        ->type_name("X,Y,Z");
    app.add_option("--spacing", a.spacing,
                   "Edge of a voxel, world units (default: likewise, else a pixel's, seen at the axis)");
    app.add_option("--volume-center", a.center,
                   "Middle of the volume, world units (default: likewise, else 0,0,0 with --size)")
        ->type_name("X,Y,Z");
    app.add_option("--tolerance", a.sart.tolerance, "Voxels this close to 0 are left out")->capture_default_str();
    app.add_flag("--half", a.half, "Save as half floats");
    app.option_defaults()->group("Pictures and checks");
    app.add_option("--reference", a.reference, "What it should be: adds its RMS difference to report and plot")
        ->type_name("VOL.vdb");
    app.add_option("--plot", a.plot, "Residual and RMS difference against updates, .svg or .png")->type_name("FILE");
    app.add_option("--history", a.sart.historyEvery,
                   "Updates from one point of the histories in report and plot to the next; 0: one a pass")
        ->capture_default_str();
    app.add_option("--slices", a.slices, "Slices through the middle, as a picture")->type_name("FILE.png|.exr");
    app.option_defaults()->group("Options");
    addCommonOptions(app, a.common);
}

/// Everything that can be said to be wrong before a file is read.
void completeOptions(CtArguments& a, const CLI::App& command) {
    requireFileOutput(a.output);
    if (!isVdb(a.output)) usageError("--output", "'" + a.output + "' must end in .vdb");
    if (!a.initial.empty() && a.initial != kFiltered && !isVdb(a.initial))
        usageError("--initial", "'" + a.initial + "' must be a .vdb file, or " + kFiltered);
    completeOptions(a.input);
    const Method method = kMethods.at(a.method);
    if (isDirect(method)) {
        for (const char* name :
             {"--iterations", "--relaxation", "--decay", "--order", "--subset", "--upper", "--tv", "--stop-residual",
              "--support", "--support-threshold", "--initial", "--plot", "--history"})
            if (command.count(name) > 0) usageError(name, "is for iterative methods, not for " + a.method);
    } else if (a.initial != kFiltered && (command.count("--window") > 0 || command.count("--cutoff") > 0)) {
        usageError(command.count("--window") > 0 ? "--window" : "--cutoff", "is for fbp and fdk");
    }
    if (command.count("--subset") > 0 && method != Method::osSart) usageError("--subset", "is for os-sart");
    if (command.count("--subset") > 0 && a.subset < 1) usageError("--subset", "must be at least 1");
    if (!a.slices.empty() && imageFormat(a.slices) == ImageFormat::Unknown)
        usageError("--slices", "'" + a.slices + "' must end in .png or .exr");
    if (a.spacing && !(*a.spacing > 0 && std::isfinite(*a.spacing))) usageError("--spacing", "must be positive");
    if (!a.size.empty()) parseWhole(a.size, "--size", 3, 1, kLongest, "256,256,110");
    a.sart.order = kOrders.at(a.order);
    a.sart.support = kSupports.at(a.support);
    a.sart.seed = a.common.seed;
    a.fbp.window = kWindows.at(a.window);
    a.fbp.nonNegative = a.nonNegative;
    a.fbp.tolerance = float(a.sart.tolerance);
    if (a.nonNegative) a.sart.lower = 0;
    try {
        a.sart.validate();
        a.fbp.validate();
    } catch (const InvalidArgument& e) {
        usageError("ct", e.what());
    }
}

/// Volumes that were given; null: not.
struct GivenVolumes {
    openvdb::FloatGrid::Ptr initial, reference;

    /// The one that says where things are, if any.
    const openvdb::FloatGrid* frame() const { return initial ? initial.get() : reference.get(); }
};

openvdb::FloatGrid::Ptr readVolume(const std::string& path) {
    if (path.empty()) return nullptr;
    const openvdb::FloatGrid::Ptr grid = selectDensity(readVdb(path));
    checkFinite(*grid, path);
    if (grid->evalActiveVoxelBoundingBox().empty()) throw InvalidArgument("'" + path + "' has no active voxels");
    return grid;
}

/// `grid` moved by less than a voxel, to where its voxels are those of `frame`.
Vec3 snapped(const ReconstructionGrid& grid, const openvdb::FloatGrid& frame) {
    const Vec3 first = grid.voxel(0, 0, 0);
    const openvdb::Coord nearest = openvdb::Coord::round(frame.worldToIndex(openvdb::Vec3d(first.x, first.y, first.z)));
    const openvdb::Vec3d place = frame.indexToWorld(nearest);
    return grid.center + Vec3(place.x(), place.y(), place.z()) - first;
}

/// All that the detector sees; nothing if views are not those of a turn.
std::optional<ReconstructionGrid> seenGrid(const ProjectionGeometry& geometry) {
    try {
        return coveringGrid(geometry);
    } catch (const InvalidArgument&) {
        return {};
    }
}

/// In how many views the grid falls onto the detector. @throw InvalidArgument if in none.
int viewsSeeing(const ProjectionGeometry& geometry, const ReconstructionGrid& grid) {
    const auto transform = grid.transform();
    const openvdb::CoordBBox box(openvdb::Coord(0), openvdb::Coord(grid.dims.x - 1, grid.dims.y - 1, grid.dims.z - 1));
    return requireSeen(geometry, columnLattice(box, *transform, columnAxisFor(geometry, *transform)));
}

/// Volumes that this machine cannot hold. Of those that are swept, only what no view looks past is held.
void requireRoom(const ReconstructionGrid& grid, bool whole) {
    constexpr double kLeast = 1.0 / 16;  // the part of a grid that an object takes up at the least
    const double bytes = double(grid.dims.x) * grid.dims.y * grid.dims.z * sizeof(float);
    if (bytes * (whole ? 1 : kLeast) <= double(physicalBytes())) return;
    throw InvalidArgument("a volume of " + std::to_string(grid.dims.x) + "x" + std::to_string(grid.dims.y) + "x" +
                          std::to_string(grid.dims.z) + " voxels has " + std::to_string(std::size_t(bytes / 1e9)) +
                          " GB, this machine " + std::to_string(physicalBytes() / 1000000000) +
                          " GB; use larger voxels, or a smaller --size");
}

/// Where to reconstruct: what the user says; else as a volume that was given; else all that the detector sees.
ReconstructionGrid gridFor(const CtArguments& a, const ProjectionGeometry& geometry, const openvdb::FloatGrid* frame) {
    ReconstructionGrid grid;
    if (frame) {
        const openvdb::Coord dims = frame->evalActiveVoxelBoundingBox().dim();
        grid = {Index3(dims.x(), dims.y(), dims.z()), middleOf(*frame), frame->voxelSize()[0]};
    } else if (a.size.empty() || !a.spacing) {
        const std::optional<ReconstructionGrid> seen = seenGrid(geometry);
        // Why not is said by what needs a turn about an axis in any case.
        if (!seen && !isDirect(kMethods.at(a.method)))
            throw InvalidArgument(
                "the views are not those of a turn about an axis that is seen; give --size and --spacing");
        grid = seen ? *seen : coveringGrid(geometry);
    }
    const Vec3 extent = Vec3(grid.dims.x, grid.dims.y, grid.dims.z) * grid.spacing;
    if (a.spacing) grid.spacing = *a.spacing;
    if (!a.size.empty()) {
        const std::vector<int> size = parseWhole(a.size, "--size", 3, 1, kLongest, "256,256,110");
        grid.dims = Index3(size[0], size[1], size[2]);
        if (!frame) grid.center = Vec3(0);
    } else if (a.spacing) {
        for (int axis = 0; axis < 3; ++axis)
            grid.dims[axis] = int(std::clamp(std::round(extent[axis] / grid.spacing), 1.0, double(kLongest)));
    }
    if (!a.center.empty())
        grid.center = parseVec3(a.center, "--volume-center");
    else if (frame)
        grid.center = snapped(grid, *frame);
    return grid;
}

struct Reconstruction {
    openvdb::FloatGrid::Ptr volume;
    SartResult iterative;  ///< its volume is taken away; nothing else in it for direct methods
    double seconds = 0;
    int viewsSeeing = 0;  ///< in which the volume falls onto the detector
    bool interrupted = false;
};

/// Filtered backprojection needs a value for every ray.
openvdb::FloatGrid::Ptr filtered(const CtArguments& a, const CtInput& input, const ReconstructionGrid& grid,
                                 const ProgressCallback& progress) {
    if (input.saturated > 0)
        warning(a.common, std::to_string(input.saturated) +
                              " saturated values are taken as if they were measured; "
                              "iterative methods know better");
    const std::string amiss = scanWarning(input.geometry);
    if (!amiss.empty()) warning(a.common, amiss);
    if (input.notMeasured == 0) return filteredBackprojection(input.projections, input.geometry, grid, a.fbp, progress);
    Projections complete = input.projections;
    fillUnmeasured(complete);
    return filteredBackprojection(complete, input.geometry, grid, a.fbp, progress);
}

Reconstruction reconstruct(CtArguments& a, const CtInput& input, const ReconstructionGrid& grid,
                           const GivenVolumes& given) {
    const Method method = kMethods.at(a.method);
    const bool directFirst = a.initial == kFiltered;
    SartVolumes volumes{given.initial, given.reference};
    const int views = input.projections.views;
    a.sart.viewsPerUpdate = method == Method::sart   ? 1
                            : method == Method::sirt ? 0
                            : a.subset > 0           ? a.subset
                                                     : std::max(1, views / 10);

    TerminalProgress progress(a.common);
    const Timer timer;
    Reconstruction result;
    result.viewsSeeing = viewsSeeing(input.geometry, grid);
    requireRoom(grid, isDirect(method) || directFirst || given.reference || a.sart.support == Support::none);
    if (isDirect(method) || directFirst) volumes.initial = filtered(a, input, grid, progress.callback());
    if (isDirect(method)) {
        result.volume = std::const_pointer_cast<openvdb::FloatGrid>(volumes.initial);
        result.interrupted = TerminalProgress::interrupted();
    } else {
        result.iterative = sart(input.projections, input.geometry, grid, a.sart, volumes, progress.callback());
        result.volume = result.iterative.volume;
        result.interrupted = result.iterative.termination == SartTermination::interrupted;
    }
    result.seconds = timer.seconds();
    return result;
}

/// Signs that lengths were mixed up.
void commentOnScale(const CtArguments& a, const ProjectionGeometry& geometry, const ReconstructionGrid& grid,
                    const openvdb::FloatGrid& volume) {
    constexpr double kApart = 4;   // between spacings, as a factor
    constexpr double kOpaque = 4;  // optical depth of a voxel: no scan has one that stops 98 % of the rays
    const std::optional<ReconstructionGrid> seen = seenGrid(geometry);
    if (seen && (grid.spacing > kApart * seen->spacing || grid.spacing < seen->spacing / kApart))
        warning(a.common,
                "voxels are " + brief(grid.spacing / seen->spacing) +
                    " times as large as the detector's pixels, seen at the axis; are --spacing, --pitch and the "
                    "geometry in the same unit (mm, cm)?");
    const ValueRange range = valueRange(volume);
    if (!range.max.empty() && range.max[0] * grid.spacing > kOpaque)
        warning(a.common, "a single voxel would stop up to " +
                              brief(100 * (1 - std::exp(-range.max[0] * grid.spacing)), 3) +
                              " % of the rays: densities as large as " + brief(range.max[0]) +
                              " per world unit suggest that lengths were given in the wrong unit (mm, cm), or that the "
                              "input does not hold line integrals");
}

void comment(const CtArguments& a, const CtInput& input, const Reconstruction& result) {
    const int views = input.projections.views;
    if (2 * result.viewsSeeing < views)
        warning(a.common, "the volume falls onto the detector in " + std::to_string(result.viewsSeeing) + " of " +
                              std::to_string(views) + " views only; check --volume-center and the geometry");
    if (result.volume->empty())
        warning(a.common, "the volume is empty: no line integral is above 0, or none of its rays meets the volume");
    if (2 * input.deadPixels > input.projections.pixelsPerView())
        warning(a.common, std::to_string(input.deadPixels) + " of " +
                              std::to_string(input.projections.pixelsPerView()) +
                              " pixels are dead; are --flat and --dark what they should be?");
    if (input.deadPixels > 0) detail(a.common, std::to_string(input.deadPixels) + " dead pixels were left out");
    if (!result.iterative.history.empty()) {
        const SartPoint& last = result.iterative.history.back();
        detail(a.common, std::to_string(last.updates) + " updates; residual " + brief(last.residual, 3) +
                             (std::isnan(last.rms) ? "" : ", RMS difference " + brief(last.rms, 4)));
    }
    if (result.interrupted) message(a.common, "stopped; '" + a.output + "' holds the volume so far");
}

/// Over all voxels of the grid, as SartPoint::rms; where voxels do not coincide, as `raysweep compare`.
double rmsOf(const openvdb::FloatGrid& volume, const openvdb::FloatGrid& reference, const Index3& dims) {
    const auto place = [&](const openvdb::Coord& voxel) { return reference.worldToIndex(volume.indexToWorld(voxel)); };
    const openvdb::Coord shift = openvdb::Coord::round(place(openvdb::Coord(0)));
    const openvdb::Coord last(dims.x - 1, dims.y - 1, dims.z - 1);
    if (!((place(openvdb::Coord(0)) - shift.asVec3d()).length() < 1e-3) ||
        !((place(last) - (last + shift).asVec3d()).length() < 1e-3))
        return compareGrids(volume, reference).rmse;
    const double sum = orderedSum<double>(
        std::size_t(dims.x),
        [&](std::size_t x) {
            const auto is = volume.getConstAccessor(), shouldBe = reference.getConstAccessor();
            double squares = 0;
            for (int y = 0; y < dims.y; ++y)
                for (int z = 0; z < dims.z; ++z) {
                    const openvdb::Coord voxel(int(x), y, z);
                    const double difference = double(is.getValue(voxel)) - shouldBe.getValue(voxel + shift);
                    squares += difference * difference;
                }
            return squares;
        },
        4);
    return std::sqrt(sum / (double(dims.x) * dims.y * dims.z));
}

nlohmann::ordered_json describe(const CtArguments& a, const CtInput& input, const ReconstructionGrid& grid,
                                const Reconstruction& result, const GivenVolumes& given, double readSeconds,
                                std::size_t peakBytes) {
    const SartResult& iterative = result.iterative;
    nlohmann::ordered_json json = {{"method", a.method},
                                   {"dims", {grid.dims.x, grid.dims.y, grid.dims.z}},
                                   {"spacing", grid.spacing},
                                   {"voxels_active", result.volume->activeVoxelCount()},
                                   {"seconds", readSeconds + result.seconds},
                                   {"timings", {{"read", readSeconds}, {"reconstruct", result.seconds}}},
                                   {"peak_bytes", peakBytes},
                                   {"input", input.report()}};
    if (isDirect(kMethods.at(a.method))) {
        json["termination"] = result.interrupted ? "interrupted" : "done";
        if (given.reference) json["rms"] = rmsOf(*result.volume, *given.reference, grid.dims);
        return json;
    }
    json["updates"] = iterative.updates;
    json["seconds_per_update"] = iterative.updates > 0 ? iterative.seconds / iterative.updates : 0.0;
    json["voxels_kept"] = iterative.keptVoxels;
    json["termination"] = result.interrupted                                   ? "interrupted"
                          : iterative.termination == SartTermination::residual ? "residual"
                                                                               : "iterations";
    json["updates_history"] = nlohmann::ordered_json::array();
    for (const SartPoint& point : iterative.history) json["updates_history"].push_back(point.updates);
    json["residual_history"] = nlohmann::ordered_json::array();
    for (const SartPoint& point : iterative.history) json["residual_history"].push_back(point.residual);
    if (given.reference) {
        json["rms_history"] = nlohmann::ordered_json::array();
        for (const SartPoint& point : iterative.history) json["rms_history"].push_back(point.rms);
    }
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

int run(CtArguments& a) {
    const ThreadLimit limit = start(a.common);
    requireWritable(a.output);
    if (!a.plot.empty()) requirePlot(a.plot);
    if (!a.slices.empty()) requireWritable(a.slices);

    resetPeak();
    const std::size_t before = residentBytes();
    const Timer timer;
    const GivenVolumes given{a.initial == kFiltered ? nullptr : readVolume(a.initial), readVolume(a.reference)};
    const CtInput input = [&] {
        TerminalProgress progress(a.common);
        return readCtInput(a.input, a.common, given.frame() ? middleOf(*given.frame()) : Vec3(0), progress.callback());
    }();
    if (!input.complete || TerminalProgress::interrupted()) {
        message(a.common, "stopped; nothing was written");
        return kInterrupted;
    }
    const double readSeconds = timer.seconds();
    const ReconstructionGrid grid = gridFor(a, input.geometry, given.frame());
    const Reconstruction result = reconstruct(a, input, grid, given);
    const std::size_t peak = peakResidentBytes();
    if (result.interrupted && result.volume->empty()) {
        message(a.common, "stopped before there was anything to write");
        return kInterrupted;
    }

    result.volume->setSaveFloatAsHalf(a.half);
    if (a.half && clampForHalf(*result.volume) > 0) warning(a.common, "values beyond half floats were set to 65504");
    result.volume->insertMeta("raysweep_version", openvdb::StringMetadata(RAYSWEEP_VERSION));
    writeVdb(a.output, {result.volume});
    commentOnScale(a, input.geometry, grid, *result.volume);
    comment(a, input, result);
    writeReport(a.common, describe(a, input, grid, result, given, readSeconds, peak > before ? peak - before : 0));
    if (!a.slices.empty()) writeImage(a.slices, middleSlices(*result.volume, grid.dims));
    if (!a.plot.empty()) plotHistory(a.plot, result.iterative.history);
    return result.interrupted ? kInterrupted : kDone;
}

}  // namespace

void addCt(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("ct", "Reconstruct a volume from its X-rays");
    const auto arguments = std::make_shared<CtArguments>();
    addOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        completeOptions(*arguments, *command);
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
