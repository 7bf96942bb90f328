#include "sky_options.h"

#include "raysweep/core/file_name.h"

#include <cctype>
#include <cmath>
#include <filesystem>

namespace raysweep::apps {
namespace {

/// A radiance is made of nothing but these.
bool looksLikeNumbers(const std::string& text) {
    return text.find_first_not_of("0123456789+-.eE,: ") == std::string::npos &&
           text.find_first_of("0123456789") != std::string::npos;
}

bool looksLikePicture(const std::string& text) {
    const std::string extension = lowerExtension(text);
    for (const char* known : {".exr", ".hdr", ".png", ".jpg", ".jpeg", ".tif", ".tiff"})
        if (extension == known) return true;
    std::error_code ignored;
    return std::filesystem::exists(text, ignored);
}

SkyMapOptions mappingFrom(const SkyArguments& a) {
    SkyMapOptions options;
    options.up = a.up[0] - 'x';
    options.rotate = a.rotate;
    options.scale = a.scale;
    options.suns = a.suns;
    return options;
}

}  // namespace

void addSkyOptions(CLI::App& app, SkyArguments& a) {
    reads(app.add_option("--sky", a.sky,
                         "Light from all around: its radiance, one number or R,G,B, or a lat-long picture of it, as in "
                         "Blender's Environment Texture"))
        ->type_name("L|FILE.exr|.hdr");
    app.add_option("--sky-scale", a.scale, "Factor on --sky")->capture_default_str();
    app.add_option("--sky-up", a.up, "Axis that is up in the picture")
        ->check(CLI::IsMember({"x", "y", "z"}).description(""))
        ->type_name("x|y|z")
        ->capture_default_str();
    app.add_option("--sky-rotate", a.rotate,
                   "Turn the picture's sky about that axis, counter-clockwise seen from above, degrees")
        ->type_name("DEG")
        ->capture_default_str();
    app.add_option("--sky-suns", a.suns,
                   "Most suns that stand for small bright parts of the picture, which sweeps could miss; 0: none")
        ->check(CLI::Range(0, kMostSkySuns).description(""))
        ->type_name("N")
        ->capture_default_str();
}

SkyOptions parseSky(const SkyArguments& a) {
    requireFactor(a.scale, "--sky-scale");
    if (!std::isfinite(a.rotate)) usageError("--sky-rotate", "must be a finite number of degrees");
    SkyOptions sky;
    if (a.sky.empty()) return sky;
    sky.mapping = mappingFrom(a);
    if (looksLikeNumbers(a.sky))
        sky.radiance = parseColor(a.sky, "--sky") * float(a.scale);
    else if (looksLikePicture(a.sky))
        sky.map = a.sky;
    else
        usageError("--sky", "'" + a.sky +
                                "' is neither a radiance (a number or R,G,B, as in 0.3 or 0.5,0.7,1) nor a lat-long "
                                "picture (a file, as in sky.exr or sky.hdr)");
    return sky;
}

}  // namespace raysweep::apps
