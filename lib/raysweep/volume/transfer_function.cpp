#include "raysweep/volume/transfer_function.h"

#include "raysweep/core/error.h"
#include "raysweep/core/json_fields.h"
#include "raysweep/core/require.h"
#include "raysweep/core/text_file.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace raysweep {
namespace {

using nlohmann::json;

const char* const kForm =
    "a point is {\"value\": v, \"opacity\": a} or {\"value\": v, \"opacity\": a, "
    "\"color\": [r, g, b]}";

std::string textOf(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

void requireFraction(double value, const std::string& what) {
    requireField(value >= 0 && value <= 1, what, value, "in [0,1]");
}

double numberFrom(const json& point, const char* key) {
    const auto found = point.find(key);
    if (found == point.end()) throw InvalidArgument(std::string("there is no \"") + key + "\"; " + kForm);
    if (!found->is_number())
        throw InvalidArgument(std::string("\"") + key + "\" is " + found->dump() + ", not a number; " + kForm);
    return found->get<double>();
}

Color colorFrom(const json& list) {
    if (!list.is_array() || list.size() != 3 ||
        !std::all_of(list.begin(), list.end(), [](const json& x) { return x.is_number(); }))
        throw InvalidArgument("\"color\" is " + list.dump() + ", not a list of three numbers; " + kForm);
    return Color(list[0].get<float>(), list[1].get<float>(), list[2].get<float>());
}

TransferPoint pointFrom(const json& entry) {
    if (!entry.is_object()) throw InvalidArgument(entry.dump() + " is no object; " + kForm);
    for (const auto& item : entry.items())
        if (item.key() != "value" && item.key() != "opacity" && item.key() != "color")
            throw InvalidArgument("\"" + item.key() + "\" is not known; " + kForm);
    TransferPoint point;
    point.value = numberFrom(entry, "value");
    point.opacity = numberFrom(entry, "opacity");
    if (entry.contains("color")) point.color = colorFrom(entry["color"]);
    return point;
}

TransferFunction functionFrom(const json& document) {
    if (!document.is_array()) throw InvalidArgument(std::string("a list of points is needed; ") + kForm);
    TransferFunction function;
    for (const json& entry : document) {
        const std::string number = std::to_string(function.points.size() + 1);
        try {
            function.points.push_back(pointFrom(entry));
        } catch (const InvalidArgument& e) {
            throw InvalidArgument("point " + number + ": " + e.what());
        }
        const bool coloured = entry.contains("color");
        if (function.points.size() > 1 && coloured != function.coloured)
            throw InvalidArgument("point " + number + (coloured ? " has" : " has no") +
                                  " \"color\", unlike those before; give it in all points or in none");
        function.coloured = coloured;
    }
    function.validate();
    return function;
}

}  // namespace

void TransferFunction::validate() const {
    if (points.empty()) throw InvalidArgument("a transfer function needs at least one point");
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::string point = "point " + std::to_string(i + 1) + ": ";
        requireField(std::isfinite(points[i].value), point + "value", points[i].value, "finite");
        if (i > 0 && points[i].value < points[i - 1].value)
            throw InvalidArgument(point + "value " + textOf(points[i].value) + " is below that of the point before, " +
                                  textOf(points[i - 1].value) + "; values must ascend");
        requireFraction(points[i].opacity, point + "opacity");
        for (int c = 0; coloured && c < 3; ++c) requireFraction(double(points[i].color[c]), point + "color");
    }
}

TransferFunction rampFunction(double low, double high, double opacity) {
    if (!std::isfinite(low) || !std::isfinite(high) || !(low < high))
        throw InvalidArgument("a ramp from " + textOf(low) + " to " + textOf(high) +
                              ": both must be finite, and the first below the second");
    requireField(opacity > 0 && opacity <= 1, "a ramp's opacity", opacity, "in (0,1]");
    return {{{low, 0}, {high, opacity}}, false};
}

TransferFunction readTransferFunction(const std::string& path) {
    try {
        return functionFrom(parseJson(bytesOfFile(path, "a JSON file")));
    } catch (const Error& e) {
        throw IoError("cannot read '" + path + "': " + e.what());
    }
}

std::string toJson(const TransferFunction& function) {
    nlohmann::ordered_json document = nlohmann::ordered_json::array();
    for (const TransferPoint& point : function.points) {
        nlohmann::ordered_json entry = {{"value", point.value}, {"opacity", point.opacity}};
        if (function.coloured) entry["color"] = {point.color.x, point.color.y, point.color.z};
        document.push_back(entry);
    }
    return document.dump();
}

TransferPoint evaluate(const TransferFunction& function, double value) {
    const std::vector<TransferPoint>& points = function.points;
    const auto above = std::upper_bound(points.begin(), points.end(), value,
                                        [](double v, const TransferPoint& point) { return v < point.value; });
    TransferPoint result = above == points.begin() ? points.front() : above[-1];
    if (above != points.begin() && above != points.end()) {
        const double t = (value - result.value) / (above->value - result.value);
        result.opacity += t * (above->opacity - result.opacity);
        result.color += (above->color - result.color) * float(t);
    }
    result.value = value;
    return result;
}

double extinctionFromOpacity(double opacity, double edge) {
    return -std::log1p(-std::min(opacity, kMostOpaque)) / edge;
}

}  // namespace raysweep
