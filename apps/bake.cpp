/// raysweep bake: radiosity of a lit volume on a mesh.
#include "cli.h"
#include "file_roles.h"
#include "hints.h"
#include "render_source.h"

#include "raysweep/core/file_name.h"
#include "raysweep/core/output_file.h"
#include "raysweep/image/image_io.h"
#include "raysweep/mesh/mesh_files.h"
#include "raysweep/render/bake.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

namespace raysweep::apps {
namespace {

struct Arguments {
    CommonOptions common;
    RenderSource source;
    BakeOptions options;
    std::string mesh, output, encoding = "srgb";
    std::optional<double> exposure;
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

/// As `render` exposes pictures for displays.
TriangleMesh exposed(const Arguments& a, TriangleMesh mesh) {
    std::size_t clipped = 0;
    for (Color& color : mesh.colors) {
        color *= float(std::exp2(a.exposure.value_or(0)));
        clipped += maxComponent(color) > 1;
    }
    if (clipped > 0)
        message(a.common, std::to_string(clipped) +
                              " corners are brighter than a display's white and were clipped; "
                              "--exposure darkens, --colors linear keeps all");
    return mesh;
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
    if (a.encoding == "linear")
        writePly(a.output, baked.mesh, ColorEncoding::linear);
    else
        writePly(a.output, exposed(a, baked.mesh), ColorEncoding::srgb);
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
    command->add_option("-o,--output", a->output, "The mesh with radiosity as colours of its corners")
        ->required()
        ->type_name("OUT.ply");
    command
        ->add_option("--atlas", a->options.atlas,
                     "Also write OUT.exr, a picture of N x N pixels of the radiosity, for the texture coordinates that "
                     "the mesh has")
        ->type_name("N");
    command
        ->add_option(
            "--colors", a->encoding,
            "Of the corners: bytes, as programs expect that show meshes; or linear floats, all of the radiosity")
        ->check(CLI::IsMember({"srgb", "linear"}).description(""))
        ->type_name("srgb|linear")
        ->capture_default_str();
    command->add_option("--exposure", a->exposure, "Of srgb colours, in stops (default: 0)")->type_name("EV");
    addRenderSource(*command, a->source);
    addCommonOptions(*command, a->common);
    reads(command->get_option("input"));
    reads(command->get_option("mesh"));
    writes(command->get_option("--output"), [a](const std::string& output) {
        return a->options.atlas > 0 ? std::vector<std::string>{output, atlasFile(*a)}
                                    : std::vector<std::string>{output};
    });
    command->callback([a, command, &exitCode] {
        requireFileOutput(a->output);
        if (lowerExtension(a->output) != ".ply") usageError("--output", "'" + a->output + "': give a name with .ply");
        if (a->exposure && a->encoding == "linear") usageError("--exposure", "is for --colors srgb");
        requireValid(*command, [&] { a->options.validate(); });
        requireRenderSource(a->source, *command);
        exitCode = run(*a);
    });
}

}  // namespace raysweep::apps
