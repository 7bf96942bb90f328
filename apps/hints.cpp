#include "hints.h"

#include <cctype>

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
    {Remedy::chooseMatting, "photo",
     ": give --matting black or white (a plain dark or bright backdrop; look at --threshold, too), known:R,G,B or "
     "masks:DIR"},
    {Remedy::chooseSeries, "import", " with --series UID"},
    {Remedy::describeSamples, "import", "; if it holds nothing but samples, give --dims X,Y,Z and --type"},
    {Remedy::fillLevelSet, "light", "use --from-level-set to fill its inside with density 1, or "},
    {Remedy::giveExtinction, "render", "; give --extinction"},
    {Remedy::giveExtinction, "shoot", "; give --extinction"},
    {Remedy::giveGrid, "ct", "; give --size and --spacing"},
    {Remedy::giveGrid, "photo", ": --size, --bounds"},
    {Remedy::giveSpacing, "import", "; if only the spacing is wrong, give --spacing X,Y,Z"},
    {Remedy::isNoLevelSet, "light", "; leave out --from-level-set"},
    {Remedy::isVolumeAlready, "import", "; 'raysweep light' takes it as it is"},
    {Remedy::keepVoxels, "render", "; light it without --upsample"},
    {Remedy::keepVoxels, "shoot", "; light it without --upsample"},
    {Remedy::leaveOutRays, "ct", "; use --repair to leave such rays out as not measured"},
    {Remedy::lightFirst, "render", ": run 'raysweep light FILE -o LIT.vdb' first and render LIT.vdb"},
    {Remedy::lightFirst, "shoot", ": run 'raysweep light FILE -o LIT.vdb' first and photograph LIT.vdb"},
    {Remedy::mapValues, "generate", "; import it with --normalize, or --scale and --offset"},
    {Remedy::repairVoxels, "import", kRepair},
    {Remedy::repairVoxels, "light", kRepair},
    {Remedy::spaceSlicesByNumber, "import", "; give --spacing X,Y,Z to take the images in the order of their numbers"},
    {Remedy::spaceSlicesEvenly, "import", " --spacing X,Y,Z takes them as equally spaced"},
    {Remedy::useOpenCvAxes, "photo", ": give --axes opencv"},
    {Remedy::useOpenGlAxes, "photo", ": give --axes opengl"},
    {Remedy::useOriginal, "export", kExported},
    {Remedy::useOriginal, "light", kExported},
    {Remedy::useOriginal, "render", kExported},
    {Remedy::useOriginal, "shoot", kExported},
    {Remedy::useOriginal, "slices", kExported},
};

std::string filledIn(std::string text, const std::string& file) {
    const std::size_t at = text.find("FILE");
    return at == std::string::npos ? text : text.replace(at, 4, file);
}

/// "emissionScale" is typed as "--emission-scale".
std::string optionFor(const std::string& field) {
    std::string option = "--";
    for (const char c : field) {
        if (std::isupper(static_cast<unsigned char>(c))) option += '-';
        option += char(std::tolower(static_cast<unsigned char>(c)));
    }
    return option;
}

/// The option of `command` that a field is typed as, "" if there is none.
std::string typedAs(const CLI::App& command, const std::string& field) {
    const std::string option = field.empty() ? "" : optionFor(field);
    return !option.empty() && command.get_option_no_throw(option) ? option : "";
}

/// `text` with the fields of the library's options called as typed: `field`, where it begins with that, and all that
/// are between backticks.
std::string asTyped(const CLI::App& command, std::string text, const std::string& field) {
    for (std::size_t open = text.find('`'); open != std::string::npos; open = text.find('`', open + 1)) {
        const std::size_t close = text.find('`', open + 1);
        if (close == std::string::npos) break;
        const std::string option = typedAs(command, text.substr(open + 1, close - open - 1));
        if (!option.empty()) text.replace(open, close + 1 - open, option);
    }
    const std::string option = text.rfind(field, 0) == 0 ? typedAs(command, field) : "";
    return option.empty() ? text : text.replace(0, field.size(), option);
}

}  // namespace

std::string inWordsOf(const CLI::App& command, const Error& error) {
    std::string text = error.what();
    for (const Hint& hint : kHints)
        if (hint.remedy == error.remedy && hint.command == command.get_name())
            text.insert(error.remedyAt, filledIn(hint.text, error.subject));
    return asTyped(command, text, error.subject);
}

void requireValid(const CLI::App& command, const std::function<void()>& validate) {
    try {
        validate();
    } catch (const InvalidArgument& e) {
        const std::string text = e.what();
        const std::string field = text.substr(0, text.find_first_of(" :["));  // messages begin with it
        throw CLI::ValidationError(asTyped(command, text, field));
    }
}

}  // namespace raysweep::apps
