/// What subcommands share: options, parsing of values, messages, progress, Ctrl-C, reports.
#pragma once

#include "command.h"
#include "file_roles.h"
#include "signals.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/progress.h"
#include "raysweep/core/types.h"

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <string>
#include <vector>

namespace raysweep::apps {

/// Usage errors end the program with kUsage. @throw CLI::ValidationError always. `option` is named as typed ("--sun").
[[noreturn]] void usageError(const std::string& option, const std::string& why);

/// Numbers separated by commas, `least` to `most` of them, none beyond kLargestNumber. `example` is shown when the text
/// does not fit.
/// @throw CLI::ValidationError as the other parse functions do.
std::vector<double> parseNumbers(const std::string& text, const std::string& option, std::size_t least,
                                 std::size_t most, const std::string& example);

/// From the first to the second, both included.
using WholeRange = std::pair<int, int>;

/// `count` whole numbers within `range`, separated by commas.
std::vector<int> parseWhole(const std::string& text, const std::string& option, std::size_t count,
                            const WholeRange& range, const std::string& example);

/// One number, likewise. `text` must hold nothing else.
double parseNumber(const std::string& text, const std::string& option, const std::string& example);

/// X,Y,Z of a direction, of any length but 0. The result's is one with whose square can be calculated.
Vec3 parseDirection(const std::string& text, const std::string& option, const std::string& example = "1,0.5,-2");

/// X,Y,Z of a point
Vec3 parseVec3(const std::string& text, const std::string& option, const std::string& example = "1,0.5,-2");

/// Linear RGB, non-negative: one number for grey, or R,G,B or R:G:B.
Color parseColor(const std::string& text, const std::string& option);

/// @throw CLI::ValidationError unless `value` is finite and not negative.
void requireFactor(double value, const std::string& option);

/// Parts of `text` between separators; empty parts are kept.
std::vector<std::string> split(const std::string& text, char separator);

/// Refuses "-" (standard output), which a file that is written in place of another cannot be, and an empty name.
/// @throw CLI::ValidationError
void requireFileOutput(const std::string& path, const std::string& option = "--output");

/// Checks the name of --record, RUN.json. @throw CLI::ValidationError
void requireRecordName(const std::string& record);

/// The files of a record: RUN.json, and the RUN.vdb that goes with it.
std::vector<std::string> recordFiles(const std::string& record);

/// `path` with _0001 and so on before its extension: one of a series of files.
std::string numberedName(const std::string& path, int number);

/// How --help is laid out.
std::shared_ptr<CLI::FormatterBase> helpFormatter();

/// Every subcommand starts with this: limits the threads for as long as the result lives, and checks that files that
/// are written are no others of the command and that the report can be written, so that long work does not end in an
/// error that was certain at its start. @throw CLI::ValidationError, IoError
ThreadLimit start(const CommonOptions& options);

/// Makes `--config` read TOML or INI: keys are long option names, either under [subcommand] or before any section,
/// where they belong to the subcommand that was called. A list of numbers is the same as "n,n,n". Unknown keys are
/// errors. Call it once on the program's app, before parsing.
void readConfigFiles(CLI::App& program);

/// To stderr with the prefix "raysweep: ", unless --quiet.
void message(const CommonOptions& options, const std::string& text);
/// As message, marked as a warning.
void warning(const CommonOptions& options, const std::string& text);
/// As message, but only with --verbose.
void detail(const CommonOptions& options, const std::string& text);

/// Writes a report if the user asked for one; whole or not at all. @throw Error naming a number that is not finite
void writeReport(const CommonOptions& options, const nlohmann::ordered_json& report);

/// For requireFiniteResult.
constexpr const char* kTooLarge =
    "what was read, or an option, is too large for single precision; choose units in which numbers are nearer 1";

/// Checks what is about to be written. @throw InvalidArgument "WHAT would have 3 values that are NaN or infinite ..."
void requireFinite(const std::vector<float>& values, const std::string& what);

/// For reports, where nothing is an answer as well ("was not measured", the PSNR of equal pictures): null unless
/// finite.
nlohmann::ordered_json finiteOrNull(double value);

/// While it lives: Ctrl-C asks the work to stop (see StopRequests), and on a terminal a bar with the time left is
/// drawn on stderr, unless --quiet. Make one around long work and hand `callback()` to it.
class TerminalProgress {
  public:
    explicit TerminalProgress(const CommonOptions& options);
    ~TerminalProgress();
    TerminalProgress(const TerminalProgress&) = delete;
    TerminalProgress& operator=(const TerminalProgress&) = delete;

    /// Valid while this object lives; returns false once Ctrl-C was pressed.
    ProgressCallback callback();

    /// True once Ctrl-C was pressed: write what there is and exit with kInterrupted.
    static bool interrupted();

  private:
    void draw(const std::string& stage, double fraction);

    StopRequests requests_;
    bool drawing_;
    std::string stage_;
    double stageStart_ = 0, lastDrawn_ = -1;
    Timer timer_;
};

}  // namespace raysweep::apps
