#include "cli.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/output_file.h"
#include "raysweep/volume/record_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>

namespace raysweep::apps {
namespace {

/// @return false unless `text` is a finite number and nothing else.
bool readNumber(const std::string& text, double& value) {
    const char* begin = text.data();
    const char* end = begin + text.size();
    while (begin != end && *begin == ' ') ++begin;
    while (end != begin && end[-1] == ' ') --end;
    if (begin != end && *begin == '+') ++begin;
    const auto [stop, error] = std::from_chars(begin, end, value);
    return begin != end && error == std::errc() && stop == end && std::isfinite(value);
}

class Config : public CLI::ConfigTOML {
  public:
    explicit Config(const CLI::App& program) : program_(program) {}

    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
        std::vector<CLI::ConfigItem> items = CLI::ConfigTOML::from_config(input);
        for (CLI::ConfigItem& item : items) {
            const auto called = program_.get_subcommands();
            if (item.parents.empty() && !called.empty()) item.parents = {called.front()->get_name()};
            joinNumbers(item.inputs);
        }
        return items;
    }

  private:
    // [0, 0, -1, 3] is one value of an option that takes "0,0,-1,3"; ["a", "b"] gives an option twice.
    static void joinNumbers(std::vector<std::string>& inputs) {
        if (inputs.size() < 2 || !std::all_of(inputs.begin(), inputs.end(), isNumberOrColor)) return;
        std::string joined;
        for (const std::string& input : inputs) joined += (joined.empty() ? "" : ",") + input;
        inputs = {joined};
    }

    static bool isNumberOrColor(const std::string& text) {
        const std::vector<std::string> parts = split(text, ':');
        double ignored = 0;
        return std::all_of(parts.begin(), parts.end(),
                           [&](const std::string& part) { return readNumber(part, ignored); });
    }

    const CLI::App& program_;
};

}  // namespace

void addCommonOptions(CLI::App& app, CommonOptions& options) {
    const std::string group = "Common options";
    app.add_option("--threads", options.threads, "Number of threads; 0: all cores")
        ->check(CLI::Range(0, 4096).description(""))
        ->capture_default_str()
        ->group(group);
    app.add_option("--seed", options.seed, "Seed of everything random")->capture_default_str()->group(group);
    app.add_option("--report", options.reportFile, "Write what was done, and how long it took, to this file")
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

void readConfigFiles(CLI::App& program) {
    program.set_config("--config", "", "Read options from this TOML or INI file")->type_name("FILE");
    program.config_formatter(std::make_shared<Config>(program));
    program.allow_config_extras(CLI::config_extras_mode::error);
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

std::vector<double> parseNumbers(const std::string& text, const std::string& option, std::size_t least,
                                 std::size_t most, const std::string& example) {
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

Vec3 parseVec3(const std::string& text, const std::string& option) {
    const std::vector<double> v = parseNumbers(text, option, 3, 3, "1,0.5,-2");
    return Vec3(v[0], v[1], v[2]);
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

void requireRecordName(const std::string& record, const std::vector<std::string>& others) {
    namespace fs = std::filesystem;
    if (lowerExtension(record) != ".json") usageError("--record", "'" + record + "' must end in .json");
    const auto placeOf = [](const std::string& path) { return fs::absolute(path).lexically_normal(); };
    for (const std::string& written : {record, recordedFields(record)})
        for (const std::string& other : others)
            if (!other.empty() && placeOf(other) == placeOf(written))
                usageError("--record", "'" + written +
                                           "' would be written, but is another file of this command; "
                                           "choose another name");
}

std::string numberedName(const std::string& path, int number) {
    const std::filesystem::path whole(path);
    char digits[16];
    std::snprintf(digits, sizeof digits, "_%04d", number);
    return (whole.parent_path() / (whole.stem().string() + digits + whole.extension().string())).string();
}

ThreadLimit start(const CommonOptions& options) {
    if (!options.reportFile.empty()) requireWritable(options.reportFile);
    return ThreadLimit(options.threads);
}

void writeReport(const CommonOptions& options, const nlohmann::ordered_json& report) {
    if (options.reportFile.empty()) return;
    OutputFile target(options.reportFile);
    std::ofstream out(target.temporary());
    out << report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
    out.close();
    if (!out) throw IoError("cannot write '" + options.reportFile + "': the disk may be full");
    target.commit();
}

}  // namespace raysweep::apps
