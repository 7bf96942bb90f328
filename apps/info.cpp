/// raysweep info: what a .vdb file holds.
#include "cli.h"

#include "raysweep/volume/statistics.h"
#include "raysweep/volume/vdb_io.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <iostream>
#include <memory>

namespace raysweep::apps {
namespace {

using json = nlohmann::ordered_json;

json toJson(const openvdb::Vec3d& v) {
    return {v.x(), v.y(), v.z()};
}
json toJson(const openvdb::Coord& c) {
    return {c.x(), c.y(), c.z()};
}

json boxToJson(const openvdb::CoordBBox& box, const openvdb::math::Transform& transform) {
    // A voxel reaches half an index unit beyond its coordinates.
    const openvdb::BBoxd outer(box.min().asVec3d() - 0.5, box.max().asVec3d() + 0.5);
    const openvdb::BBoxd world = transform.indexToWorld(outer);
    return {{"index", {toJson(box.min()), toJson(box.max())}}, {"world", {toJson(world.min()), toJson(world.max())}}};
}

json transformToJson(const openvdb::math::Transform& transform) {
    json result = {
        {"type", transform.mapType()}, {"linear", transform.isLinear()}, {"voxel_size", toJson(transform.voxelSize())}};
    if (!transform.isLinear()) return result;
    const openvdb::Mat4R m = transform.baseMap()->getAffineMap()->getMat4();
    for (int row = 0; row < 4; ++row) result["matrix"].push_back({m(row, 0), m(row, 1), m(row, 2), m(row, 3)});
    return result;
}

/// Numbers stay numbers, with all their digits.
json valueToJson(const openvdb::Metadata& value) {
    if (const auto* number = dynamic_cast<const openvdb::DoubleMetadata*>(&value)) return number->value();
    if (const auto* number = dynamic_cast<const openvdb::FloatMetadata*>(&value)) return number->value();
    if (const auto* number = dynamic_cast<const openvdb::Int32Metadata*>(&value)) return number->value();
    return value.str();
}

/// Statistics that OpenVDB writes along are left out: they are shown as measured.
json metadataToJson(const openvdb::MetaMap& metadata) {
    json result = json::object();
    for (auto it = metadata.beginMeta(); it != metadata.endMeta(); ++it)
        if (it->first.rfind("raysweep_", 0) == 0) result[it->first] = valueToJson(*it->second);
    return result;
}

json describe(const openvdb::GridBase& grid) {
    json result = {{"name", grid.getName()},
                   {"type", grid.valueType()},
                   {"grid_type", grid.type()},
                   {"class", openvdb::GridBase::gridClassToString(grid.getGridClass())},
                   {"saved_as_half", grid.saveFloatAsHalf()},
                   {"transform", transformToJson(grid.transform())},
                   {"active_voxels", grid.activeVoxelCount()},
                   {"active_tiles", grid.baseTree().activeTileCount()},
                   {"leaves", grid.baseTree().leafCount()},
                   {"memory_bytes", grid.memUsage()},
                   {"metadata", metadataToJson(grid)}};
    if (!grid.empty() && grid.activeVoxelCount() > 0)
        result["bounds"] = boxToJson(grid.evalActiveVoxelBoundingBox(), grid.transform());
    if (hasKnownValues(grid)) {
        const ValueRange range = valueRange(grid);
        result["min"] = range.min;
        result["max"] = range.max;
        result["not_finite"] = range.notFinite;
    }
    return result;
}

std::string joined(const json& numbers) {
    std::string text;
    for (const json& number : numbers) {
        char buffer[32];
        std::snprintf(buffer, sizeof buffer, "%.6g", number.get<double>());
        text += (text.empty() ? "" : ", ") + std::string(buffer);
    }
    return numbers.size() == 1 ? text : "(" + text + ")";
}

/// Text of several lines starts on a line of its own.
std::string indented(std::string text) {
    while (!text.empty() && text.back() == '\n') text.pop_back();
    if (text.find('\n') == std::string::npos) return text;
    std::string result;
    for (const std::string& line : split(text, '\n')) result += "\n    " + line;
    return result;
}

void printMetadata(const json& metadata, const std::string& indent) {
    for (const auto& [key, value] : metadata.items())
        std::cout << indent << key << " = " << (value.is_string() ? indented(value.get<std::string>()) : value.dump())
                  << "\n";
}

void printGrid(const json& grid) {
    const std::string name = grid["name"];
    std::cout << (name.empty() ? "(no name)" : name) << ": " << grid["type"].get<std::string>()
              << (grid["saved_as_half"] ? " saved as half" : "") << ", " << grid["class"].get<std::string>() << "\n"
              << "  voxel size     " << joined(grid["transform"]["voxel_size"]) << " ("
              << grid["transform"]["type"].get<std::string>() << ")\n"
              << "  active voxels  " << grid["active_voxels"] << " in " << grid["leaves"] << " leaves and "
              << grid["active_tiles"] << " tiles\n";
    if (grid.contains("bounds")) {
        const json& b = grid["bounds"];
        std::cout << "  index box      " << joined(b["index"][0]) << " to " << joined(b["index"][1]) << "\n"
                  << "  world box      " << joined(b["world"][0]) << " to " << joined(b["world"][1]) << "\n";
    }
    if (grid.contains("min") && !grid["min"].empty())
        std::cout << "  values         " << joined(grid["min"]) << " to " << joined(grid["max"]) << "\n";
    if (grid.contains("not_finite") && grid["not_finite"] != 0)
        std::cout << "  not finite     " << grid["not_finite"] << " voxels\n";
    std::cout << "  memory         " << joined({grid["memory_bytes"].get<double>() / (1 << 20)}) << " MiB\n";
    printMetadata(grid["metadata"], "  ");
}

void print(const json& info) {
    std::cout << info["file"].get<std::string>() << ": " << info["grids"].size()
              << (info["grids"].size() == 1 ? " grid" : " grids") << "\n";
    printMetadata(info["metadata"], "");
    for (const json& grid : info["grids"]) printGrid(grid);
    for (const json& grid : info["unreadable"])
        std::cout << (grid["name"].get<std::string>().empty() ? "(no name)" : grid["name"].get<std::string>()) << ": "
                  << grid["type"].get<std::string>() << ", cannot be read\n";
}

struct InfoOptions {
    CommonOptions common;
    std::string file;
    bool json = false;
};

/// What cannot be shown of a grid need not keep others from being shown.
json describeOrError(const openvdb::GridBase& grid) {
    try {
        return describe(grid);
    } catch (const openvdb::Exception& e) {
        return {{"name", grid.getName()},
                {"type", grid.valueType()},
                {"error", "grid '" + grid.getName() + "': " + e.what()}};
    }
}

int runInfo(const InfoOptions& options) {
    const ThreadLimit limit = start(options.common);
    const VdbSurvey survey = surveyVdb(options.file);
    const VdbFile& file = survey.file;
    json info = {{"file", options.file},
                 {"metadata", metadataToJson(file.metadata)},
                 {"grids", json::array()},
                 {"unreadable", json::array()}};
    for (const auto& grid : file.grids) {
        const json described = describeOrError(*grid);
        info[described.contains("error") ? "unreadable" : "grids"].push_back(described);
    }
    for (const UnreadableGrid& grid : survey.unreadable)
        info["unreadable"].push_back({{"name", grid.name}, {"type", grid.type}, {"error", grid.error}});
    if (options.json)
        std::cout << info.dump(2, ' ', false, json::error_handler_t::replace) << "\n";
    else
        print(info);
    writeReport(options.common, info);
    if (info["unreadable"].empty()) return kDone;
    for (const json& grid : info["unreadable"])
        std::fprintf(stderr, "raysweep: '%s': %s\n", options.file.c_str(), grid["error"].get<std::string>().c_str());
    return kFailed;
}

}  // namespace

void addInfo(CLI::App& app, int& exitCode) {
    CLI::App* command =
        app.add_subcommand("info",
                           "Show the grids of a .vdb file: types, transforms, sizes, values; exit code 1 if one cannot "
                           "be read, after showing the others");
    const auto options = std::make_shared<InfoOptions>();
    reads(command->add_option("file", options->file, "The .vdb file"))->required()->type_name("FILE.vdb");
    command->add_flag("--json", options->json, "Print JSON");
    addCommonOptions(*command, options->common);
    command->callback([options, &exitCode] { exitCode = runInfo(*options); });
}

}  // namespace raysweep::apps
