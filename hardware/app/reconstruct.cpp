/// raysweep-cube4 reconstruct: SART by the machine, of X-rays that it takes itself, or as a recorded run of raysweep
/// ct.
#include "replay_report.h"
#include "subcommands.h"

#include "hints.h"

#include "cube4/turntable.h"

#include "raysweep/core/output_file.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/voxel_check.h"

#include <nlohmann/json.hpp>

#include <iostream>
#include <memory>

namespace raysweep::apps {
namespace {

struct Arguments {
    MachineArguments machine;
    std::string input, replay, output, grid;
    cube4::TurntableSetup turntable;
};

void addOptions(CLI::App& app, Arguments& a) {
    app.add_option("input", a.input, "Volume whose X-rays the machine takes, and from which it reconstructs it")
        ->type_name("VOL.vdb");
    auto* replay = app.add_option("--replay", a.replay, "Does again what --record of raysweep ct wrote, and compares")
                       ->type_name("RUN.json")
                       ->excludes("input");
    app.add_option("-o,--output", a.output, "Volume to write: density")->type_name("OUT.vdb");
    app.option_defaults()->group("X-rays of a volume");
    const auto own = [&](CLI::Option* option) { option->excludes(replay)->capture_default_str(); };
    own(app.add_option("--density", a.grid, "Grid (default: density)")->type_name("NAME"));
    own(app.add_option("--views", a.turntable.views, "Parallel views over half a turn about the z axis"));
    own(app.add_option("--iterations", a.turntable.passes, "Passes over all views"));
    own(app.add_option("--relaxation", a.turntable.relaxation, "Part of a correction that is made, λ"));
    addMachineOptions(app, a.machine);
    addPerspectiveOptions(app, a.machine);
}

void completeOptions(Arguments& a, const CLI::App& command) {
    requireMachine(command, a.machine);
    if (a.input.empty() && a.replay.empty()) usageError("input", "give a volume, or --replay RUN.json");
    if (a.replay.empty() && a.output.empty()) usageError("--output", "is required without --replay");
    if (!a.output.empty()) requireFileOutput(a.output);
    requireValid(command, [&] { a.turntable.validate(); });
}

void writeVolume(const std::string& path, const cube4::DenseField& field, const cube4::DenseBox& box,
                 const openvdb::math::Transform& transform) {
    const auto volume = cube4::sparseGrid(field, box, transform);
    volume->setName("density");
    requireFiniteResult(*volume, kTooLarge);
    writeVdb(path, {volume});
}

/// Both halves of the machine's work on a reconstruction.
void printPasses(const MachineArguments& a, const MachineUse& all, const cube4::Counters& project,
                 const cube4::Counters& backproject) {
    MachineUse use = all;
    use.counters = project;
    printUse("projecting", a, use);
    use.counters = backproject;
    printUse("backprojecting", a, use);
}

int replayRecord(const Arguments& a, cube4::ReplaySetup setup, const cube4::Trace& trace, TerminalProgress& progress) {
    const cube4::ReconstructionRecord record = cube4::readReconstructionRecord(a.replay, a.machine.maxVoxels);
    const cube4::ReconstructionReplay result = cube4::replay(record, setup, progress.callback());
    if (!result.complete) {
        message(a.machine.common, "stopped; nothing was written");
        return kInterrupted;
    }
    showTrace(a.machine, trace);
    printReplay(result);
    printPasses(a.machine, {{}, result.passes, result.voxels}, result.project, result.backproject);
    if (!a.output.empty())
        writeVolume(a.output, result.field, record.box, cube4::fieldOf(record.file, "density")->transform());
    writeReport(a.machine.common, describeReplay(a.machine, result));
    return kDone;
}

int reconstructVolume(const Arguments& a, const cube4::ReplaySetup& setup, const cube4::Trace& trace,
                      TerminalProgress& progress) {
    const openvdb::FloatGrid::Ptr volume = selectDensity(readVdb(a.input), a.grid);
    checkVoxels(*volume, volume->getName());
    const cube4::DenseBox box = cube4::boxAround(*volume, a.machine.maxVoxels);
    const Timer timer;
    const cube4::TurntableResult result =
        cube4::reconstructTurning(cube4::denseField(*volume, box), box, a.turntable, setup, progress.callback());
    if (!result.complete) {
        message(a.machine.common, "stopped; nothing was written");
        return kInterrupted;
    }
    cube4::Counters both = result.project;
    both += result.backproject;
    const MachineUse use{both,           result.updates, box.voxels(), result.bytesPerModule, result.bufferBytes,
                         timer.seconds()};
    showTrace(a.machine, trace);
    printAgreement("volume, to the one that was X-rayed", result.volume);
    if (setup.format) printAgreement("volume, to floats", result.volumeToFloat);
    printPasses(a.machine, use, result.project, result.backproject);
    writeVolume(a.output, result.field, box, volume->transform());
    nlohmann::ordered_json report = describeMachine(a.machine, use);
    report["updates"] = result.updates;
    report["volume"] = toJson(result.volume);
    if (setup.format) report["rms_against_float"] = result.volumeToFloat.rms;
    writeReport(a.machine.common, report);
    return kDone;
}

int run(const Arguments& a) {
    const ThreadLimit limit = start(a.machine.common);
    initializeGrids();
    if (!a.output.empty()) requireWritable(a.output);
    cube4::Trace trace;
    const cube4::ReplaySetup setup = replaySetup(a.machine, trace);
    TerminalProgress progress(a.machine.common);
    return a.replay.empty() ? reconstructVolume(a, setup, trace, progress) : replayRecord(a, setup, trace, progress);
}

}  // namespace

void addCube4Reconstruct(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("reconstruct", "SART by the machine");
    const auto arguments = std::make_shared<Arguments>();
    addOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        completeOptions(*arguments, *command);
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
