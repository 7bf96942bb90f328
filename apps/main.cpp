#include "cli.h"
#include "hints.h"

#include <openvdb/Exceptions.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>

namespace {

using namespace raysweep::apps;

constexpr void (*kSubcommands[])(CLI::App&, int&) = {addLight,  addRender,  addImport, addGenerate, addInfo, addCompare,
                                                     addExport, addProject, addCt,     addShoot,    addPhoto};

int fail(const std::string& what) {
    std::fprintf(stderr, "raysweep: %s\n", what.c_str());
    return kFailed;
}

std::string describeUsageError(const CLI::App* app, const CLI::Error& error) {
    const auto called = app->get_subcommands();
    const std::string command = app->get_name() + (called.empty() ? "" : " " + called.front()->get_name());
    // A misspelt word often leaves something else missing; the word is what the user wants to hear about.
    const auto unknown = app->remaining(/*recurse=*/true);
    const std::string what = unknown.empty() ? error.what() : "unknown argument '" + unknown.front() + "'";
    return "raysweep: " + what + "\nRun '" + command + " --help' for help.\n";
}

}  // namespace

int main(int argc, char** argv) {
    std::signal(SIGXFSZ, SIG_IGN);  // a file size limit should be an error when writing, not a sudden death
    CLI::App app("Raysweep: light transport and reconstruction in sparse volumes", "raysweep");
    app.require_subcommand(1);
    app.set_version_flag("--version", "raysweep " RAYSWEEP_VERSION);
    app.failure_message(describeUsageError);
    app.formatter(helpFormatter());  // subcommands inherit it
    readConfigFiles(app);
    int exitCode = kDone;
    for (const auto add : kSubcommands) add(app, exitCode);
    try {
        app.parse(argc, argv);
        if (std::cout.flush()) return exitCode;
        return fail("cannot write to standard output");
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? kDone : kUsage;
    } catch (const std::bad_alloc&) {
        return fail("out of memory; try a smaller volume or a lower resolution");
    } catch (const raysweep::Error& e) {
        const auto called = app.get_subcommands();
        return fail(inWordsOf(called.empty() ? app : *called.front(), e));
    } catch (const std::exception& e) {
        return fail(e.what());
    }
}
