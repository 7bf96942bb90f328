#include "hints.h"

namespace raysweep::apps {
namespace {

struct Hint {
    Remedy remedy;
    const char *command, *text;
};

constexpr Hint kHints[] = {
    {Remedy::chooseSeries, "import", " with --series UID"},
    {Remedy::describeSamples, "import", "; if it holds nothing but samples, give --dims X,Y,Z and --type"},
    {Remedy::fillLevelSet, "light", "use --from-level-set to fill its inside with density 1, or "},
    {Remedy::isNoLevelSet, "light", "; leave out --from-level-set"},
    {Remedy::isVolumeAlready, "import", "; 'raysweep light' takes it as it is"},
    {Remedy::leaveOutRays, "ct", "; use --repair to leave such rays out as not measured"},
    {Remedy::mapValues, "generate", "; import it with --normalize, or --scale and --offset"},
    {Remedy::repairVoxels, "import", ", or use --repair to set such voxels to 0"},
    {Remedy::repairVoxels, "light", ", or use --repair to set such voxels to 0"},
    {Remedy::setSpacing, "import", "; if only the spacing is wrong, give --spacing X,Y,Z"},
    {Remedy::spaceSlicesByNumber, "import", "; give --spacing X,Y,Z to take the images in the order of their numbers"},
    {Remedy::spaceSlicesEvenly, "import", " --spacing X,Y,Z takes them as equally spaced"},
};

}  // namespace

std::string withHint(const Error& error, const std::string& command) {
    std::string text = error.what();
    for (const Hint& hint : kHints)
        if (hint.remedy == error.remedy && hint.command == command) return text.insert(error.remedyAt, hint.text);
    return text;
}

}  // namespace raysweep::apps
