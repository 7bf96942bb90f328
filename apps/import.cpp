/// raysweep import: volumes of other programs become sparse grids.
#include "cli.h"
#include "hints.h"
#include "import_mesh.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"
#include "raysweep/formats/volume_import.h"
#include "raysweep/volume/vdb_io.h"
#include "raysweep/volume/voxel_check.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <map>
#include <memory>
#include <sstream>

namespace raysweep::apps {
namespace {

const std::map<std::string, Normalization> kNormalizations = {{"auto", Normalization::automatic},
                                                              {"data", Normalization::data},
                                                              {"none", Normalization::none},
                                                              {"type", Normalization::type}};

/// What the user typed; empty text: not given.
struct Arguments {
    CommonOptions common;
    ImportOptions options;
    std::vector<std::string> files;
    std::string output, dims, type, spacing, crop, normalize = "auto";
    bool bigEndian = false, half = false;
    MeshArguments mesh;
    bool isMesh = false;
    std::uint64_t skip = 0;
};

void addFileOptions(CLI::App& app, Arguments& a) {
    app.option_defaults()->group("Place and extent");
    app.add_option("--spacing", a.spacing, "World units from voxel to voxel (default: the file's, else 1)")
        ->type_name("X,Y,Z");
    app.add_option("--crop", a.crop, "Keep these voxels only, first to last")->type_name("I0,J0,K0,I1,J1,K1");
    app.option_defaults()->group("Files that hold several");
    app.add_option("--channel", a.options.channel,
                   "Number per voxel to import, where there are several (colours, vectors, dyes), from 0")
        ->type_name("N");
    app.add_option("--volume-index", a.options.volumeIndex,
                   "Volume to import, where there are several (instants, echoes, parts), from 0")
        ->type_name("N");
    app.option_defaults()->group("Files without a header (raw)");
    app.add_option("--dims", a.dims, "Samples along x (fastest in the file), y and z")->type_name("X,Y,Z");
    app.add_option("--type", a.type, "Type of the samples: " + sampleTypeNames())->type_name("TYPE");
    app.add_flag("--big-endian", a.bigEndian, "Samples have their high byte first");
    app.add_option("--skip", a.skip, "Bytes before the first sample (default: 0)")->type_name("BYTES");
    app.option_defaults()->group("DICOM");
    app.add_option("--series", a.options.series, "SeriesInstanceUID of the series to import, where there are several")
        ->type_name("UID");
}

void addOptions(CLI::App& app, Arguments& a) {
    app.add_option("files", a.files,
                   "NRRD, MetaImage (.mha, .mhd) or NIfTI file, raw samples, DICOM images, pictures (TIFF, PNG) as "
                   "slices, or a folder of DICOM images or pictures; or meshes (OBJ, PLY, STL)")
        ->required()
        ->type_name("FILES");
    app.add_option("-o,--output", a.output, "The .vdb file to write")->required()->type_name("OUT.vdb");
    app.option_defaults()->group("Values");
    app.add_option("--normalize", a.normalize,
                   "Map to [0,1] first: the type's range, the data's range, or none; auto: type for unsigned integers, "
                   "none for others, for what the file rescales, for DICOM, and with --scale or --offset")
        ->check(CLI::IsMember(kNormalizations).description(""))
        ->type_name("auto|type|data|none")
        ->capture_default_str();
    app.add_option("--scale", a.options.scale, "Voxel = value x scale + offset (default: 1)");
    app.add_option("--offset", a.options.offset, "Voxel = value x scale + offset (default: 0)");
    app.add_option("--background", a.options.background, "Value of empty space, after the mapping above")
        ->capture_default_str();
    app.add_option("--tolerance", a.options.tolerance, "Voxels this close to the background are empty space")
        ->capture_default_str()
        ->type_name("T");
    app.add_flag("--repair", a.options.repair, "Set voxels that are infinite or not a number to 0");
    addFileOptions(app, a);
    addMeshOptions(app, a.mesh);
    app.option_defaults()->group("Output");
    app.add_option("--name", a.options.name, "Name of the grid")->capture_default_str();
    app.add_flag("--half", a.half, "Save as half floats");
    reads(app.get_option("files"));
    writes(app.get_option("--output"));
    addCommonOptions(app, a.common);
}

RawLayout rawLayout(const Arguments& a) {
    RawLayout raw;
    const std::vector<int> dims = parseWhole(a.dims, "--dims", 3, {1, 1 << 20}, "256,256,128");
    raw.dims = Index3(dims[0], dims[1], dims[2]);
    const auto type = sampleTypeOf(a.type);
    if (!type) usageError("--type", "'" + a.type + "' is not known; give one of " + sampleTypeNames());
    raw.type = *type;
    raw.bigEndian = a.bigEndian;
    raw.skip = a.skip;
    return raw;
}

/// Everything that can be said to be wrong before a file is read.
void completeOptions(Arguments& a, const CLI::App& command) {
    requireFileOutput(a.output);
    a.isMesh = requireMeshOptions(a.files, a.mesh, command);
    a.mesh.options.name = a.options.name;
    if (!a.dims.empty() || !a.type.empty()) {
        if (a.dims.empty()) usageError("--type", "needs --dims X,Y,Z as well");
        if (a.type.empty()) usageError("--dims", "needs --type as well; for example --type uint8");
        a.options.raw = rawLayout(a);
    } else if (a.bigEndian || a.skip > 0) {
        usageError(a.bigEndian ? "--big-endian" : "--skip", "is for raw samples, which need --dims and --type");
    }
    if (!a.spacing.empty()) a.options.spacing = parseVec3(a.spacing, "--spacing");
    if (!a.crop.empty()) {
        const std::vector<int> c = parseWhole(a.crop, "--crop", 6, {0, 1 << 20}, "0,0,9,255,255,118");
        a.options.crop = IndexBox{Index3(c[0], c[1], c[2]), Index3(c[3], c[4], c[5])};
    }
    a.options.normalization = kNormalizations.at(a.normalize);
    if (a.options.name.empty()) usageError("--name", "must not be empty");
    requireValid(command, [&] { a.options.validate(); });
}

void comment(const Arguments& a, const ImportedVolume& volume, double activeVoxels) {
    // Cameras and scanners often fill 12 of 16 bits.
    const double top = volume.range.max * volume.scale + volume.offset;
    if (a.normalize == "auto" && volume.scale != 1 && top > 0 && top < 0.125 && !a.options.scale && !a.options.offset)
        warning(a.common, "the largest value is " + brief(top, 3) + " of what " + nameOf(volume.type) +
                              " can hold; --normalize data maps the values that occur to [0,1]");
    for (const std::string& note : volume.notes) warning(a.common, note);
    if (activeVoxels == 0) warning(a.common, "all voxels are background: the grid is empty");
    if (volume.range.notFinite > 0)
        warning(a.common, std::to_string(volume.range.notFinite) + " voxels that were no finite numbers were set to 0");
    detail(a.common, volume.format + " of " + nameOf(volume.type) + ", " + brief(volume.range.min, 3) + " to " +
                         brief(volume.range.max, 3) + ", became " + brief(activeVoxels, 3) + " active voxels");
}

nlohmann::ordered_json describe(const ImportedVolume& volume, double seconds) {
    const auto list = [](const auto& v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
    return {{"format", volume.format},
            {"dims", list(volume.dims)},
            {"spacing", list(volume.spacing)},
            {"origin", list(volume.origin)},
            {"unit", volume.unit},
            {"notes", volume.notes},
            {"type", nameOf(volume.type)},
            {"range", {volume.range.min, volume.range.max}},
            {"scale", volume.scale},
            {"offset", volume.offset},
            {"voxels_repaired", volume.range.notFinite},
            {"voxels_active", volume.grid->activeVoxelCount()},
            {"seconds", seconds}};
}

int run(const Arguments& a) {
    const ThreadLimit limit = start(a.common);
    requireWritable(a.output);
    if (a.isMesh) return importMeshes(a.files, a.mesh, a.output, a.half, a.common);
    const Timer timer;
    TerminalProgress progress(a.common);
    const ImportedVolume volume = importVolume(a.files, a.options, progress.callback());
    if (!volume.grid || TerminalProgress::interrupted()) {
        message(a.common, "stopped; nothing was written");
        return kInterrupted;
    }
    volume.grid->setSaveFloatAsHalf(a.half);
    if (const std::size_t clamped = clampForHalf(*volume.grid))
        warning(a.common, std::to_string(clamped) + " voxels are beyond half floats and were set to 65504 or -65504");
    volume.grid->insertMeta("raysweep_version", openvdb::StringMetadata(RAYSWEEP_VERSION));
    writeVdb(a.output, {volume.grid});
    comment(a, volume, double(volume.grid->activeVoxelCount()));
    writeReport(a.common, describe(volume, timer.seconds()));
    return kDone;
}

}  // namespace

void addImport(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("import",
                                           "Make a volume of an NRRD, MetaImage, NIfTI, DICOM or raw file, "
                                           "of pictures, or of meshes");
    const auto arguments = std::make_shared<Arguments>();
    addOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        completeOptions(*arguments, *command);
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
