#include "raysweep/illuminate/illumination_record.h"

#include "raysweep/volume/record_file.h"

#include <nlohmann/json.hpp>

namespace raysweep {
namespace {

using Json = nlohmann::ordered_json;

template <class Vector>
Json arrayOf(const Vector& v) {
    return Json::array({v[0], v[1], v[2]});
}

Json rowsOf(const Matrix3& m) {
    return Json::array({arrayOf(m[0]), arrayOf(m[1]), arrayOf(m[2])});
}

/// One value for each wavelength.
template <class Values>
Json channelsOf(const Values& values, int channels) {
    Json json = Json::array();
    for (int c = 0; c < channels; ++c) json.push_back(double(values[c]));
    return json;
}

Json describe(const RecordedGroup& group, int channels) {
    Json beams = Json::array();
    for (const RecordedBeam& beam : group.beams)
        beams.push_back({{"direction", arrayOf(beam.direction)},
                         {"offset", Json::array({beam.column, beam.row})},
                         {"entering", channelsOf(beam.entering, channels)},
                         {"entered", channelsOf(beam.sums.entered, channels)},
                         {"escaped", channelsOf(beam.sums.escaped, channels)}});
    return {{"inject", group.inject}, {"beams", beams}, {"unshot", channelsOf(group.unshot.value, channels)}};
}

Json describe(const IlluminationRecord& record, const std::string& path) {
    const int channels = record.channels;
    Json json = recordHead("illuminate", path);
    json["volume"] = {{"grid", record.density}, {"checksum", record.checksum}};
    json["lattice"] = {{"low", arrayOf(record.low)},
                       {"high", arrayOf(record.high)},
                       {"world_from_index", rowsOf(record.worldFromIndex)}};
    json["exchange"] = record.asPrinted ? "as-printed" : "corrected";
    json["interpolation"] = record.interpolation == Interpolation::linear ? "linear" : "nearest";
    json["channels"] = channels;
    json["albedo"] = record.albedoGrid ? Json("grid") : channelsOf(record.albedo, channels);
    json["power_unit"] = record.powerUnit;
    json["zeta"] = record.zeta;
    json["most_shot"] = record.mostShot;
    json["suns"] = Json::array();
    for (const Sun& sun : record.suns)
        json["suns"].push_back(
            {{"direction", arrayOf(sun.direction)}, {"irradiance", channelsOf(sun.irradiance, channels)}});
    json["other_sources"] = record.otherSources;
    json["surface_opacity"] = record.surfaceOpacity;
    json["groups"] = Json::array();
    for (const RecordedGroup& group : record.groups) json["groups"].push_back(describe(group, channels));
    json["injections"] = record.injections;
    json["settled"] = record.settled;
    return json;
}

}  // namespace

void writeRecord(const std::string& path, const IlluminationRecord& record) {
    openvdb::GridCPtrVec fields;
    const auto add = [&](const openvdb::GridBase::Ptr& grid, const char* name) {
        if (!grid) return;
        grid->setName(name);
        fields.push_back(grid);
    };
    add(record.extinction, "extinction");
    add(record.albedoGrid, "albedo");
    add(record.normals, "normal");
    add(record.source, "source");
    add(record.scattered, "source_scattered");
    add(record.emission, "emission");
    add(record.unshotStart, "unshot_start");
    add(record.deposit, "deposit");
    add(record.unshot, "unshot");
    add(record.settledDeposit, "settled");
    writeRecordFiles(path, describe(record, path), fields);
}

}  // namespace raysweep
