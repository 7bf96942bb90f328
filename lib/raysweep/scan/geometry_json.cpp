#include "raysweep/scan/geometry_json.h"

#include "raysweep/core/error.h"
#include "raysweep/core/json_fields.h"

#include <nlohmann/json.hpp>

namespace raysweep {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;
const char* const kFormat = "raysweep-geometry";

BeamShape beamOf(JsonFields& fields) {
    const std::string beam = fields.text("beam");
    if (beam != "cone" && beam != "parallel") fields.fail("beam", "\"cone\" or \"parallel\"");
    return beam == "cone" ? BeamShape::cone : BeamShape::parallel;
}

XrayView viewOf(const json& entry, std::size_t number, BeamShape beam) {
    JsonFields fields(entry, "views[" + std::to_string(number) + "].");
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
    JsonFields fields(entry, "circular.");
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
    const json document = parseJson(text);
    JsonFields fields(document, "");
    if (fields.text("format") != kFormat) fields.fail("format", std::string("\"") + kFormat + "\"");
    if (fields.integer("version") != kVersion)
        throw IoError("its version is " + std::to_string(fields.integer("version")) + ", but only version " +
                      std::to_string(kVersion) + " is known");
    ProjectionGeometry geometry;
    geometry.beam = beamOf(fields);
    JsonFields detector(fields.at("detector"), "detector.");
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

nlohmann::ordered_json jsonOfViews(const ProjectionGeometry& geometry) {
    nlohmann::ordered_json views = nlohmann::ordered_json::array();
    for (const XrayView& view : geometry.views) {
        nlohmann::ordered_json entry;
        if (geometry.beam == BeamShape::cone)
            entry["source"] = arrayOf(view.source);
        else
            entry["direction"] = arrayOf(view.direction);
        entry["origin"] = arrayOf(view.origin);
        entry["column"] = arrayOf(view.column);
        entry["row"] = arrayOf(view.row);
        views.push_back(entry);
    }
    return views;
}

std::string jsonOf(const ProjectionGeometry& geometry) {
    const bool cone = geometry.beam == BeamShape::cone;
    const nlohmann::ordered_json detector = {{"width", geometry.width}, {"height", geometry.height}};
    std::string text = "{\n\"format\": \"" + std::string(kFormat) + "\",\n\"version\": " + std::to_string(kVersion) +
                       ",\n\"beam\": \"" + (cone ? "cone" : "parallel") + "\",\n\"detector\": " + detector.dump() +
                       ",\n\"views\": [";
    const char* separator = "\n";
    for (const auto& entry : jsonOfViews(geometry)) {
        text += separator + entry.dump();
        separator = ",\n";
    }
    return text + "\n]\n}\n";
}

}  // namespace raysweep
