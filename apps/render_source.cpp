#include "render_source.h"

#include "cli.h"

namespace raysweep::apps {
void addRenderSource(CLI::App& app, RenderSource& a) {
    app.option_defaults()->group("Volume");
    app.add_option("--density", a.density, "Density grid (default: the one that was lit)")->type_name("NAME");
    auto* const extinction = app.add_option(
        "--extinction", a.extinction, "Extinction per unit density, 1/world unit (default: as it was lit, else 1)");
    addTransferOptions(app, a.transfer, extinction);
    app.add_option("--unshot", a.unshot, "Show power that is still unshot, too, as light of this colour")
        ->type_name("R,G,B");
}

void requireRenderSource(const RenderSource& a) {
    if (a.extinction) requireFactor(*a.extinction, "--extinction");
    if (!a.unshot.empty()) parseColor(a.unshot, "--unshot");
    parseRamp(a.transfer);
}

RenderInput renderInput(const RenderSource& a) {
    const VdbFile file = readVdb(a.input);
    LitVolumeOptions options{a.density, a.extinction, {}, {}};
    if (const auto transfer = readTransfer(a.transfer)) options.transfer = transfer->function;
    if (!a.unshot.empty()) options.unshot = parseColor(a.unshot, "--unshot");
    return litVolume(file, options);
}

}  // namespace raysweep::apps
