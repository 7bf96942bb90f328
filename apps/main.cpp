#include "command.h"

#include "raysweep/core/error.h"

#include <cstdio>
#include <exception>

int main(int argc, char** argv) {
    using namespace raysweep::apps;
    CLI::App app("Raysweep: light transport and reconstruction in sparse volumes", "raysweep");
    app.require_subcommand(1);
    app.set_version_flag("--version", RAYSWEEP_VERSION);
    int exitCode = kDone;
    addRender(app, exitCode);
    try {
        app.parse(argc, argv);
        return exitCode;
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? kDone : kUsage;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "raysweep: %s\n", e.what());
        return kFailed;
    }
}
