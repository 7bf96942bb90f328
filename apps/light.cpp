/// raysweep light: lights a volume.
#include "light_options.h"
#include "plot.h"

#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/illuminate/illumination_record.h"
#include "raysweep/render/render.h"
#include "raysweep/scene/lit_file.h"
#include "raysweep/volume/checksum.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/record_file.h"
#include "raysweep/volume/resample.h"
#include "raysweep/volume/statistics.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <iostream>
#include <memory>
#include <sstream>

namespace raysweep::apps {
namespace {

constexpr double kManySweeps = 2000;  ///< several times what most scenes need

std::string exchangeName(const LightArguments& a, const Scene& scene) {
    if (a.options.exchange == Exchange::paper) return "paper";
    return planIllumination(scene, a.options).surfaces ? "surface" : "medium";
}

/// All grids of the input and what is written now.
void write(const std::string& path, const LightArguments& a, const SceneFromFile& scene, const VdbFile& input,
           const openvdb::GridPtrVec& lit) {
    const LitRecord record{a.commandLine, exchangeName(a, scene.scene), a.resolution, a.half};
    for (const Clamped& clamped : writeLit(path, input, scene, record, lit))
        warning(a.common, std::to_string(clamped.voxels) + " voxels of '" + clamped.grid +
                              "' are too bright for half floats and were set to 65504");
}

double mean(const double (&values)[kMaxChannels], int channels) {
    double sum = 0;
    for (int c = 0; c < channels; ++c) sum += values[c];
    return sum / channels;
}

const char* nameOf(Termination termination) {
    switch (termination) {
        case Termination::converged:
            return "converged";
        case Termination::sweepLimit:
            return "sweep limit";
        case Termination::interrupted:
            return "interrupted";
        case Termination::direct:
            return "direct light only";
    }
    return "";
}

/// What was modelled and why: what the options came to, and the solver's plan.
std::vector<std::string> reasonsOf(const SceneFromFile& scene, const Plan& plan) {
    std::vector<std::string> reasons = scene.origin.reasons;
    reasons.insert(reasons.end(), plan.reasons.begin(), plan.reasons.end());
    return reasons;
}

void addSkySuns(nlohmann::ordered_json& json, const SceneOrigin& origin) {
    if (!origin.skySuns) return;
    json["sky_suns"] = origin.skySuns->count;
    json["sky_suns_share"] = origin.skySuns->share;
}

nlohmann::ordered_json describe(const LightArguments& a, const SceneFromFile& scene, const Illumination& lit,
                                double readSeconds, double writeSeconds) {
    const int channels = lit.plan.channels, sweeps = lit.sweeps + lit.finishingSweeps;
    const double sweeping = lit.seconds.sweeps + (lit.finishingSweeps > 0 ? lit.seconds.finish : 0);
    const IlluminationTimings& spent = lit.seconds;
    nlohmann::ordered_json json = {
        {"voxels_active", lit.activeVoxels},
        {"sweeps", lit.sweeps},
        {"sweeps_finishing", lit.finishingSweeps},
        {"coarse_sweeps", lit.coarseSweeps},
        {"seconds", readSeconds + spent.prepare + spent.direct + spent.coarse + spent.sweeps + spent.finish +
                        spent.output + writeSeconds},
        {"seconds_per_sweep", sweeps > 0 ? sweeping / sweeps : 0.0},
        {"power_injected", mean(lit.power.injected, channels)},
        {"power_absorbed", mean(lit.power.absorbed, channels)},
        {"power_escaped", mean(lit.power.escaped, channels)},
        {"power_unshot", mean(lit.power.unshot, channels)},
        {"balance_error", lit.power.error()},
        {"converged", lit.termination == Termination::converged || lit.termination == Termination::direct},
        {"termination", nameOf(lit.termination)},
        {"plan", reasonsOf(scene, lit.plan)},
        {"peak_bytes", a.peakBytes},
        {"peak_bytes_per_voxel", double(a.peakBytes) / double(std::max<std::size_t>(1, lit.activeVoxels))},
        {"voxels_thick_share", lit.thickShare},
        {"voxels_surface", lit.surfaceVoxels},
        {"voxels_medium_furnace_share", lit.mediumFurnaceShare},
        {"voxels_white_furnace_share", lit.whiteFurnaceShare},
        {"resolution", a.resolution},
        {"options", a.commandLine}};
    addSkySuns(json, scene.origin);
    json["timings"] = {{"read", readSeconds},    {"prepare", spent.prepare}, {"direct", spent.direct},
                       {"coarse", spent.coarse}, {"sweeps", spent.sweeps},   {"finish", spent.finish},
                       {"output", spent.output}, {"write", writeSeconds}};
    json["rms_history"] = nlohmann::ordered_json::array();
    for (const ConvergencePoint& point : lit.history)
        json["rms_history"].push_back({{"sweep", point.sweep}, {"rms", point.rms}, {"unshot", point.unshotShare}});
    return json;
}

/// What --resolution means for this scene.
std::string describeResolution(const LightArguments& a, const Scene& scene, const Scene& solved) {
    return "resolution " + brief(a.resolution) + ": solved on voxels " + brief(1 / a.resolution) + " times as long, " +
           std::to_string(solved.medium.density->activeVoxelCount()) + " instead of " +
           std::to_string(scene.medium.density->activeVoxelCount()) + " active ones; radiosity is " +
           (a.upsample ? "interpolated to the voxels of the input" : "written on the longer voxels");
}

/// The plan for `solved`, which is `scene` at the resolution asked for, with a word on that.
Plan withResolution(Plan plan, const LightArguments& a, const Scene& scene, const Scene& solved) {
    if (a.resolution < 1) plan.reasons.push_back(describeResolution(a, scene, solved));
    return plan;
}

void comment(const LightArguments& a, const SceneFromFile& made, const Illumination& lit) {
    const SceneOrigin& origin = made.origin;
    const ValueRange densities = valueRange(*made.scene.medium.density);
    const float largestDensity = densities.max.empty() ? 0 : densities.max[0];
    if (lit.sweepsToReach > kManySweeps)
        warning(a.common, "the emitting voxels are so few that it takes about " + brief(lit.sweepsToReach) +
                              " sweeps until their light has been everywhere; --point would converge sooner");
    if (lit.thickShare > 0 && !lit.plan.surfaces)
        warning(a.common, brief(100 * lit.thickShare) +
                              " % of the voxels have an optical depth above 2, where the grid is too coarse to be "
                              "accurate; " +
                              (origin.classification ? "" : "a lower --extinction or ") +
                              (a.resolution < 1 ? "a higher --resolution helps" : "finer voxels help"));
    if (!origin.nothingOpaque.empty())
        warning(a.common, origin.nothingOpaque + ": there is nothing to light");
    else if (lit.activeVoxels == 0)
        warning(a.common, "the density grid is empty (it has no active voxels): there is nothing to light");
    else if (largestDensity == 0)
        warning(a.common, "the density is 0 in all active voxels: there is nothing that light could meet");
    else if (mean(lit.power.injected, lit.plan.channels) == 0)
        warning(a.common, "no light reaches the volume, so it is black; add --sun, --point, --sky or --emission");
    if (lit.termination == Termination::sweepLimit)
        warning(a.common, "not converged after " + std::to_string(lit.sweeps) + " sweeps; raise --sweeps");
    if (lit.termination == Termination::interrupted)
        message(a.common,
                "stopped after " + std::to_string(lit.sweeps) + " sweeps; '" + a.output + "' holds the answer so far");
    detail(a.common, std::to_string(lit.sweeps) + " sweeps and " + std::to_string(lit.finishingSweeps) +
                         " to finish, power balance error " + brief(lit.power.error()));
}

/// What voxels were, and what they count as.
std::string wordsOf(Repair::Kind kind, bool one) {
    const std::string count = one ? " and counts as " : " and count as ";
    switch (kind) {
        case Repair::Kind::negative:
            return "NaN, infinite or negative" + count + "0";
        case Repair::Kind::fraction:
            return "outside [0,1]" + count + "the nearest value in it";
        default:
            return "NaN or infinite" + count + "0";
    }
}

/// True if they have a point in common.
bool overlap(const Box3& a, const Box3& b) {
    bool apart = a.isEmpty() || b.isEmpty();
    for (int axis = 0; axis < 3; ++axis) apart = apart || a.min[axis] > b.max[axis] || b.min[axis] > a.max[axis];
    return !apart;
}

/// A fire that cannot be meant.
void commentOnFire(const LightArguments& a, const Medium& medium, const Illumination& lit) {
    if (!medium.emission) return;
    const std::string name = "the fire (grid '" + medium.emission->getName() + "') ";
    if (lit.emittedPower <= 0)
        warning(a.common, name + (medium.emissionScale > 0 ? "gives off no light: it has no voxel above 0"
                                                           : "gives off no light: --emission-scale is 0"));
    else if (lit.activeVoxels > 0 && !overlap(worldBounds(*medium.emission), worldBounds(*medium.density)))
        warning(a.common, name + "lies wholly beside the volume; are the transforms of both in the same units?");
}

void commentOnInput(const LightArguments& a, const SceneOrigin& origin, const VdbFile& input) {
    for (const Repair& repair : origin.repairs) {
        const bool one = repair.voxels == 1;
        warning(a.common, std::to_string(repair.voxels) + (one ? " voxel" : " voxels") + " of '" + repair.grid +
                              (one ? "' was " : "' were ") + wordsOf(repair.kind, one));
    }
    const auto has = [&](const std::string& name) {
        return std::any_of(input.grids.begin(), input.grids.end(),
                           [&](const openvdb::GridBase::Ptr& grid) { return grid->getName() == name; });
    };
    if (origin.ownExtinction && has("extinction"))
        warning(a.common,
                "'" + input.path + "' has a grid 'extinction' of its own; the output will have two of that name");
}

/// All options as a config file, which makes the same again. Those that were not given and have no default are left
/// out.
std::string optionsText(CLI::App& command, const LightArguments& a) {
    command.get_option("--tolerance")->default_str(brief(a.options.tolerance));
    // What a transfer function takes the place of is no default then.
    if (a.transfer.given() || a.scene.medium.isClassified()) command.get_option("--extinction")->default_str("");
    if (!a.transfer.table.empty()) command.get_option("--albedo")->default_str("");
    std::istringstream all(command.config_to_str(/*default_also=*/true));
    std::string text;
    for (std::string line; std::getline(all, line);)
        if (!line.empty() && line.find("=\"\"") == std::string::npos) text += line + "\n";
    return text;
}

/// With --upsample, radiosity on the voxels of the density that was given, and one more around them.
openvdb::GridBase::Ptr asWritten(const LightArguments& a, const Scene& scene, const openvdb::GridBase::Ptr& radiosity) {
    return a.upsample && a.resolution < 1 ? sampledOnto(*radiosity, *scene.medium.density, 1) : radiosity;
}

/// Lights the scene at the resolution asked for, and notes how much memory that took.
Illumination solve(LightArguments& a, const Scene& scene) {
    resetPeak();
    const std::size_t before = residentBytes();
    TerminalProgress progress(a.common);
    const Timer timer;
    const Scene solved = atResolution(scene, a.resolution);
    const double resampleSeconds = timer.seconds();
    Illumination lit = illuminate(solved, a.options, progress.callback());
    lit.plan = withResolution(std::move(lit.plan), a, scene, solved);
    lit.seconds.prepare += resampleSeconds;
    const std::size_t peak = peakResidentBytes();
    a.peakBytes = peak > before ? peak - before : 0;
    return lit;
}

void plotHistory(const LightArguments& a, const std::vector<ConvergencePoint>& history) {
    if (history.empty()) return;
    Curve rms{"RMS difference of radiosity, 20 sweeps apart", {}}, unshot{"unshot power / power injected", {}};
    for (const ConvergencePoint& point : history) {
        rms.points.emplace_back(point.sweep, point.rms);
        unshot.points.emplace_back(point.sweep, point.unshotShare);
    }
    const double tolerance = a.options.tolerance;
    const Curve limit{"tolerance", {{history.front().sweep, tolerance}, {history.back().sweep, tolerance}}, true};
    plotCurves(a.plot, {"sweeps", "relative to the answer"}, {rms, unshot, limit});
}

/// Says what will be modelled and why, and puts it in a report if one is wanted.
void explain(const LightArguments& a, const SceneFromFile& scene) {
    scene.scene.validate();
    const Scene solved = atResolution(scene.scene, a.resolution);
    const Plan plan = withResolution(planIllumination(solved, a.options), a, scene.scene, solved);
    const std::vector<std::string> reasons = reasonsOf(scene, plan);
    for (const std::string& reason : reasons) std::cout << reason << "\n";
    nlohmann::ordered_json json = {{"voxels_active", solved.medium.density->activeVoxelCount()},
                                   {"plan", reasons},
                                   {"resolution", a.resolution},
                                   {"options", a.commandLine}};
    addSkySuns(json, scene.origin);
    writeReport(a.common, json);
}

/// Before work begins.
void requireOutputs(const LightArguments& a) {
    if (!a.explain) requireWritable(a.output);
    if (!a.explain && !a.record.empty()) requireRecord(a.record);
    if (!a.plot.empty()) requirePlot(a.plot);
}

/// With what tells the density in the file from others.
void write(const LightArguments& a, const VdbFile& file, const SceneOrigin& origin, IlluminationRecord& record) {
    record.density = origin.density;
    record.checksum = checksum(*selectScalar(file, origin.density));
    writeRecord(a.record, record);
}

int run(LightArguments& a) {
    const ThreadLimit limit = start(a.common);
    requireOutputs(a);

    Timer timer;
    const VdbFile file = withoutLight(readVdb(a.input));
    a.scene.medium.classification = readTransfer(a.transfer);
    const SceneFromFile scene = sceneFrom(file, a.scene);
    commentOnInput(a, scene.origin, file);
    const double readSeconds = timer.seconds();
    if (a.explain) {
        explain(a, scene);
        return kDone;
    }
    openvdb::GridBase::Ptr emission;
    if (a.snapshots > 0) {
        a.options.snapshotEvery = a.snapshots;
        a.options.shines = [&](const openvdb::GridBase::Ptr& grid) { emission = grid; };
        a.options.snapshot = [&](int sweep, const openvdb::GridBase::Ptr& radiosity) {
            openvdb::GridPtrVec grids{asWritten(a, scene.scene, radiosity)};
            if (emission) grids.push_back(emission);
            write(numberedName(a.output, sweep), a, scene, file, grids);
            commitRunOutputs();  // to be looked at while the work goes on
        };
    }

    IlluminationRecord record;
    if (!a.record.empty()) a.options.record = &record;
    const Illumination lit = solve(a, scene.scene);
    timer = Timer();
    openvdb::GridPtrVec grids{asWritten(a, scene.scene, lit.radiosity)};
    if (lit.unshot) grids.push_back(lit.unshot);
    if (lit.emission) grids.push_back(lit.emission);
    write(a.output, a, scene, file, grids);
    if (!a.record.empty()) write(a, file, scene.origin, record);
    const double writeSeconds = timer.seconds();
    comment(a, scene, lit);
    commentOnFire(a, scene.scene.medium, lit);
    writeReport(a.common, describe(a, scene, lit, readSeconds, writeSeconds));
    if (!a.plot.empty()) plotHistory(a, lit.history);
    return lit.termination == Termination::interrupted ? kInterrupted : kDone;
}

}  // namespace

void addLight(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("light", "Light a volume: direct light and all scattering");
    const auto arguments = std::make_shared<LightArguments>();
    addLightOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        completeOptions(*arguments, *command);
        arguments->commandLine = optionsText(*command, *arguments);
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
