/// The text that an NRRD file begins with. Source: Teem, "Definition of NRRD File Format".
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace raysweep {

struct NrrdHeader {
    std::map<std::string, std::string> fields;  ///< by name, in lower case and without blanks ("spacedirections")
    std::vector<std::string> listed;            ///< data files, where the field says LIST
    std::uint64_t end = 0;                      ///< of the header, bytes: where data are that are in the same file

    /// What the field says; empty if there is none.
    std::string of(const std::string& field) const {
        const auto found = fields.find(field);
        return found == fields.end() ? "" : found->second;
    }
    bool has(const std::string& field) const { return fields.count(field) > 0; }
};

/// @throw IoError if `path` is no NRRD, a line is none of its kinds, or a field is unknown or occurs twice.
NrrdHeader readNrrdHeader(const std::string& path);

}  // namespace raysweep
