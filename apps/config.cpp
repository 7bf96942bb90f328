/// --config: options from a TOML or INI file.
#include "cli.h"

#include <algorithm>
#include <map>
#include <sstream>

namespace raysweep::apps {
namespace {

[[noreturn]] void fail(const std::string& why) {
    throw CLI::ConfigError("--config: " + why);
}

[[noreturn]] void failAt(int line, const std::string& why) {
    fail("line " + std::to_string(line) + ": " + why);
}

/// A file that never ends is not read for ever.
std::string textOf(std::istream& input) {
    constexpr std::size_t kMost = std::size_t(1) << 20;  // bytes
    std::string text(kMost + 1, '\0');
    input.read(text.data(), std::streamsize(text.size()));
    text.resize(std::size_t(input.gcount()));
    if (text.size() > kMost) fail("the file is longer than 1 MiB; this is no list of options");
    if (text.find('\0') != std::string::npos) fail("this is no text file");
    return text;
}

std::string trimmed(const std::string& text) {
    const std::size_t begin = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
    return begin == std::string::npos ? "" : text.substr(begin, end + 1 - begin);
}

/// What the library that reads these files does not look at: sections in sections, of which it copies all names for
/// each, keys that come twice, whose values it puts together, and lists that do not end.
class Checks {
  public:
    void check(const std::string& text) {
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);) {
            ++number_;
            line = trimmed(line);
            if (inList_)
                inList_ = line.empty() || line.back() != ']';
            else if (!line.empty() && line[0] != '#' && line[0] != ';')
                checkLine(line);
        }
        if (inList_) failAt(listStart_, "the list has no end: ']' is missing");
    }

  private:
    void checkLine(const std::string& line) {
        if (line.front() == '[' && line.back() == ']') {
            section_ = line.substr(1, line.size() - 2);
            requireShallow(section_, "section");
            return;
        }
        const std::size_t equals = line.find('=');
        const std::string key = trimmed(line.substr(0, equals));
        requireShallow(key, "key");
        const auto [first, isNew] = seen_.emplace(section_ + "]" + key, number_);
        if (!isNew)
            failAt(number_, "'" + key + "' is given twice, first in line " + std::to_string(first->second) +
                                "; for an option that may be repeated write a list, " + key + " = [\"...\", \"...\"]");
        std::string value = equals == std::string::npos ? "" : trimmed(line.substr(equals + 1));
        value = trimmed(value.substr(0, value.find('#')));
        inList_ = value.size() > 1 && value.front() == '[' && value.back() != ']';
        listStart_ = number_;
    }

    void requireShallow(const std::string& name, const std::string& what) const {
        constexpr int kMostDots = 1;  // light.sun
        if (std::count(name.begin(), name.end(), '.') > kMostDots)
            failAt(number_, "the " + what + " '" + name.substr(0, 32) + (name.size() > 32 ? "..." : "") +
                                "' is nested; only [subcommand] and the options in it are known");
    }

    std::map<std::string, int> seen_;  ///< by section and key, the line
    std::string section_;
    int number_ = 0, listStart_ = 0;
    bool inList_ = false;
};

class Config : public CLI::ConfigTOML {
  public:
    explicit Config(const CLI::App& program) : program_(program) {}

    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
        const std::string text = textOf(input);
        Checks().check(text);
        std::istringstream again(text);
        std::vector<CLI::ConfigItem> items = CLI::ConfigTOML::from_config(again);
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

void readConfigFiles(CLI::App& program) {
    program.set_config("--config", "", "Read options from this TOML or INI file")->type_name("FILE");
    program.config_formatter(std::make_shared<Config>(program));
    program.allow_config_extras(CLI::config_extras_mode::error);
}

}  // namespace raysweep::apps
