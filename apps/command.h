/// What every subcommand shares. main.cpp holds the table of subcommands and the only catch.
#pragma once

#include "cli11.h"

#include <string>

namespace raysweep::apps {

/// Options that every subcommand has.
struct CommonOptions {
    const CLI::App* command = nullptr;  ///< the subcommand whose they are
    int threads = 0;                    ///< number of threads; 0: all cores
    unsigned seed = 1;                  ///< seed of everything random
    std::string reportFile;             ///< JSON report, empty: none
    bool quiet = false;                 ///< no messages, no progress
    bool verbose = false;               ///< more messages
};

/// Exit codes: 0 done, 1 failed, 2 usage, 130 stopped by Ctrl-C.
enum ExitCode { kDone = 0, kFailed = 1, kUsage = 2, kInterrupted = 130 };

void addCommonOptions(CLI::App& app, CommonOptions& options);

/// Each adds its subcommand to `app`; the subcommand's callback does the work, throws raysweep::Error on failure and
/// sets `exitCode` when it ends otherwise than with kDone.
void addLight(CLI::App& app, int& exitCode);
void addRender(CLI::App& app, int& exitCode);
void addInfo(CLI::App& app, int& exitCode);
void addCompare(CLI::App& app, int& exitCode);
void addGenerate(CLI::App& app, int& exitCode);
void addImport(CLI::App& app, int& exitCode);
void addExport(CLI::App& app, int& exitCode);
void addProject(CLI::App& app, int& exitCode);
void addCt(CLI::App& app, int& exitCode);
void addShoot(CLI::App& app, int& exitCode);
void addPhoto(CLI::App& app, int& exitCode);
void addBake(CLI::App& app, int& exitCode);
void addSlices(CLI::App& app, int& exitCode);

}  // namespace raysweep::apps
