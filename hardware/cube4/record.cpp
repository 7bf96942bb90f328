#include "cube4/record.h"

#include "raysweep/core/error.h"
#include "raysweep/core/json_fields.h"
#include "raysweep/core/text_file.h"

#include <cmath>
#include <filesystem>

namespace raysweep::cube4 {
namespace {

constexpr int kMostChannels = 3;

nlohmann::json readJson(const std::string& path) {
    try {
        return parseJson(bytesOfFile(path, "a record of a run (.json)"));
    } catch (const IoError& e) {
        const std::string what = e.what();
        throw IoError(what.find(path) == std::string::npos ? path + ": " + what : what);
    }
}

/// `read(fields)` of the file's top object; what goes wrong is said of the file.
template <class Read>
auto readRecord(const std::string& path, const std::string& kind, const Read& read) {
    const nlohmann::json json = readJson(path);
    try {
        JsonFields fields(json, "");
        if (const std::string found = fields.text("raysweep_record"); found != kind)
            fields.fail("raysweep_record",
                        "\"" + kind + "\"; it is \"" + found + "\", which is for another subcommand");
        auto record = read(fields);
        record.file.path = path;
        record.file.fields = readVdb((std::filesystem::path(path).parent_path() / fields.text("fields")).string());
        return record;
    } catch (const IoError& e) {
        const std::string what = e.what();
        throw IoError(what.find(".vdb") != std::string::npos ? what : path + ": " + what);
    }
}

std::vector<double> numbers(JsonFields& fields, const std::string& key, std::size_t count) {
    const nlohmann::json& list = fields.at(key);
    std::vector<double> values;
    if (list.is_array())
        for (const nlohmann::json& value : list)
            if (value.is_number() && std::isfinite(value.get<double>())) values.push_back(value.get<double>());
    if (values.size() != count || list.size() != count)
        fields.fail(key, "a list of " + std::to_string(count) + " numbers");
    return values;
}

Index3 indices(JsonFields& fields, const std::string& key) {
    const std::vector<double> values = numbers(fields, key, 3);
    constexpr double kMost = 1 << 28;
    for (const double value : values)
        if (std::abs(value) > kMost || value != std::floor(value)) fields.fail(key, "three whole numbers");
    return Index3(int(values[0]), int(values[1]), int(values[2]));
}

Matrix3 matrix(JsonFields& fields, const std::string& key) {
    const nlohmann::json& rows = fields.at(key);
    Matrix3 m;
    if (!rows.is_array() || rows.size() != 3) fields.fail(key, "three rows of three numbers");
    for (int i = 0; i < 3; ++i) {
        nlohmann::json one = {{"row", rows[std::size_t(i)]}};
        JsonFields row(one, key + "[" + std::to_string(i) + "].");
        const std::vector<double> values = numbers(row, "row", 3);
        for (int j = 0; j < 3; ++j) m[i][j] = values[std::size_t(j)];
    }
    if (!(std::abs(m.determinant()) > 0)) fields.fail(key, "a matrix that can be inverted");
    return m;
}

bool flag(JsonFields& fields, const std::string& key) {
    const nlohmann::json& value = fields.at(key);
    if (!value.is_boolean()) fields.fail(key, "true or false");
    return value.get<bool>();
}

std::optional<double> numberOrNull(JsonFields& fields, const std::string& key) {
    if (fields.at(key).is_null()) return std::nullopt;
    return fields.number(key);
}

/// Calls `read(fields of an element)` for each element of the list `key`.
template <class Read>
void forEachElement(JsonFields& fields, const std::string& key, const Read& read) {
    const nlohmann::json& list = fields.at(key);
    if (!list.is_array()) fields.fail(key, "a list");
    for (std::size_t i = 0; i < list.size(); ++i) {
        JsonFields element(list[i], key + "[" + std::to_string(i) + "].");
        read(element);
    }
}

RecordedGroup readGroup(JsonFields& fields, std::size_t channels) {
    RecordedGroup group;
    group.inject = flag(fields, "inject");
    forEachElement(fields, "beams", [&](JsonFields& beam) {
        RecordedBeam recorded;
        recorded.direction = beam.vector("direction");
        if (!(recorded.direction.length() > 0)) beam.fail("direction", "longer than 0");
        const std::vector<double> offset = numbers(beam, "offset", 2);
        for (const double part : offset)
            if (!(part >= 0 && part < 1)) beam.fail("offset", "two numbers in [0,1)");
        recorded.offsetU = offset[0];
        recorded.offsetV = offset[1];
        recorded.entering = numbers(beam, "entering", channels);
        recorded.entered = numbers(beam, "entered", channels);
        recorded.escaped = numbers(beam, "escaped", channels);
        group.beams.push_back(recorded);
    });
    return group;
}

template <class Value>
Value oneOf(JsonFields& fields, const std::string& key, const std::string& first, Value ofFirst,
            const std::string& second, Value ofSecond) {
    const std::string text = fields.text(key);
    if (text != first && text != second) fields.fail(key, "\"" + first + "\" or \"" + second + "\"");
    return text == first ? ofFirst : ofSecond;
}

/// The grid of line integrals has a voxel for each pixel of each view.
void requireProjections(const ReconstructionRecord& record) {
    const openvdb::CoordBBox found = fieldOf(record.file, "projections")->evalActiveVoxelBoundingBox();
    const openvdb::CoordBBox wanted(openvdb::Coord(0),
                                    openvdb::Coord(record.width - 1, record.height - 1, int(record.views.size()) - 1));
    if (found != wanted)
        throw IoError(record.file.fields.path + ": its projections are not those of " +
                      std::to_string(record.views.size()) + " views of " + std::to_string(record.width) + "x" +
                      std::to_string(record.height) + " pixels, which " + record.file.path + " has");
}

}  // namespace

std::string recordKind(const std::string& path) {
    const nlohmann::json json = readJson(path);
    if (!json.is_object() || !json.contains("raysweep_record") || !json["raysweep_record"].is_string())
        throw IoError(path + ": no record of a run; --record of `light` and `ct` writes one");
    return json["raysweep_record"].get<std::string>();
}

openvdb::GridBase::ConstPtr fieldOf(const RecordFile& file, const std::string& name, bool optional) {
    for (const openvdb::GridBase::Ptr& grid : file.fields.grids)
        if (grid->getName() == name) return grid;
    if (optional) return nullptr;
    throw IoError(file.fields.path + ": has no grid '" + name + "', which " + file.path + " needs");
}

IlluminationRecord readIlluminationRecord(const std::string& path, std::size_t mostVoxels) {
    IlluminationRecord record = readRecord(path, "illuminate", [&](JsonFields& fields) {
        IlluminationRecord read;
        JsonFields volume(fields.at("volume"), "volume.");
        read.grid = volume.text("grid");
        read.checksum = volume.text("checksum");
        JsonFields lattice(fields.at("lattice"), "lattice.");
        read.box.low = indices(lattice, "low");
        read.box.high = indices(lattice, "high");
        for (int axis = 0; axis < 3; ++axis)
            if (read.box.high[axis] <= read.box.low[axis])
                lattice.fail("high", "above `low`; an empty volume leaves nothing to do again");
        read.box.worldFromIndex = matrix(lattice, "world_from_index");
        read.rule =
            oneOf(fields, "exchange", "corrected", ExchangeRule::corrected, "as-printed", ExchangeRule::asPrinted);
        read.resampling = oneOf(fields, "interpolation", "nearest", Resampling::nearest, "linear", Resampling::linear);
        read.channels = fields.integer("channels");
        if (read.channels != 1 && read.channels != kMostChannels) fields.fail("channels", "1 or 3");
        if (!fields.at("albedo").is_string()) read.albedo = numbers(fields, "albedo", std::size_t(read.channels));
        for (const double albedo : read.albedo)
            if (!(albedo >= 0 && albedo <= 1)) fields.fail("albedo", "in [0,1]");
        read.powerUnit = fields.number("power_unit");
        if (!(read.powerUnit > 0)) fields.fail("power_unit", "above 0");
        read.zeta = fields.number("zeta");
        read.mostShot = fields.number("most_shot");
        forEachElement(fields, "suns", [&](JsonFields& sun) {
            read.suns.push_back({sun.vector("direction"), numbers(sun, "irradiance", std::size_t(read.channels))});
        });
        read.otherSources = flag(fields, "other_sources");
        if (fields.has("surface_opacity")) read.surfaceOpacity = fields.number("surface_opacity");
        forEachElement(fields, "groups",
                       [&](JsonFields& group) { read.groups.push_back(readGroup(group, std::size_t(read.channels))); });
        if (read.groups.empty()) fields.fail("groups", "at least one: without sweeps there is nothing to do again");
        read.injections = fields.integer("injections");
        if (read.injections < 0) fields.fail("injections", "0 or more");
        return read;
    });
    requireAtMost(record.box, mostVoxels);
    return record;
}

ReconstructionRecord readReconstructionRecord(const std::string& path, std::size_t mostVoxels) {
    ReconstructionRecord record = readRecord(path, "reconstruct", [&](JsonFields& fields) {
        ReconstructionRecord read;
        JsonFields grid(fields.at("grid"), "grid.");
        read.box.high = indices(grid, "dims");
        for (int axis = 0; axis < 3; ++axis)
            if (read.box.high[axis] <= read.box.low[axis]) grid.fail("dims", "at least 1");
        read.origin = grid.vector("origin");
        read.box.worldFromIndex = matrix(grid, "world_from_voxel");
        JsonFields geometry(fields.at("geometry"), "geometry.");
        read.cone = oneOf(geometry, "beam", "parallel", false, "cone", true);
        read.width = geometry.integer("width");
        read.height = geometry.integer("height");
        forEachElement(geometry, "views", [&](JsonFields& view) {
            RecordedView one;
            (read.cone ? one.source : one.direction) = view.vector(read.cone ? "source" : "direction");
            one.origin = view.vector("origin");
            one.column = view.vector("column");
            one.row = view.vector("row");
            read.views.push_back(one);
        });
        read.totalVariation = fields.number("total_variation");
        read.lower = numberOrNull(fields, "lower");
        read.upper = numberOrNull(fields, "upper");
        read.saturation = numberOrNull(fields, "saturation");
        read.support = fields.text("support") == "automatic";
        forEachElement(fields, "updates", [&](JsonFields& update) {
            RecordedUpdate one;
            const std::vector<double> views = numbers(update, "views", update.at("views").size());
            for (const double view : views) {
                if (view < 0 || view >= double(read.views.size())) update.fail("views", "numbers of views");
                one.views.push_back(int(view));
            }
            one.relaxation = update.number("relaxation");
            if (!(one.relaxation > 0 && one.relaxation < 2)) update.fail("relaxation", "between 0 and 2");
            read.updates.push_back(one);
        });
        if (read.updates.empty()) fields.fail("updates", "at least one");
        return read;
    });
    requireAtMost(record.box, mostVoxels);
    requireProjections(record);
    if (record.support) fieldOf(record.file, "support");
    return record;
}

}  // namespace raysweep::cube4
