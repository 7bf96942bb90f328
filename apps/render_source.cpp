#include "render_source.h"

#include "cli.h"
#include "hints.h"

namespace raysweep::apps {
namespace {

LitVolumeOptions withoutTransfer(const RenderSource& a) {
    LitVolumeOptions options{a.density, a.extinction, {}, {}};
    if (!a.unshot.empty()) options.unshot = parseColor(a.unshot, "--unshot");
    return options;
}

}  // namespace

void addRenderSource(CLI::App& app, RenderSource& a) {
    app.option_defaults()->group("Volume");
    app.add_option("--density", a.density, "Density grid, rendered as fog (default: what was lit, as it was lit)")
        ->type_name("NAME");
    auto* const extinction = app.add_option(
        "--extinction", a.extinction, "Extinction per unit density, 1/world unit (default: as it was lit, else 1)");
    addTransferOptions(app, a.transfer, extinction);
    app.add_option("--unshot", a.unshot, "Show power that is still unshot, too, as light of this colour")
        ->type_name("R,G,B");
}

void requireRenderSource(const RenderSource& a, const CLI::App& command) {
    requireValid(command, [&] { withoutTransfer(a).validate(); });
    parseRamp(a.transfer);
}

RenderInput renderInput(const RenderSource& a) {
    const VdbFile file = readVdb(a.input);
    LitVolumeOptions options = withoutTransfer(a);
    if (const auto transfer = readTransfer(a.transfer)) options.transfer = transfer->function;
    return litVolume(file, options);
}

}  // namespace raysweep::apps
