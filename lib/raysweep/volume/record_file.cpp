#include "raysweep/volume/record_file.h"

#include "raysweep/core/output_file.h"
#include "raysweep/core/text_file.h"
#include "raysweep/volume/vdb_io.h"

#include <nlohmann/json.hpp>

#include <filesystem>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

/// One line for each field, and for each element of a list of objects.
std::string linesOf(const nlohmann::ordered_json& record) {
    std::string text = "{";
    const char* separator = "\n";
    for (const auto& [key, value] : record.items()) {
        text += separator + nlohmann::json(key).dump() + ": ";
        separator = ",\n";
        if (value.is_array() && !value.empty() && value.front().is_object()) {
            for (std::size_t n = 0; n < value.size(); ++n) text += (n == 0 ? "[\n" : ",\n") + value[n].dump();
            text += "\n]";
        } else {
            text += value.dump();
        }
    }
    return text + "\n}\n";
}

}  // namespace

std::string recordedFields(const std::string& path) {
    return fs::path(path).replace_extension(".vdb").string();
}

void requireRecord(const std::string& path) {
    requireWritable(path);
    requireWritable(recordedFields(path));
}

nlohmann::ordered_json recordHead(const std::string& kind, const std::string& path) {
    return {{"raysweep_record", kind},
            {"version", RAYSWEEP_VERSION},
            {"fields", fs::path(recordedFields(path)).filename().string()}};
}

void writeRecordFiles(const std::string& path, const nlohmann::ordered_json& record,
                      const openvdb::GridCPtrVec& fields) {
    OutputFile numbersFile(path), fieldsFile(recordedFields(path));
    writeVdb(fieldsFile, fields);
    writeText(numbersFile, linesOf(record));
    fieldsFile.flush();
    numbersFile.flush();
    fieldsFile.commit();
    numbersFile.commit();
}

}  // namespace raysweep
