/// Records of runs (docs/record.md): numbers in a JSON file, fields in a .vdb file beside it. For sources alone.
#pragma once

#include "raysweep/volume/grids.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace raysweep {

/// The .vdb file that goes with the record `path`: "RUN.vdb" for "RUN.json".
std::string recordedFields(const std::string& path);

/// Checks that both files could be written. @throw IoError as requireWritable does
void requireRecord(const std::string& path);

/// What every record begins with. @param kind of run: "illuminate"
nlohmann::ordered_json recordHead(const std::string& kind, const std::string& path);

/// Writes both files; they appear whole and together, or not at all. @throw IoError
void writeRecordFiles(const std::string& path, const nlohmann::ordered_json& record,
                      const openvdb::GridCPtrVec& fields);

}  // namespace raysweep
