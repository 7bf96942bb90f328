#include "program.h"
#include "subcommands.h"

#include "cli.h"

int main(int argc, char** argv) {
    using namespace raysweep::apps;
    CLI::App app("Cube-4, a clocked emulator of volume hardware that also backprojects: it checks Raysweep's results",
                 "raysweep-cube4");
    app.require_subcommand(1);
    app.set_version_flag("--version", "raysweep-cube4 " RAYSWEEP_VERSION);
    app.formatter(helpFormatter());
    readConfigFiles(app);
    int exitCode = kDone;
    for (const auto add : {addCube4Render, addCube4Illuminate, addCube4Reconstruct, addCube4Check}) add(app, exitCode);
    return runProgram(app, argc, argv, exitCode);
}
