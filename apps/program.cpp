#include "program.h"

#include "cli.h"
#include "hints.h"

#include "raysweep/core/run_outputs.h"

#include <openvdb/Exceptions.h>

#include <cctype>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <string>

namespace raysweep::apps {
namespace {

/// What was read may be in a message: not all of a large file, and nothing that a terminal takes for a command.
std::string shown(std::string text) {
    constexpr std::size_t kMost = 4000, kEnd = 500;  // bytes; what to do stands at the end
    if (text.size() > kMost) text = text.substr(0, kMost - kEnd) + " ... " + text.substr(text.size() - kEnd);
    for (char& c : text)
        if (c != '\n' && c != '\t' && std::iscntrl(static_cast<unsigned char>(c))) c = '?';
    return text;
}

int fail(const CLI::App& app, const std::string& what) {
    std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), shown(what).c_str());
    return kFailed;
}

/// "Could not convert: --albedo = 0x1" in words that say what is wrong.
std::string wordsOf(const CLI::Error& error) {
    const std::string text = error.what(), start = "Could not convert: ", middle = " = ";
    const std::size_t at = text.find(middle);
    if (text.rfind(start, 0) != 0 || at == std::string::npos) return text;
    const std::string option = text.substr(start.size(), at - start.size()), value = text.substr(at + middle.size());
    char* end = nullptr;
    const double number = std::strtod(value.c_str(), &end);
    const bool isNumber = end != value.c_str() && *end == '\0';
    if (isNumber && !std::isfinite(number)) return option + " " + value + ": must be finite";
    if (isNumber && std::abs(number) > kLargestNumber) return option + " " + value + ": must be within -1e30 and 1e30";
    return option + ": '" + value + "' is not a number of the kind that is needed (decimal, with a point and no comma)";
}

std::string describeUsageError(const CLI::App* app, const CLI::Error& error) {
    const auto called = app->get_subcommands();
    const std::string command = app->get_name() + (called.empty() ? "" : " " + called.front()->get_name());
    // A misspelt word often leaves something else missing; the word is what the user wants to hear about.
    const auto unknown = app->remaining(/*recurse=*/true);
    const std::string what = unknown.empty() ? wordsOf(error) : "unknown argument '" + unknown.front() + "'";
    return app->get_name() + ": " + shown(what) + "\nRun '" + command + " --help' for help.\n";
}

}  // namespace

int runProgram(CLI::App& app, int argc, char** argv, const int& exitCode) {
    std::signal(SIGXFSZ, SIG_IGN);  // a file size limit should be an error when writing, not a sudden death
    app.failure_message(describeUsageError);
    watchSignals();
    try {
        const RunOutputs outputs;
        app.parse(argc, argv);
        if (!std::cout.flush()) return fail(app, "cannot write to standard output");
        commitRunOutputs();
        return exitCode;
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? kDone : kUsage;
    } catch (const std::bad_alloc&) {
        return fail(app, "out of memory; try a smaller volume or a lower resolution");
    } catch (const Error& e) {
        const auto called = app.get_subcommands();
        return fail(app, inWordsOf(called.empty() ? app : *called.front(), e));
    } catch (const openvdb::ArithmeticError& e) {
        return fail(app,
                    std::string(e.what()) +
                        ": OpenVDB holds no voxels whose volume is below 3e-15 cubic units (an edge of 1.5e-5); give "
                        "sizes in smaller units, for instance in millimetres instead of metres");
    } catch (const std::exception& e) {
        return fail(app, e.what());
    }
}

}  // namespace raysweep::apps
