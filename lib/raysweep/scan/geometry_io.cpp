#include "raysweep/scan/geometry_io.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/output_file.h"
#include "raysweep/scan/geometry_json.h"
#include "raysweep/scan/rtk_geometry.h"

#include <filesystem>
#include <fstream>
#include <sstream>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

[[noreturn]] void failRead(const std::string& path, const std::string& why) {
    throw IoError("cannot read '" + path + "': " + why);
}

std::string textOf(const std::string& path) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) failRead(path, "there is no such file");
    if (fs::is_directory(path, ignored)) failRead(path, "it is a folder; give a geometry file (.json, or RTK's .xml)");
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    if (!in) failRead(path, "reading failed, or it is empty");
    return text.str();
}

}  // namespace

ProjectionGeometry readGeometry(const std::string& path, int width, int height,
                                const std::optional<DetectorPair>& spacing, const std::optional<DetectorPair>& origin) {
    const std::string extension = lowerExtension(path);
    if (extension != ".json" && extension != ".xml")
        failRead(path, "the extension '" + extension + "' is not known for geometries; use .json, or .xml for RTK's");
    const std::string text = textOf(path);
    try {
        return extension == ".json" ? geometryFromJson(text) : geometryFromRtk(text, {width, height, spacing, origin});
    } catch (const InvalidArgument& error) {
        throw InvalidArgument("'" + path + "': " + error.what());
    } catch (const IoError& error) {
        failRead(path, error.what());
    }
}

void writeGeometry(const std::string& path, const ProjectionGeometry& geometry) {
    geometry.validate();
    if (lowerExtension(path) != ".json") throw IoError("cannot write '" + path + "': geometries are written as .json");
    OutputFile file(path);
    std::ofstream out(file.temporary(), std::ios::binary);
    out << jsonOf(geometry);
    out.close();
    if (!out) throw IoError("cannot write '" + path + "': writing failed; is the disk full?");
    file.commit();
}

}  // namespace raysweep
