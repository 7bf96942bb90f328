#include "ct_options.h"
#include "hints.h"
#include "volume_output.h"

#include "raysweep/formats/dense_files.h"
#include "raysweep/image/image_io.h"

#include <map>

namespace raysweep::apps {
namespace {

using Method = ReconstructionMethod;

const std::map<std::string, Method> kMethods = {{"fbp", Method::fbp},
                                                {"fdk", Method::fbp},
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

const std::string kAuto = "auto";     ///< --axis-column: found
const std::string kFiltered = "fbp";  ///< --initial: start from filtered backprojection

void addInputOptions(CLI::App& app, CtArguments& a) {
    app.add_option(
           "projections", a.scan.projections,
           "Projections: MetaImage or NRRD (columns, rows, views), pictures (TIFF, EXR) or a folder of them, one "
           "for each view, or HDF5 in the Data Exchange layout")
        ->required()
        ->type_name("PROJ");
    addScanOptions(app, a.geometry);
    app.option_defaults()->group("Geometry");
    app.add_option("--axis-column", a.axisColumn,
                   "Detector column onto which the axis falls, 0 is the middle of the first; auto: found from opposite "
                   "views (default: the middle, auto for HDF5)")
        ->type_name("COLUMN|auto");
    app.option_defaults()->group("Measurement");
    app.add_option("--flat", a.scan.flat,
                   "What is counted without object, of which PROJ's counts make line integrals: frames, a number, or "
                   "auto, as at the detector's sides; none: PROJ holds line integrals (default: HDF5's own, else none)")
        ->type_name("FILE|NUMBER|auto|none");
    app.add_option("--dark", a.scan.dark, "What is counted without beam (default: HDF5's own, else 0)")
        ->type_name("FILE|NUMBER|none");
    app.add_flag("--unsigned-counts", a.scan.unsignedCounts,
                 "Integers with a sign hold counts without one: those below 0 are meant 2^bits larger");
    app.add_option("--saturated-above", a.scan.saturatedAbove,
                   "Counts from which on the detector is over-exposed: line integrals are at most what they say "
                   "(default: where the numbers end); of line integrals the same as --saturation");
    app.add_flag("--sinograms", a.sinograms,
                 "Rows of each picture are views, of one detector row (a single picture is taken so by itself)");
    app.add_option("--rows", a.rows,
                   "HDF5: these detector rows only, first to last; --center-row counts from the first of them")
        ->type_name("R0,R1");
    app.add_option("--scale", a.scan.scale, "Factor on line integrals")->type_name("X");
    app.add_option("--saturation", a.scan.saturation, "Line integrals at or above it say only: at least as much");
    app.add_flag("--dead-pixels", a.scan.findDeadPixels, "Look for pixels that do not measure, and leave them out");
    app.add_option("--ring-filter", a.scan.ringWindow,
                   "Take out what makes rings narrower than half of so many columns (9 is a good start)")
        ->type_name("COLUMNS");
    app.add_flag("--repair", a.scan.repair, "Leave out values that are infinite or not a number, instead of an error");
    app.option_defaults()->group("Options");
}

void addMethodOptions(CLI::App& app, CtArguments& a) {
    app.option_defaults()->group("Method");
    app.add_option("--method", a.method,
                   "sart: view after view; os-sart: some together; sirt: all together; fbp, fdk (cones): in one step")
        ->check(CLI::IsMember(kMethods).description(""))
        ->type_name("sart|os-sart|sirt|fbp|fdk")
        ->capture_default_str();
    app.add_option("--iterations", a.reconstruct.sart.iterations, "Passes over all views")->capture_default_str();
    app.add_option("--relaxation", a.reconstruct.sart.relaxation, "Part of each correction that is made")
        ->capture_default_str();
    app.add_option("--decay", a.reconstruct.sart.relaxationDecay,
                   "Pass n, from 0, is relaxed by relaxation / (1 + decay n)")
        ->capture_default_str();
    app.add_option("--order", a.order, "In which order views correct the volume")
        ->check(CLI::IsMember(kOrders).description(""))
        ->type_name("golden|random|sequential")
        ->capture_default_str();
    app.add_option("--subset", a.reconstruct.subset, "os-sart: views that correct together (default: a tenth of them)");
    app.add_flag("--nonnegative", a.nonNegative, "No voxel below 0");
    app.add_option("--upper", a.reconstruct.sart.upper, "No voxel above it, 1/world unit (default: none)");
    app.add_option("--tv", a.reconstruct.sart.totalVariation,
                   "After each pass lower the total variation, by steps of this part of what the pass changed")
        ->capture_default_str();
    app.add_option("--stop-residual", a.reconstruct.sart.stopResidual,
                   "Stop when line integrals are met to this part of their RMS; 0: never")
        ->capture_default_str();
    app.add_option("--support", a.support, "auto: only voxels that no view sees past are kept; none: all")
        ->check(CLI::IsMember(kSupports).description(""))
        ->type_name("auto|none")
        ->capture_default_str();
    app.add_option("--support-threshold", a.reconstruct.sart.supportThreshold,
                   "Line integrals up to this part of the largest are nothing")
        ->capture_default_str();
    app.add_option("--initial", a.initial, "Start from a volume, or from filtered backprojection")
        ->type_name("VOL.vdb|fbp");
    app.add_option("--window", a.window, "fbp, fdk: by what the ramp filter is softened")
        ->check(CLI::IsMember(kWindows).description(""))
        ->type_name("ram-lak|shepp-logan|cosine|hamming|hann")
        ->capture_default_str();
    app.add_option("--cutoff", a.reconstruct.fbp.cutoff,
                   "fbp, fdk: where the filter ends, part of the detector's highest frequency")
        ->capture_default_str();
}

void completeScan(CtArguments& a) {
    if (isHdf5(a.scan.projections.front()) && a.geometry.options.file.empty() && a.geometry.cone.empty())
        a.geometry.parallel = true;
    if (a.axisColumn == kAuto) {
        if (!a.geometry.parallel) usageError("--axis-column", "auto is for parallel beams");
        a.scan.axisSearch = AxisSearch::always;
    } else if (!a.axisColumn.empty()) {
        a.geometry.options.axisColumn = parseNumber(a.axisColumn, "--axis-column", "296.5");
    }
    completeScanOptions(a.geometry);
    if (!a.rows.empty()) {
        const std::vector<int> ends = parseWhole(a.rows, "--rows", 2, {0, 1 << 20}, "100,199");
        a.scan.rows = RowRange{ends[0], ends[1]};
    }
    if (a.sinograms) a.scan.sinograms = Sinograms::always;
    a.scan.geometry = a.geometry.options;
}

/// S, or X,Y,Z
Vec3 parseSpacing(const std::string& text) {
    const std::vector<double> edges = parseNumbers(text, "--spacing", 1, 3, "0.5 or 0.5,0.5,2");
    if (edges.size() == 2) usageError("--spacing", "'" + text + "': one number or three are needed");
    return edges.size() == 1 ? Vec3(edges[0]) : Vec3(edges[0], edges[1], edges[2]);
}

/// Options that mean nothing to the method.
void requireFittingOptions(const CtArguments& a, const CLI::App& command) {
    const Method method = kMethods.at(a.method);
    if (method == Method::fbp) {
        for (const char* name :
             {"--iterations", "--relaxation", "--decay", "--order", "--subset", "--upper", "--tv", "--stop-residual",
              "--support", "--support-threshold", "--initial", "--plot", "--history", "--record"})
            if (command.count(name) > 0) usageError(name, "is for iterative methods, not for " + a.method);
    } else if (a.initial != kFiltered && (command.count("--window") > 0 || command.count("--cutoff") > 0)) {
        usageError(command.count("--window") > 0 ? "--window" : "--cutoff", "is for fbp and fdk");
    }
    if (command.count("--subset") > 0 && method != Method::osSart) usageError("--subset", "is for os-sart");
    if (command.count("--subset") > 0 && a.reconstruct.subset < 1) usageError("--subset", "must be at least 1");
}

void completeReconstruction(CtArguments& a) {
    ReconstructOptions& options = a.reconstruct;
    options.method = kMethods.at(a.method);
    options.startFiltered = a.initial == kFiltered;
    if (options.startFiltered) a.initial.clear();
    options.sart.order = kOrders.at(a.order);
    options.sart.support = kSupports.at(a.support);
    options.sart.seed = a.common.seed;
    if (a.nonNegative) options.sart.lower = 0;
    options.fbp.window = kWindows.at(a.window);
    options.fbp.nonNegative = a.nonNegative;
    options.fbp.tolerance = float(options.sart.tolerance);
    if (!a.size.empty()) {
        const std::vector<int> size = parseWhole(a.size, "--size", 3, {1, kMostVoxelsAlong}, "256,256,110");
        options.grid.dims = Index3(size[0], size[1], size[2]);
    }
    if (!a.spacing.empty()) options.grid.spacing = parseSpacing(a.spacing);
    if (!a.center.empty()) options.grid.center = parseVec3(a.center, "--volume-center");
}

}  // namespace

void addCtOptions(CLI::App& app, CtArguments& a) {
    addInputOptions(app, a);
    app.add_option(
           "-o,--output", a.output,
           "Volume to write, densities in 1/world unit: .vdb (a grid density), .mha, .nrrd, .nii, .nii.gz, or a "
           "folder for .tif slices (a name without an ending, or one with a slash at its end; replaced as a "
           "whole)")
        ->required()
        ->type_name("VOL");
    addMethodOptions(app, a);
    app.option_defaults()->group("Volume");
    app.add_option("--size", a.size,
                   "Voxels along x, y, z (default: as --initial or --reference, else all that the detector sees)")
        ->type_name("X,Y,Z");
    app.add_option("--spacing", a.spacing,
                   "Edge of a voxel, or its edges along x, y, z, world units (default: likewise, else a pixel's, seen "
                   "at the axis)")
        ->type_name("S|X,Y,Z");
    app.add_option("--volume-center", a.center,
                   "Middle of the volume, world units (default: likewise, else of what the detector sees)")
        ->type_name("X,Y,Z");
    app.add_option("--tolerance", a.reconstruct.sart.tolerance, "Voxels this close to 0 are left out")
        ->capture_default_str();
    app.add_flag("--half", a.half, "Save as half floats");
    app.option_defaults()->group("Pictures and checks");
    app.add_option("--reference", a.reference, "What it should be: adds its RMS difference to report and plot")
        ->type_name("VOL.vdb");
    app.add_option("--plot", a.plot, "Residual and RMS difference against updates, .svg or .png")->type_name("FILE");
    app.add_option("--history", a.reconstruct.sart.historyEvery,
                   "Updates from one point of the histories in report and plot to the next; 0: one a pass")
        ->capture_default_str();
    app.add_option("--slices", a.slices, "Slices through the middle, as a picture")->type_name("FILE.png|.exr");
    app.add_option("--record", a.record,
                   "Write all that it takes to make the same updates again, to this file and to RUN.vdb beside it")
        ->type_name("RUN.json");
    for (const char* name : {"projections", "--flat", "--dark", "--initial", "--reference"})
        reads(app.get_option(name));
    for (const char* name : {"--plot", "--slices"}) writes(app.get_option(name));
    writesOrFills(app.get_option("--output"),
                  [](const std::string& value) { return denseFormat(value) == DenseFormat::tiffFolder; });
    writes(app.get_option("--record"), recordFiles);
    app.option_defaults()->group("Options");
    addCommonOptions(app, a.common);
}

void completeOptions(CtArguments& a, const CLI::App& command) {
    requireVolumeOutput(a.output);
    if (a.half && !isVdb(a.output)) usageError("--half", "is for .vdb; other files have 32 bit floats");
    if (!a.initial.empty() && a.initial != kFiltered && !isVdb(a.initial))
        usageError("--initial", "'" + a.initial + "' must be a .vdb file, or " + kFiltered);
    if (!a.slices.empty() && imageFormat(a.slices) == ImageFormat::Unknown)
        usageError("--slices", "'" + a.slices + "' must end in .png or .exr");
    if (!a.record.empty()) requireRecordName(a.record);
    completeScan(a);
    requireFittingOptions(a, command);
    completeReconstruction(a);
    requireValid(command, [&] {
        a.scan.validate();
        a.reconstruct.validate();
    });
}

}  // namespace raysweep::apps
