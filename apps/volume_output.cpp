#include "volume_output.h"

#include "cli.h"

#include "raysweep/core/file_name.h"
#include "raysweep/formats/dense_files.h"

namespace raysweep::apps {

bool isVdb(const std::string& path) {
    return lowerExtension(path) == ".vdb";
}

void requireVolumeOutput(const std::string& path) {
    requireFileOutput(path);
    if (!isVdb(path) && denseFormat(path) == DenseFormat::unknown)
        usageError("--output", "'" + path + "' must end in .vdb, " + kDenseEndings);
}

}  // namespace raysweep::apps
