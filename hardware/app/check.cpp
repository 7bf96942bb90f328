/// raysweep-cube4 check: is a result of `raysweep light` or `raysweep ct` what the machine finds?
#include "replay_report.h"
#include "subcommands.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/grid_select.h"

#include <nlohmann/json.hpp>

#include <iostream>
#include <memory>

namespace raysweep::apps {
namespace {

struct Arguments {
    MachineArguments machine;
    std::string input, replay;
    double maxRms = 1e-3;
};

void addOptions(CLI::App& app, Arguments& a) {
    app.add_option("input", a.input, "What raysweep light or raysweep ct has written")
        ->required()
        ->type_name("FILE.vdb");
    app.add_option("--replay", a.replay, "What --record wrote of that run")->required()->type_name("RUN.json");
    app.add_option("--max-rms", a.maxRms, "Exit code 1 if the RMS difference, relative, is above this")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1e9))
        ->type_name("X");
    addMachineOptions(app, a.machine);
    addPerspectiveOptions(app, a.machine);
}

/// Says how well they agree. @return exit code
int verdict(const Arguments& a, const cube4::Agreement& agreement, nlohmann::ordered_json report) {
    const bool agrees = agreement.rms <= a.maxRms;
    report["result"] = toJson(agreement);
    report["max_rms"] = a.maxRms;
    report["agrees"] = agrees;
    writeReport(a.machine.common, report);
    printAgreement("'" + a.input + "'", agreement);
    if (agrees) {
        std::cout << "agrees: " << brief(agreement.rms, 3) << " is at most " << brief(a.maxRms, 3) << "\n";
        return kDone;
    }
    message(a.machine.common, "'" + a.input + "' differs from what the machine finds by " + brief(agreement.rms, 3) +
                                  " RMS, more than " + brief(a.maxRms, 3));
    return kFailed;
}

/// @throw InvalidArgument if the grids have voxels of their own
void requireSameVoxels(const openvdb::GridBase& result, const openvdb::GridBase& recorded, const std::string& file) {
    if (result.transform() != recorded.transform())
        throw InvalidArgument(file + ": its '" + result.getName() +
                              "' has other voxels than the run that was recorded, so that they cannot be compared "
                              "(--upsample writes such files)");
}

int checkLight(const Arguments& a, TerminalProgress& progress) {
    const cube4::IlluminationRecord record = cube4::readIlluminationRecord(a.replay, a.machine.maxVoxels);
    const VdbFile file = readVdb(a.input);
    cube4::requireSameVolume(record, *selectDensity(file, record.grid));
    const openvdb::GridBase::ConstPtr lit = selectGrid(file, "radiosity");
    requireSameVoxels(*lit, *cube4::fieldOf(record.file, "extinction"), a.input);
    const Timer timer;
    cube4::Trace trace;
    const cube4::ReplayResult result = cube4::replay(record, replaySetup(a.machine, trace), progress.callback());
    if (!result.complete) {
        message(a.machine.common, "stopped; nothing was checked");
        return kInterrupted;
    }
    const cube4::RadiosityJudgement judged = cube4::judgeRadiosity(record, result, *lit);
    // What surfaces show has to be normalised by a furnace that the machine does not run: there the powers are judged.
    cube4::Agreement agreement = judged.agreement;
    if (judged.voxels < judged.active)
        agreement = cube4::worseOf(agreement, cube4::worseOf(result.deposit, result.unshot));
    const double seconds = timer.seconds();
    showTrace(a.machine, trace);
    printReplay(result);
    printUse("machine", a.machine, useOf(result, record.box.voxels(), seconds));
    if (judged.voxels < judged.active)
        std::cout << "radiosity judged in " << judged.voxels << " of " << judged.active
                  << " voxels: of surfaces, and what is behind them, deposit and unshot power\n";
    nlohmann::ordered_json report = describeReplay(a.machine, record, result, seconds);
    report["radiosity"] = toJson(judged.agreement);
    report["voxels_judged"] = judged.voxels;
    return verdict(a, agreement, std::move(report));
}

int checkReconstruction(const Arguments& a, TerminalProgress& progress) {
    const cube4::ReconstructionRecord record = cube4::readReconstructionRecord(a.replay, a.machine.maxVoxels);
    const VdbFile file = readVdb(a.input);
    const openvdb::FloatGrid::Ptr volume = selectDensity(file, "");
    requireSameVoxels(*volume, *cube4::fieldOf(record.file, "density"), a.input);
    cube4::Trace trace;
    const cube4::ReconstructionReplay result =
        cube4::replay(record, replaySetup(a.machine, trace), progress.callback());
    if (!result.complete) {
        message(a.machine.common, "stopped; nothing was checked");
        return kInterrupted;
    }
    showTrace(a.machine, trace);
    printReplay(result);
    const cube4::Agreement agreement =
        cube4::compareFields(result.field, cube4::denseField(*volume, record.box), record.box);
    return verdict(a, agreement, describeReplay(a.machine, result));
}

int run(const Arguments& a) {
    const ThreadLimit limit = start(a.machine.common);
    initializeGrids();
    TerminalProgress progress(a.machine.common);
    return cube4::recordKind(a.replay) == "reconstruct" ? checkReconstruction(a, progress) : checkLight(a, progress);
}

}  // namespace

void addCube4Check(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("check", "Judge a result by doing its recorded run again");
    const auto arguments = std::make_shared<Arguments>();
    addOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        requireMachine(*command, arguments->machine);
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
