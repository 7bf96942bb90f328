/// How --help looks: one line of text per option where it fits, wrapped where it does not, the default at its end.
#include "cli.h"

#include <map>
#include <memory>
#include <sstream>

namespace raysweep::apps {
namespace {

constexpr std::size_t kColumn = 28;  ///< where descriptions start
constexpr std::size_t kWidth = 100;  ///< of the whole text

/// `text` broken between words; lines after the first start at kColumn.
std::string wrapped(const std::string& text) {
    std::istringstream words(text);
    std::string result, word;
    std::size_t column = kColumn;
    while (words >> word) {
        const bool fits = column + 1 + word.size() <= kWidth;
        if (!result.empty()) result += fits ? " " : "\n" + std::string(kColumn, ' ');
        column = (fits ? column + 1 : kColumn) + word.size();
        result += word;
    }
    return result;
}

/// What stands for the value of an option.
std::string placeholder(const CLI::Option& option) {
    static const std::map<std::string, std::string> kNames = {
        {"INT", "N"}, {"UINT", "N"}, {"FLOAT", "X"}, {"TEXT", "NAME"}};
    const std::string name = option.get_type_size() == 0 ? "" : option.get_type_name();
    const auto known = kNames.find(name);
    return known == kNames.end() ? name : known->second;
}

class HelpFormatter : public CLI::Formatter {
  public:
    HelpFormatter() { column_width(kColumn); }

    std::string make_option(const CLI::Option* option, bool positional) const override {
        const std::string value = placeholder(*option);
        std::string name = "  " + (positional ? value : option->get_name(false, true));
        if (name.compare(2, 2, "--") == 0) name.insert(2, "   ");  // aligned with "-o,--output"
        if (!positional && !value.empty()) name += " " + value;
        name += name.size() + 1 < kColumn ? std::string(kColumn - name.size(), ' ') : "\n" + std::string(kColumn, ' ');
        std::string text = option->get_description();
        const std::string& standard = option->get_default_str();
        if (!standard.empty()) text += " (default: " + standard + ")";
        return name + wrapped(text) + "\n";
    }

    // One empty line between groups; the library has two here and there.
    std::string make_usage(const CLI::App* app, std::string name) const override {
        return CLI::Formatter::make_usage(app, name) + "\n";
    }
    std::string make_group(std::string group, bool positional, std::vector<const CLI::Option*> options) const override {
        return CLI::Formatter::make_group(group, positional, options).substr(1) + (positional ? "\n" : "");
    }

    std::string make_option_usage(const CLI::Option* option) const override { return placeholder(*option); }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> helpFormatter() {
    return std::make_shared<HelpFormatter>();
}

}  // namespace raysweep::apps
