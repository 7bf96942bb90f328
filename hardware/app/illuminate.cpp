/// raysweep-cube4 illuminate: light in a volume, by the machine alone or as a recorded run did it.
#include "replay_report.h"
#include "subcommands.h"

#include "hints.h"

#include "cube4/free_run.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/classify.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/voxel_check.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <iostream>
#include <memory>

namespace raysweep::apps {
namespace {

struct Arguments {
    MachineArguments machine;
    std::string input, output, grid, replay, ramp;
    std::vector<std::string> suns;
    double extinction = 1, albedo = 0.9;
    std::string interpolation = "nearest", exchange = "corrected";
    cube4::SceneLight light;
    cube4::IlluminationSetup setup;
};

void addOptions(CLI::App& app, Arguments& a) {
    app.add_option("input", a.input, "Volume to light; with --replay, if given, it must be the one that was recorded")
        ->type_name("IN.vdb");
    auto* replay =
        app.add_option("--replay", a.replay, "Does again what --record of raysweep light wrote, and compares")
            ->type_name("RUN.json");
    app.add_option("-o,--output", a.output, "Lit volume to write: density and radiosity")->type_name("OUT.vdb");
    app.option_defaults()->group("Scene");
    const auto own = [&](CLI::Option* option) { return option->excludes(replay)->capture_default_str(); };
    own(app.add_option("--density", a.grid, "Grid to light (default: density)"))->type_name("NAME");
    auto* extinction = own(app.add_option("--extinction", a.extinction, "Extinction per unit density, 1/world unit"));
    own(app.add_option("--ramp", a.ramp, "Opacity 0 at LO, ALPHA (0.99) at HI, instead"))
        ->excludes(extinction)
        ->type_name("LO,HI[,ALPHA]");
    own(app.add_option("--albedo", a.albedo, "Single-scattering albedo"))->check(CLI::Range(0.0, 1.0));
    app.add_option("--sun", a.suns, "Directional light: direction of travel and irradiance; repeatable")
        ->excludes(replay)
        ->allow_extra_args(false)
        ->type_name("X,Y,Z,E");
    own(app.add_option("--sky", a.light.sky, "Radiance from all sides"));
    app.option_defaults()->group("Iteration");
    own(app.add_option("--sweeps", a.light.sweeps, "Sweeps that inject light"));
    own(app.add_option("--zeta", a.setup.zeta, "Part of its unshot power that a voxel shoots in a sweep"));
    own(app.add_option("--interpolation", a.interpolation, "nearest or linear"))
        ->check(CLI::IsMember({"nearest", "linear"}));
    own(app.add_option("--exchange", a.exchange, "corrected, or paper: Algorithm 1 as printed"))
        ->check(CLI::IsMember({"corrected", "paper"}));
    addMachineOptions(app, a.machine);
}

void completeOptions(Arguments& a, const CLI::App& command) {
    requireMachine(command, a.machine);
    if (a.replay.empty()) {
        if (a.input.empty()) usageError("input", "give a volume, or --replay RUN.json");
        if (a.output.empty()) usageError("--output", "is required without --replay");
    }
    if (!a.output.empty()) requireFileOutput(a.output);
    if (!a.output.empty() && a.input.empty()) usageError("--output", "needs the volume that was lit as input");
    constexpr std::size_t kNumbers = 4;
    for (const std::string& sun : a.suns) {
        const std::size_t last = sun.rfind(',');
        if (split(sun, ',').size() != kNumbers)
            usageError("--sun", "'" + sun + "': four numbers are needed, as in 0,0,-1,3");
        a.light.suns.push_back(
            {parseDirection(sun.substr(0, last), "--sun"), parseNumber(sun.substr(last + 1), "--sun", "0,0,-1,3")});
    }
    a.light.seed = a.machine.common.seed;
    a.setup.pipelines = a.machine.pipelines;
    a.setup.overlap = !a.machine.noOverlap;
    a.setup.resampling = a.interpolation == "linear" ? cube4::Resampling::linear : cube4::Resampling::nearest;
    a.setup.rule = a.exchange == "paper" ? cube4::ExchangeRule::asPrinted : cube4::ExchangeRule::corrected;
    requireFactor(a.extinction, "--extinction");
    if (!std::isfinite(a.albedo)) usageError("--albedo", "must be in [0,1]");
    if (a.replay.empty() && a.suns.empty() && !(a.light.sky > 0))
        usageError("--sun", "give light: --sun, --sky or both, or a run with --replay");
    requireValid(command, [&] {
        a.setup.validate();
        a.light.validate();
    });
}

/// The volume that was asked for, as extinction, 1/world unit.
openvdb::FloatGrid::Ptr extinctionOf(const Arguments& a, const openvdb::FloatGrid& density) {
    if (!a.ramp.empty()) {
        const std::vector<double> n = parseNumbers(a.ramp, "--ramp", 2, 3, "0.1,0.5 or 0.1,0.5,0.9");
        return classify(density, rampFunction(n[0], n[1], n.size() > 2 ? n[2] : kRampOpacity)).extinction;
    }
    checkVoxels(density, density.getName());
    const openvdb::FloatGrid::Ptr extinction = density.deepCopy();
    setActive(*extinction, [&] {
        return [&, in = density.getConstAccessor()](const openvdb::Coord& at) {
            return float(double(in.getValue(at)) * a.extinction);
        };
    });
    return extinction;
}

/// The grids of `file` besides light that it had, with what the machine has lit and its light.
/// @param extinction 1/world unit  @param emission what shines by itself; may be null
void writeLit(const Arguments& a, const VdbFile& file, const openvdb::FloatGrid& extinction, const cube4::DenseBox& box,
              const cube4::DenseField& radiosity, const openvdb::GridBase::ConstPtr& emission = nullptr) {
    openvdb::GridPtrVec grids;
    for (const openvdb::GridBase::Ptr& grid : file.grids) {
        const std::string name = grid->getName();
        if (name == "extinction" && a.replay.empty() && a.grid != name)
            warning(a.machine.common,
                    "a grid 'extinction' of '" + a.input + "' is left out: what was lit is called so");
        const bool isEmission = name == "emission" && (*grid)["raysweep_density"];  // not one of the user's own
        if (name != "radiosity" && name != "unshot" && name != "extinction" && !isEmission) grids.push_back(grid);
    }
    grids.push_back(extinction.deepCopyGrid());
    grids.back()->setName("extinction");
    grids.back()->insertMeta("raysweep_density", openvdb::StringMetadata("extinction"));
    grids.back()->insertMeta("raysweep_version", openvdb::StringMetadata(RAYSWEEP_VERSION));
    grids.push_back(cube4::extendedGrid(radiosity, box, extinction));
    grids.back()->setName("radiosity");
    grids.back()->insertMeta("raysweep_density", openvdb::StringMetadata("extinction"));
    grids.back()->insertMeta("raysweep_extinction", openvdb::DoubleMetadata(1));
    for (auto own = grids.end() - 2; own != grids.end(); ++own) requireFiniteResult(**own, kTooLarge);
    if (emission) {
        // Before one of the user's own: other programs take the first of a name.
        grids.insert(grids.begin(), emission->deepCopyGrid());
        grids.front()->insertMeta("raysweep_density", openvdb::StringMetadata("extinction"));
        grids.front()->insertMeta("raysweep_version", openvdb::StringMetadata(RAYSWEEP_VERSION));
    }
    writeVdb(a.output, {grids.begin(), grids.end()});
}

int replayRecord(const Arguments& a, TerminalProgress& progress) {
    const cube4::IlluminationRecord record = cube4::readIlluminationRecord(a.replay, a.machine.maxVoxels);
    VdbFile file;
    if (!a.input.empty()) {
        file = readVdb(a.input);
        cube4::requireSameVolume(record, *selectDensity(file, record.grid));
    }
    if (!a.output.empty() && record.channels != 1)
        throw InvalidArgument(a.replay + ": three wavelengths; what the machine writes has one");
    cube4::Trace trace;
    const cube4::ReplaySetup setup = replaySetup(a.machine, trace);
    const Timer timer;
    const cube4::ReplayResult result = cube4::replay(record, setup, progress.callback());
    if (!result.complete) {
        message(a.machine.common, "stopped; nothing was written");
        return kInterrupted;
    }
    const double seconds = timer.seconds();
    showTrace(a.machine, trace);
    printReplay(result);
    printUse("machine", a.machine, useOf(result, record.box.voxels(), seconds));
    if (!a.output.empty()) {
        const auto extinction = cube4::fieldOf(record.file, "extinction");
        writeLit(a, file, static_cast<const openvdb::FloatGrid&>(*extinction), record.box, result.radiosityFields[0],
                 cube4::fieldOf(record.file, "emission", true));
    }
    writeReport(a.machine.common, describeReplay(a.machine, record, result, seconds));
    return kDone;
}

/// The machine by itself, in floats, and if a format was asked for, the same sweeps in that.
struct OwnRun {
    cube4::DenseMedium medium;
    cube4::FreeRun run;
    cube4::DenseField deposit;
    cube4::Agreement toFloat;
    MachineUse use;
    bool complete = true;
};

OwnRun runOwn(const Arguments& a, const openvdb::FloatGrid& extinction, cube4::Trace* trace,
              TerminalProgress& progress) {
    OwnRun own;
    own.medium.box = cube4::boxAround(extinction, a.machine.maxVoxels);
    own.medium.extinction = cube4::denseField(extinction, own.medium.box);
    own.medium.albedo.assign(own.medium.extinction.size(), float(a.albedo));
    cube4::addDirectLight(own.medium, a.setup, a.light.suns);
    const Timer timer;
    cube4::Illumination exact(own.medium, a.setup);
    own.run =
        cube4::runFreely(exact, own.medium.box, cube4::sumOf(own.medium.source), a.light, progress.callback(), trace);
    own.complete = own.run.complete;
    const cube4::Illumination* judged = &exact;
    std::optional<cube4::Illumination> rounded;
    if (const auto format = parseFormat(a.machine); format && own.complete) {
        cube4::IlluminationSetup setup = a.setup;
        setup.format = format;
        setup.largestPower = exact.largestPower();
        setup.largestDeposit = cube4::largestOf(exact.deposit());
        rounded.emplace(own.medium, setup);
        own.complete = cube4::repeat(own.run, *rounded, progress.callback());
        own.toFloat = cube4::compareFields(rounded->deposit(), exact.deposit(), own.medium.box);
        judged = &*rounded;
    }
    own.deposit = judged->deposit();
    own.use = {judged->counters(),       judged->passes(),      own.medium.box.voxels(),
               judged->bytesPerModule(), judged->bufferBytes(), timer.seconds()};
    return own;
}

int runAlone(const Arguments& a, TerminalProgress& progress) {
    const VdbFile file = readVdb(a.input);
    const openvdb::FloatGrid::Ptr density = selectDensity(file, a.grid);
    const openvdb::FloatGrid::Ptr extinction = extinctionOf(a, *density);
    cube4::Trace trace;
    trace.most = a.machine.trace;
    const OwnRun own = runOwn(a, *extinction, a.machine.trace > 0 ? &trace : nullptr, progress);
    if (!own.complete) {
        message(a.machine.common, "stopped; nothing was written");
        return kInterrupted;
    }
    showTrace(a.machine, trace);
    printUse("machine", a.machine, own.use);
    if (own.run.unshotShare > a.light.unshotShare)
        warning(a.machine.common, brief(100 * own.run.unshotShare) +
                                      " % of the power was still unshot in the end; a larger "
                                      "--zeta moves it sooner");
    writeLit(a, file, *extinction, own.medium.box,
             cube4::radiosity(own.medium, a.setup, own.deposit, own.run.injections));
    nlohmann::ordered_json report = describeMachine(a.machine, own.use);
    report["sweeps"] = own.run.injections;
    report["unshot_share"] = own.run.unshotShare;
    report["finishing_sweeps"] = int(own.run.sweeps.size()) - own.run.injections;
    if (own.toFloat.voxels > 0) {
        printAgreement("deposit, to floats", own.toFloat);
        report["rms_against_float"] = own.toFloat.rms;
    }
    writeReport(a.machine.common, report);
    return kDone;
}

int run(const Arguments& a) {
    const ThreadLimit limit = start(a.machine.common);
    initializeGrids();
    if (!a.output.empty()) requireWritable(a.output);
    TerminalProgress progress(a.machine.common);
    return a.replay.empty() ? runAlone(a, progress) : replayRecord(a, progress);
}

}  // namespace

void addCube4Illuminate(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("illuminate", "Light in a volume, swept by the machine");
    const auto arguments = std::make_shared<Arguments>();
    addOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        completeOptions(*arguments, *command);
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
