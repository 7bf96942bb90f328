#include "dense_options.h"

#include "raysweep/volume/cycles_export.h"
#include "raysweep/volume/grid_select.h"

namespace raysweep::apps {

void addDenseOptions(CLI::App& app, DenseArguments& a) {
    app.option_defaults()->group("What of the volume");
    app.add_option("--grid", a.grid, "Grid to take (default: density, else the only one)")->type_name("NAME");
    app.add_option("--channel", a.channel, "Which of several numbers per voxel (vectors, colours), from 0")
        ->type_name("N");
    app.add_option("--dense-box", a.denseBox,
                   "These voxels, first to last, whether active or not (default: the box around the active ones)")
        ->type_name("I0,J0,K0,I1,J1,K1");
    app.option_defaults()->group("Options");
}

DenseChoice denseChoice(const DenseArguments& a) {
    DenseChoice choice;
    choice.channel = a.channel;
    if (a.denseBox.empty()) return choice;
    const std::vector<int> b =
        parseWhole(a.denseBox, "--dense-box", 6, {-kFarthestVoxel, kFarthestVoxel}, "0,0,0,255,255,118");
    choice.denseBox = IndexBox{Index3(b[0], b[1], b[2]), Index3(b[3], b[4], b[5])};
    return choice;
}

DenseSource denseSource(const std::string& path, const DenseArguments& a) {
    const VdbFile file = readVdb(path);
    requireOriginal(file);
    return DenseSource(selectValues(file, a.grid), denseChoice(a));
}

}  // namespace raysweep::apps
