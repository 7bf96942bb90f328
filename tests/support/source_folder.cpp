// The one unit that knows a path, so that compile caches serve every checkout.
#include "support/source_folder.h"

namespace raysweep::test {

std::string sourceFolder() {
    return RAYSWEEP_SOURCE_DIR;
}

}  // namespace raysweep::test
