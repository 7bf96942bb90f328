#include "cli.h"
#include "program.h"

#include <malloc.h>

namespace {

using namespace raysweep::apps;

constexpr void (*kSubcommands[])(CLI::App&, int&) = {addLight,   addRender, addImport,  addGenerate, addInfo,
                                                     addCompare, addExport, addProject, addCt,       addShoot,
                                                     addPhoto,   addBake,   addSlices};

}  // namespace

int main(int argc, char** argv) {
    // What a sweep gives back the next one takes: the system would have to zero the pages anew.
    ::mallopt(M_MMAP_THRESHOLD, 8 << 20);
    ::mallopt(M_TRIM_THRESHOLD, 8 << 20);
    CLI::App app("Raysweep: light transport and reconstruction in sparse volumes", "raysweep");
    app.require_subcommand(1);
    app.set_version_flag("--version", "raysweep " RAYSWEEP_VERSION);
    app.formatter(helpFormatter());  // subcommands inherit it
    readConfigFiles(app);
    int exitCode = kDone;
    for (const auto add : kSubcommands) add(app, exitCode);
    return runProgram(app, argc, argv, exitCode);
}
