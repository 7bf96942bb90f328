/// Stand-in with the names of cli.h, vdb_io.h and grid_select.h, only as much as render.cpp needs. Delete this file and
/// include those three instead as soon as they are there.
#pragma once

#include "command.h"

#include "raysweep/core/error.h"
#include "raysweep/core/progress.h"
#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace raysweep {

struct VdbFile {
    std::string path;
    openvdb::GridPtrVec grids;
    openvdb::MetaMap metadata;
};

inline VdbFile readVdb(const std::string& path) {
    initializeGrids();
    try {
        openvdb::io::File file(path);
        file.open(/*delayLoad=*/false);
        return {path, *file.getGrids(), {}};
    } catch (const openvdb::Exception& e) {
        throw IoError("cannot read '" + path + "': " + e.what());
    }
}

inline openvdb::FloatGrid::Ptr selectDensity(const VdbFile& file, const std::string& name = "") {
    openvdb::FloatGrid::Ptr only;
    int found = 0;
    for (const auto& grid : file.grids) {
        const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
        if (floats && grid->getName() == (name.empty() ? "density" : name)) return floats;
        if (floats) only = floats, ++found;
    }
    if (name.empty() && found == 1) return only;
    throw InvalidArgument("'" + file.path + "': no density grid '" + name + "'");
}

}  // namespace raysweep

namespace raysweep::apps {

inline void addCommonOptions(CLI::App& app, CommonOptions& options) {
    app.add_option("--threads", options.threads, "Number of threads; 0: all cores");
    app.add_option("--seed", options.seed, "Seed of everything random");
    app.add_option("--report", options.reportFile, "Write a report to this JSON file");
    app.add_flag("--quiet", options.quiet, "No messages, no progress");
    app.add_flag("--verbose", options.verbose, "More messages");
}

[[noreturn]] inline void usageError(const std::string& option, const std::string& why) {
    throw CLI::ValidationError(option, why);
}

inline std::vector<double> parseNumbers(const std::string& text, const std::string& option, std::size_t least,
                                        std::size_t most, const std::string& example) {
    std::vector<double> numbers;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, ',');) {
        try {
            numbers.push_back(std::stod(part));
        } catch (const std::exception&) {
            usageError(option, "'" + part + "' is not a number; for example " + option + " " + example);
        }
    }
    if (numbers.size() < least || numbers.size() > most) usageError(option, "for example " + option + " " + example);
    return numbers;
}

inline Vec3 parseVec3(const std::string& text, const std::string& option) {
    const std::vector<double> v = parseNumbers(text, option, 3, 3, "1,0.5,-2");
    return Vec3(v[0], v[1], v[2]);
}

inline Color parseColor(const std::string& text, const std::string& option) {
    const std::vector<double> c = parseNumbers(text, option, 1, 3, "0.9,0.8,0.7");
    return c.size() < 3 ? grey(float(c[0])) : Color(float(c[0]), float(c[1]), float(c[2]));
}

inline void requireFileOutput(const std::string& path, const std::string& option) {
    if (path.empty() || path == "-") usageError(option, "a file name is needed");
}

inline void detail(const CommonOptions& options, const std::string& text) {
    if (options.verbose) std::fprintf(stderr, "raysweep: %s\n", text.c_str());
}

inline void writeReport(const CommonOptions& options, const nlohmann::json& report) {
    if (!options.reportFile.empty()) std::ofstream(options.reportFile) << report.dump(2) << "\n";
}

class TerminalProgress {
  public:
    explicit TerminalProgress(const CommonOptions&) {}
    ProgressCallback callback() { return {}; }
};

}  // namespace raysweep::apps
