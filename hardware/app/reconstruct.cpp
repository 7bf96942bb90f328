/// raysweep-cube4 reconstruct: SART by the machine, as a recorded run of raysweep ct did it.
#include "replay_report.h"
#include "subcommands.h"

#include "raysweep/core/output_file.h"

#include <nlohmann/json.hpp>

#include <memory>

namespace raysweep::apps {
namespace {

struct Arguments {
    MachineArguments machine;
    std::string replay, output;
};

void addOptions(CLI::App& app, Arguments& a) {
    app.add_option("--replay", a.replay, "Does again what --record of raysweep ct wrote, and compares")
        ->required()
        ->type_name("RUN.json");
    app.add_option("-o,--output", a.output, "Volume to write: density")->type_name("OUT.vdb");
    addMachineOptions(app, a.machine);
}

int run(const Arguments& a) {
    const ThreadLimit limit = start(a.machine.common);
    initializeGrids();
    if (!a.output.empty()) requireWritable(a.output);
    const cube4::ReconstructionRecord record = cube4::readReconstructionRecord(a.replay, a.machine.maxVoxels);
    cube4::ReplaySetup setup;
    setup.pipelines = a.machine.pipelines;
    setup.overlap = !a.machine.noOverlap;
    setup.format = parseFormat(a.machine);
    cube4::Trace trace;
    trace.most = a.machine.trace;
    setup.trace = a.machine.trace > 0 ? &trace : nullptr;
    TerminalProgress progress(a.machine.common);
    const cube4::ReconstructionReplay result = cube4::replay(record, setup, progress.callback());
    if (!result.complete) {
        message(a.machine.common, "stopped; nothing was written");
        return kInterrupted;
    }
    showTrace(a.machine, trace);
    printReplay(result);
    const auto use = [&](const cube4::Counters& counters) {
        return MachineUse{counters,           result.passes, result.voxels, result.bytesPerModule,
                          result.bufferBytes, result.seconds};
    };
    printUse("projecting", a.machine, use(result.project));
    printUse("backprojecting", a.machine, use(result.backproject));
    if (!a.output.empty()) {
        const auto density = cube4::fieldOf(record.file, "density");
        const auto volume = cube4::sparseGrid(result.field, record.box, density->transform());
        volume->setName("density");
        writeVdb(a.output, {volume});
    }
    writeReport(a.machine.common, describeReplay(a.machine, result));
    return kDone;
}

}  // namespace

void addCube4Reconstruct(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("reconstruct", "SART by the machine");
    const auto arguments = std::make_shared<Arguments>();
    addOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        requireMachine(*command, arguments->machine);
        if (!arguments->output.empty()) requireFileOutput(arguments->output);
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
