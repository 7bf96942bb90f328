#include "raysweep/scan/view_angles.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"
#include "raysweep/core/text_file.h"
#include "raysweep/core/types.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

namespace raysweep {
namespace {

/// From the first to where one after the last would be.
double covered(const std::vector<double>& angles) {
    const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
    const double span = *most - *least;
    return angles.size() < 2 ? span : span * double(angles.size()) / double(angles.size() - 1);
}

bool looksLikeRadians(const std::vector<double>& angles) {
    constexpr double kLeast = 150 * kPi / 180, kMost = 2.1 * kPi;
    if (angles.size() < 2 || covered(angles) < kLeast || covered(angles) > kMost) return false;
    return std::any_of(angles.begin(), angles.end(), [](double angle) { return angle != std::round(angle); });
}

/// Nothing if it is no unit that is known.
std::optional<AngleUnit> unitOf(std::string name) {
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    for (const char* radians : {"rad", "rads", "radian", "radians"})
        if (name == radians) return AngleUnit::radians;
    for (const char* degrees : {"deg", "degs", "degree", "degrees", "\xc2\xb0"})
        if (name == degrees) return AngleUnit::degrees;
    return {};
}

}  // namespace

ViewAngles viewAngles(std::vector<double> numbers, const std::string& units, const std::optional<AngleUnit>& asked) {
    ViewAngles angles;
    const std::optional<AngleUnit> named = unitOf(units);
    const bool radians = looksLikeRadians(numbers);
    const AngleUnit unit = asked ? *asked : named ? *named : radians ? AngleUnit::radians : AngleUnit::degrees;
    const std::string range = brief(covered(numbers), 4);
    if (!asked && named && unit == AngleUnit::radians)
        angles.said = "the file's angles are in radians, as it says";
    else if (!asked && !named && radians)
        angles.said = "the angles are taken for radians, as they cover " + range +
                      "; if they are degrees, say so with `angleUnit`";
    else if (!asked && !named && !units.empty())
        angles.said = "the unit of the angles, '" + units + "', is not known: they are taken for degrees";
    else if (unit == AngleUnit::degrees && radians)
        angles.said = "the angles cover " + range + " degrees only; if they are radians, say so with `angleUnit`";
    if (unit == AngleUnit::radians)
        for (double& number : numbers) number *= 180 / kPi;
    constexpr double kTurns = 10;
    if (covered(numbers) > 360 * kTurns)
        angles.said = "the angles cover " + brief(covered(numbers) / 360, 3) +
                      " turns; is their unit the right one? `angleUnit` says it";
    angles.degrees = std::move(numbers);
    return angles;
}

std::vector<double> readAngleFile(const std::string& path) {
    const auto fail = [&](const std::string& why) -> std::string {
        throw IoError("cannot read '" + path + "': " + why);
    };
    std::string text;
    try {
        text = bytesOfFile(path, "a text file of angles");
    } catch (const IoError& error) {
        fail(error.what());
    }
    std::vector<double> angles;
    int line = 1;
    const char *at = text.data(), *const end = at + text.size();
    if (text.rfind("\xef\xbb\xbf", 0) == 0) at += 3;  // what some editors put before UTF-8
    while (at != end) {
        if (*at == '#') at = std::find(at, end, '\n');
        if (at == end) break;
        if (*at == '\n') ++line;
        if (std::isspace(static_cast<unsigned char>(*at)) || *at == ',' || *at == ';') {
            ++at;
            continue;
        }
        double angle = 0;
        const auto [next, failed] = std::from_chars(*at == '+' ? at + 1 : at, end, angle);
        const bool ends = next == end || std::isspace(static_cast<unsigned char>(*next)) || *next == ',' ||
                          *next == ';' || *next == '#';
        if (failed != std::errc() || !std::isfinite(angle) || !ends) {
            std::string word;
            for (const char* c = at; c != end && !std::isspace(static_cast<unsigned char>(*c)) && word.size() < 20; ++c)
                word += std::isprint(static_cast<unsigned char>(*c)) ? *c : '?';
            fail("line " + std::to_string(line) + ": '" + word + "' is no angle, a finite number");
        }
        angles.push_back(angle);
        at = next;
    }
    if (angles.empty()) fail("it has no angles");
    return angles;
}

}  // namespace raysweep
