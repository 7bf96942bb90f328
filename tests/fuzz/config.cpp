/// Files of --config, and numbers of options.
#include "cli.h"
#include "fuzzed_file.h"

#include <string>

using namespace raysweep;

namespace {

struct Options {
    double number = 0;
    int whole = 0;
    std::vector<std::string> suns;
    std::string text;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    CLI::App app("", "fuzz");
    apps::readConfigFiles(app);
    CLI::App* const command = app.add_subcommand("light", "");
    Options options;
    command->add_option("--zeta", options.number, "");
    command->add_option("--sweeps", options.whole, "");
    command->add_option("--sun", options.suns, "")->allow_extra_args(false);
    command->add_option("--albedo", options.text, "");
    try {
        app.parse("--config " + file.path() + " light");
        if (!options.text.empty()) apps::parseColor(options.text, "--albedo");
    } catch (const CLI::Error&) {
    }
    return 0;
}
