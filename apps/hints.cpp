#include "hints.h"

namespace raysweep::apps {
namespace {

constexpr const char* kRepair = ", or use --repair to set such voxels to 0";
constexpr const char* kExported = " was written by raysweep export";

struct Hint {
    Remedy remedy;
    const char *command, *text;
};

/// By remedy and command; FILE is what the error is about.
constexpr Hint kHints[] = {
    {Remedy::chooseSeries, "import", " with --series UID"},
    {Remedy::describeSamples, "import", "; if it holds nothing but samples, give --dims X,Y,Z and --type"},
    {Remedy::fillLevelSet, "light", "use --from-level-set to fill its inside with density 1, or "},
    {Remedy::giveExtinction, "render", "; give --extinction"},
    {Remedy::isNoLevelSet, "light", "; leave out --from-level-set"},
    {Remedy::isVolumeAlready, "import", "; 'raysweep light' takes it as it is"},
    {Remedy::keepVoxels, "render", "; light it without --upsample"},
    {Remedy::leaveOutRays, "ct", "; use --repair to leave such rays out as not measured"},
    {Remedy::lightFirst, "render", ": run 'raysweep light FILE -o LIT.vdb' first and render LIT.vdb"},
    {Remedy::mapValues, "generate", "; import it with --normalize, or --scale and --offset"},
    {Remedy::repairVoxels, "import", kRepair},
    {Remedy::repairVoxels, "light", kRepair},
    {Remedy::setSpacing, "ct", "; give --size and --spacing"},
    {Remedy::setSpacing, "import", "; if only the spacing is wrong, give --spacing X,Y,Z"},
    {Remedy::spaceSlicesByNumber, "import", "; give --spacing X,Y,Z to take the images in the order of their numbers"},
    {Remedy::spaceSlicesEvenly, "import", " --spacing X,Y,Z takes them as equally spaced"},
    {Remedy::useOriginal, "export", kExported},
    {Remedy::useOriginal, "light", kExported},
    {Remedy::useOriginal, "render", kExported},
};

std::string filledIn(std::string text, const std::string& file) {
    const std::size_t at = text.find("FILE");
    return at == std::string::npos ? text : text.replace(at, 4, file);
}

}  // namespace

std::string inWordsOf(const CLI::App& command, const Error& error) {
    std::string text = error.what();
    for (const Hint& hint : kHints)
        if (hint.remedy == error.remedy && hint.command == command.get_name())
            text.insert(error.remedyAt, filledIn(hint.text, error.subject));
    const std::string option = "--" + error.subject;
    const bool isField = !error.subject.empty() && command.get_option_no_throw(option);
    return isField && text.rfind(error.subject + ": ", 0) == 0 ? "--" + text : text;
}

}  // namespace raysweep::apps
