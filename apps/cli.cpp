#include "cli.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/finite.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/text_file.h"
#include "raysweep/volume/record_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace raysweep::apps {

void addCommonOptions(CLI::App& app, CommonOptions& options) {
    const std::string group = "Common options";
    options.command = &app;
    app.add_option("--threads", options.threads, "Number of threads; 0: all cores")
        ->check(CLI::Range(0, 4096).description(""))
        ->capture_default_str()
        ->group(group);
    app.add_option("--seed", options.seed, "Seed of everything random")->capture_default_str()->group(group);
    writes(app.add_option("--report", options.reportFile, "Write what was done, and how long it took, to this file"))
        ->type_name("FILE.json")
        ->check([](const std::string& path) { return path == "-" ? "a file name is needed, not '-'" : ""; })
        ->group(group);
    app.add_flag("--quiet", options.quiet, "No messages, no warnings, no progress")->group(group);
    app.add_flag("--verbose", options.verbose, "More messages")->group(group);
    // The library reads config files for the program only; handing it the name lets the option stand where users put
    // it.
    app.add_option_function<std::string>(
           "--config", [&app](const std::string& file) { app.get_parent()->get_config_ptr()->add_result(file); },
           "Read options from this TOML or INI file; those on the command line win")
        ->trigger_on_parse()
        ->type_name("FILE")
        ->configurable(false)
        ->group(group);
}

void usageError(const std::string& option, const std::string& why) {
    throw CLI::ValidationError(option, why);
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::size_t begin = 0;
    for (std::size_t end = text.find(separator); end != std::string::npos; end = text.find(separator, begin)) {
        parts.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    parts.push_back(text.substr(begin));
    return parts;
}

namespace {

/// Numbers between commas, however large. See parseNumbers.
std::vector<double> anyNumbers(const std::string& text, const std::string& option, std::size_t least, std::size_t most,
                               const std::string& example) {
    std::vector<double> numbers;
    for (const std::string& part : split(text, ',')) {
        double number = 0;
        if (!readNumber(part, number))
            usageError(option,
                       "'" + part + "' in '" + text + "' is not a number; for example " + option + " " + example);
        numbers.push_back(number);
    }
    if (numbers.size() < least || numbers.size() > most) {
        const std::string wanted = std::to_string(least) + (least == most ? "" : " to " + std::to_string(most)) +
                                   " number" + (most > 1 ? "s" : "");
        usageError(option, "'" + text + "' has " + std::to_string(numbers.size()) + " where " + wanted +
                               " separated by commas are needed; for example " + option + " " + example);
    }
    return numbers;
}

}  // namespace

std::vector<double> parseNumbers(const std::string& text, const std::string& option, std::size_t least,
                                 std::size_t most, const std::string& example) {
    const std::vector<double> numbers = anyNumbers(text, option, least, most, example);
    for (const double number : numbers)
        if (std::abs(number) > kLargestNumber)
            usageError(option, "'" + text + "': numbers must be within -1e30 and 1e30");
    return numbers;
}

std::vector<int> parseWhole(const std::string& text, const std::string& option, std::size_t count,
                            const WholeRange& range, const std::string& example) {
    const auto [low, high] = range;
    std::vector<int> whole;
    for (const double number : parseNumbers(text, option, count, count, example)) {
        if (number != std::floor(number) || number < low || number > high)
            usageError(option, "'" + text + "': whole numbers from " + std::to_string(low) + " to " +
                                   std::to_string(high) + " are needed");
        whole.push_back(int(number));
    }
    return whole;
}

double parseNumber(const std::string& text, const std::string& option, const std::string& example) {
    return parseNumbers(text, option, 1, 1, example).front();
}

namespace {

/// A direction as it is, or where squares of its numbers are none, with the length 1.
Vec3 scaled(const Vec3& direction) {
    const double square = direction.dot(direction);
    return square > 1e-200 && square < 1e200 ? direction : unitVector(direction);
}

}  // namespace

Vec3 parseVec3(const std::string& text, const std::string& option, const std::string& example) {
    const std::vector<double> v = parseNumbers(text, option, 3, 3, example);
    return Vec3(v[0], v[1], v[2]);
}

Vec3 parseDirection(const std::string& text, const std::string& option, const std::string& example) {
    const std::vector<double> v = anyNumbers(text, option, 3, 3, example);
    if (v[0] == 0 && v[1] == 0 && v[2] == 0) usageError(option, "'" + text + "': the direction has no length");
    return scaled(Vec3(v[0], v[1], v[2]));
}

Color parseColor(const std::string& text, const std::string& option) {
    const std::string example = "0.9 or " + option + " 0.9,0.8,0.7";
    std::string commas = text;
    std::replace(commas.begin(), commas.end(), ':', ',');
    const std::vector<double> c = parseNumbers(commas, option, 1, 3, example);
    if (c.size() == 2)
        usageError(option, "'" + text + "': give one number or three; for example " + option + " " + example);
    if (*std::min_element(c.begin(), c.end()) < 0) usageError(option, "'" + text + "': must not be negative");
    return c.size() == 1 ? grey(float(c[0])) : Color(float(c[0]), float(c[1]), float(c[2]));
}

void requireFactor(double value, const std::string& option) {
    if (!(value >= 0) || std::isinf(value)) usageError(option, "must be a finite number and not negative");
}

void requireFileOutput(const std::string& path, const std::string& option) {
    if (path.empty() || path == "-") usageError(option, "a file name is needed; standard output cannot be used here");
}

void requireRecordName(const std::string& record) {
    if (lowerExtension(record) != ".json") usageError("--record", "'" + record + "' must end in .json");
}

std::vector<std::string> recordFiles(const std::string& record) {
    return {record, recordedFields(record)};
}

std::string numberedName(const std::string& path, int number) {
    const std::filesystem::path whole(path);
    char digits[16];
    std::snprintf(digits, sizeof digits, "_%04d", number);
    return (whole.parent_path() / (whole.stem().string() + digits + whole.extension().string())).string();
}

ThreadLimit start(const CommonOptions& options) {
    requireFilesApart(*options.command);
    if (!options.reportFile.empty()) requireWritable(options.reportFile);
    return ThreadLimit(options.threads);
}

namespace {

/// JSON has no NaN and no infinity: what is written as null in their place is read as "not there".
void requireNumbers(const nlohmann::ordered_json& value, const std::string& name) {
    if (value.is_number_float() && !std::isfinite(value.get<double>()))
        throw InvalidArgument("the report's '" + name + "' is " +
                              (std::isnan(value.get<double>()) ? "NaN" : "infinite") +
                              ": values of input or options are too large, or too small, for what is computed of them");
    if (value.is_object())
        for (const auto& [key, part] : value.items()) requireNumbers(part, name.empty() ? key : name + "." + key);
    if (value.is_array())
        for (const auto& part : value) requireNumbers(part, name);
}

}  // namespace

void requireFinite(const std::vector<float>& values, const std::string& what) {
    const auto bad = std::count_if(values.begin(), values.end(), [](float value) { return !std::isfinite(value); });
    if (bad > 0)
        throw InvalidArgument(
            what + " would have " + std::to_string(bad) +
            " values that are NaN or infinite: light, extinction, background or what is in the volume "
            "is too large for single precision; choose units in which numbers are nearer 1");
}

nlohmann::ordered_json finiteOrNull(double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

void writeReport(const CommonOptions& options, const nlohmann::ordered_json& report) {
    if (options.reportFile.empty()) return;
    requireNumbers(report, "");
    writeText(options.reportFile, report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace raysweep::apps
