#include "raysweep/formats/nrrd_header.h"

#include "raysweep/formats/header_lines.h"

#include <algorithm>
#include <set>

namespace raysweep {
namespace {

const std::set<std::string> kFields = {
    "axismaxs",         "axismins",    "blocksize",  "byteskip", "centerings",  "centers",  "content", "datafile",
    "dimension",        "encoding",    "endian",     "kinds",    "labels",      "lineskip", "max",     "min",
    "measurementframe", "number",      "oldmax",     "oldmin",   "sampleunits", "sizes",    "space",   "spacedimension",
    "spacedirections",  "spaceorigin", "spaceunits", "spacings", "thicknesses", "type",     "units"};

std::string withoutBlanks(std::string text) {
    text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c == ' ' || c == '\t'; }), text.end());
    return lowerCase(text);
}

/// Adds "field: what it says"; passes over comments and "key:=value".
void addLine(const HeaderLines& lines, const std::string& line, NrrdHeader& header) {
    if (line[0] == '#') return;
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) lines.fail("it is not of the form 'field: value'");
    if (line.compare(colon, 2, ":=") == 0) return;
    std::string name = withoutBlanks(line.substr(0, colon));
    if (name == "centerings") name = "centers";
    if (kFields.count(name) == 0)
        lines.fail("NRRD has no field '" + line.substr(0, std::min<std::size_t>(colon, 60)) + "'");
    if (!header.fields.emplace(name, trimmed(line.substr(colon + 1))).second)
        lines.fail("'" + line.substr(0, colon) + "' is given twice");
}

bool isList(const std::string& dataFile) {
    const std::vector<std::string> words = wordsOf(dataFile);
    return !words.empty() && words[0] == "LIST" && words.size() <= 2;
}

}  // namespace

NrrdHeader readNrrdHeader(const std::string& path) {
    HeaderLines lines(path);
    NrrdHeader header;
    std::string line;
    const bool begins = lines.next(line) && line.size() == 8 && line.compare(0, 6, "NRRD00") == 0;
    if (!begins) lines.fail("it is no NRRD, which begins with 'NRRD0001' to 'NRRD0005'");
    while (lines.next(line) && !line.empty()) {
        addLine(lines, line, header);
        if (!header.has("datafile") || !isList(header.of("datafile"))) continue;
        while (lines.next(line))
            if (!trimmed(line).empty()) header.listed.push_back(trimmed(line));
        break;
    }
    header.end = lines.position();
    return header;
}

}  // namespace raysweep
