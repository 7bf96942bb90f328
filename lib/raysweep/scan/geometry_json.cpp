#include "raysweep/scan/geometry_json.h"

#include "raysweep/core/error.h"

#include <nlohmann/json.hpp>

#include <limits>
#include <set>
#include <vector>

namespace raysweep {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;
const char* const kFormat = "raysweep-geometry";

/// The fields of one JSON object, each taken once. `where` stands before its keys in messages: "views[3].".
class Fields {
  public:
    Fields(const json& object, std::string where) : object_(object), where_(std::move(where)) {
        if (!object_.is_object())
            throw IoError((where_.empty() ? "the file" : where_.substr(0, where_.size() - 1)) +
                          " must be an object { }");
    }

    bool has(const std::string& key) const { return object_.contains(key); }

    const json& at(const std::string& key) {
        if (!has(key)) throw IoError("'" + where_ + key + "' is missing");
        taken_.insert(key);
        return object_[key];
    }

    double number(const std::string& key) {
        const json& value = at(key);
        if (!value.is_number()) fail(key, "a number");
        return value.get<double>();
    }

    int integer(const std::string& key) {
        const json& value = at(key);
        const bool good = value.is_number_integer() && value.get<double>() >= std::numeric_limits<int>::min() &&
                          value.get<double>() <= std::numeric_limits<int>::max();
        if (!good) fail(key, "a whole number");
        return value.get<int>();
    }

    std::string text(const std::string& key) {
        const json& value = at(key);
        if (!value.is_string()) fail(key, "a text");
        return value.get<std::string>();
    }

    Vec3 vector(const std::string& key) {
        const json& value = at(key);
        if (!value.is_array() || value.size() != 3 || !value[0].is_number() || !value[1].is_number() ||
            !value[2].is_number())
            fail(key, "an array of three numbers");
        return Vec3(value[0].get<double>(), value[1].get<double>(), value[2].get<double>());
    }

    /// To be called when all fields that there can be were taken.
    void requireNoMore() const {
        for (const auto& item : object_.items())
            if (!taken_.count(item.key())) throw IoError("'" + where_ + item.key() + "' is not known here");
    }

    [[noreturn]] void fail(const std::string& key, const std::string& what) const {
        throw IoError("'" + where_ + key + "' must be " + what);
    }

  private:
    const json& object_;
    std::string where_;
    std::set<std::string> taken_;
};

/// A parser that refuses objects with one key twice; the library's own would keep the last.
json parsed(const std::string& text) {
    std::vector<std::set<std::string>> open;
    const auto once = [&open](int, json::parse_event_t event, json& value) {
        if (event == json::parse_event_t::object_start) open.emplace_back();
        if (event == json::parse_event_t::object_end) open.pop_back();
        if (event == json::parse_event_t::key && !open.back().insert(value.get<std::string>()).second)
            throw IoError("'" + value.get<std::string>() + "' is given twice in one object");
        return true;
    };
    try {
        return json::parse(text, once);
    } catch (const json::exception& error) {
        throw IoError("it is not valid JSON: " + std::string(error.what()));
    }
}

BeamShape beamOf(Fields& fields) {
    const std::string beam = fields.text("beam");
    if (beam != "cone" && beam != "parallel") fields.fail("beam", "\"cone\" or \"parallel\"");
    return beam == "cone" ? BeamShape::cone : BeamShape::parallel;
}

XrayView viewOf(const json& entry, std::size_t number, BeamShape beam) {
    Fields fields(entry, "views[" + std::to_string(number) + "].");
    XrayView view;
    if (beam == BeamShape::cone)
        view.source = fields.vector("source");
    else
        view.direction = fields.vector("direction");
    view.origin = fields.vector("origin");
    view.column = fields.vector("column");
    view.row = fields.vector("row");
    fields.requireNoMore();
    return view;
}

ProjectionGeometry circularOf(const json& entry, const ProjectionGeometry& detector) {
    Fields fields(entry, "circular.");
    CircularOrbit orbit;
    orbit.beam = detector.beam;
    orbit.width = detector.width;
    orbit.height = detector.height;
    if (orbit.beam == BeamShape::cone) {
        orbit.sourceToAxis = fields.number("sourceToAxis");
        orbit.sourceToDetector = fields.number("sourceToDetector");
    }
    orbit.views = fields.integer("views");
    orbit.arc = fields.number("arc");
    orbit.pixelWidth = fields.number("pixelWidth");
    orbit.pixelHeight = fields.number("pixelHeight");
    if (fields.has("firstAngle")) orbit.firstAngle = fields.number("firstAngle");
    if (fields.has("axisColumn")) orbit.axisColumn = fields.number("axisColumn");
    if (fields.has("centerRow")) orbit.centerRow = fields.number("centerRow");
    if (fields.has("center")) orbit.center = fields.vector("center");
    fields.requireNoMore();
    return circularGeometry(orbit);
}

json arrayOf(const Vec3& v) {
    return json::array({v.x, v.y, v.z});
}

}  // namespace

ProjectionGeometry geometryFromJson(const std::string& text) {
    const json document = parsed(text);
    Fields fields(document, "");
    if (fields.text("format") != kFormat) fields.fail("format", std::string("\"") + kFormat + "\"");
    if (fields.integer("version") != kVersion)
        throw IoError("its version is " + std::to_string(fields.integer("version")) + ", but only version " +
                      std::to_string(kVersion) + " is known");
    ProjectionGeometry geometry;
    geometry.beam = beamOf(fields);
    Fields detector(fields.at("detector"), "detector.");
    geometry.width = detector.integer("width");
    geometry.height = detector.integer("height");
    detector.requireNoMore();
    if (fields.has("views") == fields.has("circular"))
        throw IoError("it must have either 'views' or 'circular', and has " +
                      std::string(fields.has("views") ? "both" : "neither"));
    if (fields.has("circular")) {
        geometry = circularOf(fields.at("circular"), geometry);
    } else {
        const json& views = fields.at("views");
        if (!views.is_array()) fields.fail("views", "an array [ ]");
        for (const json& entry : views) geometry.views.push_back(viewOf(entry, geometry.views.size(), geometry.beam));
    }
    fields.requireNoMore();
    geometry.validate();
    return geometry;
}

std::string jsonOf(const ProjectionGeometry& geometry) {
    const bool cone = geometry.beam == BeamShape::cone;
    const nlohmann::ordered_json detector = {{"width", geometry.width}, {"height", geometry.height}};
    std::string text = "{\n\"format\": \"" + std::string(kFormat) + "\",\n\"version\": " + std::to_string(kVersion) +
                       ",\n\"beam\": \"" + (cone ? "cone" : "parallel") + "\",\n\"detector\": " + detector.dump() +
                       ",\n\"views\": [";
    const char* separator = "\n";
    for (const XrayView& view : geometry.views) {
        nlohmann::ordered_json entry;
        if (cone)
            entry["source"] = arrayOf(view.source);
        else
            entry["direction"] = arrayOf(view.direction);
        entry["origin"] = arrayOf(view.origin);
        entry["column"] = arrayOf(view.column);
        entry["row"] = arrayOf(view.row);
        text += separator + entry.dump();
        separator = ",\n";
    }
    return text + "\n]\n}\n";
}

}  // namespace raysweep
