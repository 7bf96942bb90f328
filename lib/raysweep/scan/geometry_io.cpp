#include "raysweep/scan/geometry_io.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/text_file.h"
#include "raysweep/scan/geometry_json.h"
#include "raysweep/scan/rtk_geometry.h"

namespace raysweep {

ProjectionGeometry readGeometry(const std::string& path, int width, int height,
                                const std::optional<DetectorPair>& spacing, const std::optional<DetectorPair>& origin) {
    const std::string extension = lowerExtension(path);
    if (extension != ".json" && extension != ".xml")
        throw IoError("cannot read '" + path + "': the extension '" + extension +
                      "' is not known for geometries; use .json, or .xml for RTK's");
    try {
        const std::string text = bytesOfFile(path, "a geometry file (.json, or RTK's .xml)");
        return extension == ".json" ? geometryFromJson(text) : geometryFromRtk(text, {width, height, spacing, origin});
    } catch (const InvalidArgument& error) {
        throw InvalidArgument("'" + path + "': " + error.what());
    } catch (const IoError& error) {
        throw IoError("cannot read '" + path + "': " + error.what());
    }
}

void writeGeometry(const std::string& path, const ProjectionGeometry& geometry) {
    geometry.validate();
    if (lowerExtension(path) != ".json") throw IoError("cannot write '" + path + "': geometries are written as .json");
    writeText(path, jsonOf(geometry));
}

}  // namespace raysweep
