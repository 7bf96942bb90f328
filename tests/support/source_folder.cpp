// The one unit that knows paths, so that compile caches serve every checkout.
#include "support/source_folder.h"

namespace raysweep::test {

std::string sourceFolder() {
    return RAYSWEEP_SOURCE_DIR;
}

std::string buildFolder() {
    return RAYSWEEP_BINARY_DIR;
}

}  // namespace raysweep::test
