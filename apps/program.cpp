#include "program.h"

#include "cli.h"
#include "hints.h"

#include <openvdb/Exceptions.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>

namespace raysweep::apps {
namespace {

int fail(const CLI::App& app, const std::string& what) {
    std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), what.c_str());
    return kFailed;
}

std::string describeUsageError(const CLI::App* app, const CLI::Error& error) {
    const auto called = app->get_subcommands();
    const std::string command = app->get_name() + (called.empty() ? "" : " " + called.front()->get_name());
    // A misspelt word often leaves something else missing; the word is what the user wants to hear about.
    const auto unknown = app->remaining(/*recurse=*/true);
    const std::string what = unknown.empty() ? error.what() : "unknown argument '" + unknown.front() + "'";
    return app->get_name() + ": " + what + "\nRun '" + command + " --help' for help.\n";
}

}  // namespace

int runProgram(CLI::App& app, int argc, char** argv, const int& exitCode) {
    std::signal(SIGXFSZ, SIG_IGN);  // a file size limit should be an error when writing, not a sudden death
    app.failure_message(describeUsageError);
    try {
        app.parse(argc, argv);
        if (std::cout.flush()) return exitCode;
        return fail(app, "cannot write to standard output");
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? kDone : kUsage;
    } catch (const std::bad_alloc&) {
        return fail(app, "out of memory; try a smaller volume or a lower resolution");
    } catch (const Error& e) {
        const auto called = app.get_subcommands();
        return fail(app, inWordsOf(called.empty() ? app : *called.front(), e));
    } catch (const std::exception& e) {
        return fail(app, e.what());
    }
}

}  // namespace raysweep::apps
