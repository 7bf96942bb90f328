/// raysweep bake: radiosity of a lit volume on a mesh.
#include "cli.h"
#include "hints.h"
#include "render_source.h"

#include "raysweep/core/file_name.h"
#include "raysweep/core/output_file.h"
#include "raysweep/image/image_io.h"
#include "raysweep/mesh/mesh_files.h"
#include "raysweep/render/bake.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <memory>

namespace raysweep::apps {
namespace {

struct Arguments {
    CommonOptions common;
    RenderSource source;
    BakeOptions options;
    std::string mesh, output;
};

/// Beside the mesh, under its name.
std::string atlasFile(const Arguments& a) {
    return std::filesystem::path(a.output).replace_extension(".exr").string();
}

void comment(const Arguments& a, const BakeCounts& counts, const std::string& what) {
    const auto share = [&](std::size_t n) { return std::to_string(n) + " of " + std::to_string(counts.places) + what; };
    if (counts.missed > 0)
        warning(a.common, share(counts.missed) +
                              " lie where the volume has next to nothing, and are black: mesh and "
                              "volume must be in the same place");
    if (counts.turned > 0)
        message(a.common, share(counts.turned) + " have the volume before them, not behind: seen from the other side");
}

nlohmann::ordered_json describe(const BakeCounts& counts) {
    return {{"places", counts.places}, {"turned", counts.turned}, {"missed", counts.missed}};
}

int run(const Arguments& a) {
    const ThreadLimit limit = start(a.common);
    requireWritable(a.output);
    const bool withAtlas = a.options.atlas > 0;
    if (withAtlas) requireWritable(atlasFile(a));
    const Timer timer;
    TerminalProgress progress(a.common);
    const TriangleMesh mesh = readMesh(a.mesh);
    const BakedMesh baked = bakeRadiosity(renderInput(a.source), mesh, a.options, progress.callback());
    if (!baked.complete) {
        message(a.common, "stopped; nothing was written");
        return kInterrupted;
    }
    if (withAtlas) writeImage(atlasFile(a), baked.atlas);
    writePly(a.output, baked.mesh);
    comment(a, baked.corners, " corners of the mesh");
    nlohmann::ordered_json report = {{"corners", describe(baked.corners)}};
    if (withAtlas) {
        comment(a, baked.texels, " texels of the atlas");
        report["texels"] = describe(baked.texels);
    }
    report["seconds"] = timer.seconds();
    writeReport(a.common, report);
    return kDone;
}

}  // namespace

void addBake(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("bake", "Put the radiosity of a lit volume onto a mesh, as colours");
    const auto a = std::make_shared<Arguments>();
    command->add_option("input", a->source.input, "Lit volume, a .vdb written by raysweep light")
        ->required()
        ->type_name("LIT.vdb");
    command->add_option("mesh", a->mesh, "OBJ, PLY or STL in the same place, such as the volume was imported from")
        ->required()
        ->type_name("MESH");
    command
        ->add_option(
            "-o,--output", a->output,
            "The mesh with radiosity as colours of its corners, linear floats, one for each of red, green and blue")
        ->required()
        ->type_name("OUT.ply");
    command
        ->add_option("--atlas", a->options.atlas,
                     "Also write OUT.exr, a picture of N x N pixels of the radiosity, for the texture coordinates that "
                     "the mesh has")
        ->type_name("N");
    addRenderSource(*command, a->source);
    addCommonOptions(*command, a->common);
    command->callback([a, command, &exitCode] {
        requireFileOutput(a->output);
        if (lowerExtension(a->output) != ".ply") usageError("--output", "'" + a->output + "': give a name with .ply");
        requireValid(*command, [&] { a->options.validate(); });
        requireRenderSource(a->source, *command);
        exitCode = run(*a);
    });
}

}  // namespace raysweep::apps
