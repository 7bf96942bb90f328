// How far one lit volume, or one picture, is from another: relative RMS of radiosity in blocks of voxels, weighted with
// density (single voxels keep the noise of the last few directions, and nobody looks at single voxels); of a picture's
// colours, pixel by pixel.
#include "raysweep/core/file_name.h"
#include "raysweep/image/image_io.h"
#include "raysweep/volume/vdb_io.h"

#include "support/blocks.h"
#include "support/volumes.h"

#include <CLI/CLI.hpp>

#include <cstdio>

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr int kBlock = 4;  ///< voxels along an edge, as in the tests

openvdb::FloatGrid::Ptr gridOf(const VdbFile& file, const std::string& name) {
    for (const auto& grid : file.grids)
        if (grid->getName() == name)
            if (const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) return floats;
    throw std::runtime_error("'" + file.path + "' has no float grid '" + name + "'");
}

double volumeError(const VdbFile& file, const VdbFile& reference) {
    const openvdb::FloatGrid& density = *gridOf(reference, "density");
    const DenseVolume weights = dense(density, density);
    const DenseVolume ours = dense(*gridOf(file, "radiosity"), density);
    const DenseVolume theirs = dense(*gridOf(reference, "radiosity"), density);
    return blockError(ours.values, theirs.values, weights.values, weights.size, kBlock);
}

/// Red, green and blue of all pixels.
std::vector<double> coloursOf(const Image& image) {
    std::vector<double> colours;
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        if (int(i % std::size_t(image.channels)) < 3) colours.push_back(double(image.pixels[i]));
    return colours;
}

double errorOf(const std::string& file, const std::string& reference) {
    if (lowerExtension(file) == ".vdb") return volumeError(readVdb(file), readVdb(reference));
    return relativeRms(coloursOf(readImage(file)), coloursOf(readImage(reference)));
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Relative RMS difference of two lit volumes' radiosity in blocks of voxels, or of two pictures");
    std::string file, reference;
    app.add_option("file", file, "What to judge: a .vdb written by raysweep light, grey, or an .exr")->required();
    app.add_option("reference", reference, "What it should be")->required();
    CLI11_PARSE(app, argc, argv);
    try {
        std::printf("%.6g\n", errorOf(file, reference));
    } catch (const std::exception& e) {
        std::fprintf(stderr, "raysweep_lit_error: %s\n", e.what());
        return 1;
    }
}
