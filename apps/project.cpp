/// raysweep project: simulated X-rays of a volume.
#include "scan_options.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"
#include "raysweep/projector/project_grid.h"
#include "raysweep/scan/detector.h"
#include "raysweep/scan/geometry_io.h"
#include "raysweep/scan/projection_io.h"
#include "raysweep/scan/scan.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/statistics.h"
#include "raysweep/volume/voxel_check.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <memory>

namespace raysweep::apps {
namespace {

constexpr double kDark = 20;  ///< line integral that no photon gets through

struct ProjectArguments {
    CommonOptions common;
    ScanArguments scan;
    DetectorModel detector;
    std::string input, output, grid, geometryOutput;
    double extinction = 1;
};

void completeOptions(ProjectArguments& a) {
    if (!a.geometryOutput.empty()) requireFileOutput(a.geometryOutput, "--write-geometry");
    requireProjectionOutput(a.output, "--output");
    requireFactor(a.extinction, "--extinction");
    completeScanOptions(a.scan);
    requireWhole(a.scan);
    a.detector.seed = a.common.seed;
    try {
        a.detector.validate();
    } catch (const InvalidArgument& e) {
        usageError("project", e.what());
    }
}

nlohmann::ordered_json describe(const Projections& projections, double seconds) {
    double sum = 0;
    float most = 0;
    std::size_t saturated = 0;
    for (const float value : projections.values) {
        sum += value;
        most = std::max(most, value);
        saturated += value >= projections.saturation;
    }
    return {{"views", projections.views},
            {"width", projections.width},
            {"height", projections.height},
            {"seconds", seconds},
            {"seconds_per_view", seconds / projections.views},
            {"max", most},
            {"mean", sum / double(projections.values.size())},
            {"saturated", saturated}};
}

int run(const ProjectArguments& a) {
    const ThreadLimit limit = start(a.common);
    for (const std::string& path : projectionFiles(a.output, 1)) requireWritable(path);
    if (!a.geometryOutput.empty()) requireWritable(a.geometryOutput);
    const openvdb::FloatGrid::Ptr volume = selectDensity(readVdb(a.input), a.grid);
    checkFinite(*volume, volume->getName());
    const ProjectionGeometry geometry = scanGeometry(centeredAt(middleOf(*volume), a.scan.options));
    if (const auto unlikely = detectorBeforeAxis(a.scan.options)) warning(a.common, unlikely->message);

    TerminalProgress progress(a.common);
    const Timer timer;
    Projections projections = projectGrid(*volume, geometry, progress.callback());
    if (TerminalProgress::interrupted()) {
        message(a.common, "stopped; nothing was written");
        return kInterrupted;
    }
    for (float& value : projections.values) value *= float(a.extinction);
    requireFinite(projections.values, "the projections");
    const float thickest = *std::max_element(projections.values.begin(), projections.values.end());
    detect(projections, a.detector);
    const double seconds = timer.seconds();
    writeProjections(a.output, projections, pitchOf(geometry));
    if (!a.geometryOutput.empty()) writeGeometry(a.geometryOutput, geometry);
    const nlohmann::ordered_json report = describe(projections, seconds);
    if (a.detector.photons > 0 && thickest > kDark)
        warning(a.common, "the largest line integral is " + brief(thickest, 3) +
                              ": no photon comes through; a lower --extinction makes it like a measured one (2 to 6)");
    if (thickest == 0)
        warning(a.common, "all line integrals are 0: the rays miss the volume, or there is nothing in it");
    detail(a.common, std::to_string(projections.views) + " views, largest line integral " + brief(thickest, 3));
    writeReport(a.common, report);
    return kDone;
}

}  // namespace

void addProject(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("project", "X-ray a volume: line integrals of its density along all rays");
    const auto a = std::make_shared<ProjectArguments>();
    command->add_option("volume", a->input, "The .vdb file to X-ray")->required()->type_name("VOL.vdb");
    command->add_option("-o,--output", a->output, "Projections: one .mha file, or .exr pictures with numbers")
        ->required()
        ->type_name("PROJ.mha|.exr");
    command->add_option("--write-geometry", a->geometryOutput, "Also write where the rays ran")->type_name("FILE.json");
    command->add_option("--density", a->grid, "Grid to X-ray (default: density, else the only float grid)")
        ->type_name("NAME");
    command->add_option("--extinction", a->extinction, "Extinction per unit density, 1/world unit")
        ->capture_default_str();
    addScanOptions(*command, a->scan);
    command->option_defaults()->group("Detector");
    command->add_option("--axis-column", a->scan.options.axisColumn,
                        "Column onto which the axis falls (default: the middle)");
    command->add_option("--photons", a->detector.photons,
                        "Photons per pixel without object: adds Poisson noise (default: none)");
    command->add_option("--saturation", a->detector.saturation, "Largest line integral that the detector can tell");
    command->add_option("--bits", a->detector.bits,
                        "Round to 2^N levels between 0 and the largest value (default: not)");
    command->option_defaults()->group("Options");
    addCommonOptions(*command, a->common);
    reads(command->get_option("volume"));
    writes(command->get_option("--output"), [a](const std::string& path) { return projectionNames(path, a->scan); });
    writes(command->get_option("--write-geometry"));
    command->callback([a, &exitCode] {
        completeOptions(*a);
        exitCode = run(*a);
    });
}

}  // namespace raysweep::apps
