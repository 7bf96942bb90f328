/// raysweep compare: how much two volumes or two images differ.
#include "cli.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/image/compare.h"
#include "raysweep/image/image_io.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/statistics.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>

namespace raysweep::apps {
namespace {

using json = nlohmann::ordered_json;

struct CompareOptions {
    CommonOptions common;
    std::string file, reference, grid;
    double maxRms = -1;  ///< negative: no limit
    bool json = false;
};

enum class FileKind { kVolume, kImage };

FileKind kindOf(const std::string& path) {
    return lowerExtension(path) == ".vdb" ? FileKind::kVolume : FileKind::kImage;
}

json compareVolumes(const CompareOptions& options) {
    const VdbFile a = readVdb(options.file), b = readVdb(options.reference);
    const auto gridA = selectGrid(a, options.grid), gridB = selectGrid(b, options.grid);
    const GridDifference d = compareGrids(*gridA, *gridB);
    json result = {{"grid", gridB->getName()},
                   {"voxels", d.voxels},
                   {"rmse", finiteOrNull(d.rmse)},
                   {"relative_rmse", finiteOrNull(d.relativeRmse)},
                   {"psnr", finiteOrNull(d.psnr)},
                   {"max", finiteOrNull(d.max)},
                   {"max_at", {d.maxAt.x(), d.maxAt.y(), d.maxAt.z()}}};
    // The voxels of the two do not coincide: those of the coarser one are interpolated.
    if (d.resampled == GridDifference::Resampled::grid)
        result["resampled"] = options.file + " onto the voxels of " + options.reference;
    if (d.resampled == GridDifference::Resampled::reference)
        result["resampled"] = options.reference + " onto the voxels of " + options.file;
    return result;
}

json compareImageFiles(const CompareOptions& options) {
    const Image picture = readImage(options.file);
    const PictureDifference difference = comparePictures(picture, readImage(options.reference));
    const ImageDifference& d = difference.color;
    json result = {{"rmse", finiteOrNull(d.rmse)},
                   {"relative_rmse", finiteOrNull(d.relativeRmse)},
                   {"psnr", finiteOrNull(d.psnr)},
                   {"ssim", finiteOrNull(d.ssim)},
                   {"max", finiteOrNull(d.maxDifference)}};
    if (!difference.alpha) return result;
    const double channels = picture.channels == 2 || picture.channels == 4 ? picture.channels : picture.channels + 1;
    result["rmse_all"] = finiteOrNull(
        std::sqrt(((channels - 1) * d.rmse * d.rmse + difference.alpha->rmse * difference.alpha->rmse) / channels));
    result["alpha_rmse"] = finiteOrNull(difference.alpha->rmse);
    result["alpha_max"] = finiteOrNull(difference.alpha->maxDifference);
    if (difference.alpha->rmse != 0)
        message(options.common, "alpha differs, by up to " + brief(difference.alpha->maxDifference, 3) +
                                    "; the other figures are of the colours alone");
    return result;
}

std::string toText(const json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (!value.is_number_float()) return value.dump();
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value.get<double>());
    return text;
}

void print(const json& result) {
    for (const auto& [key, value] : result.items()) {
        const bool equal = key == "psnr" && result["rmse"] == 0;
        std::cout << std::left << std::setw(15) << key
                  << (!value.is_null() ? toText(value)
                      : equal          ? "infinite"
                                       : "not finite")
                  << "\n";
    }
}

int runCompare(const CompareOptions& options) {
    const ThreadLimit limit = start(options.common);
    const FileKind kind = kindOf(options.file);
    if (kind != kindOf(options.reference)) usageError("compare", "both files must be volumes, or both images");
    const json result = kind == FileKind::kVolume ? compareVolumes(options) : compareImageFiles(options);
    if (options.json)
        std::cout << result.dump(2, ' ', false, json::error_handler_t::replace) << "\n";
    else
        print(result);
    writeReport(options.common, result);
    if (options.maxRms < 0) return kDone;
    const char* const judged = result.contains("rmse_all") ? "rmse_all" : "rmse";
    const bool within = result[judged].is_number() && result[judged].get<double>() <= options.maxRms;
    if (!within) message(options.common, std::string("the ") + judged + " is above --max-rms");
    return within ? kDone : kFailed;
}

}  // namespace

void addCompare(CLI::App& app, int& exitCode) {
    CLI::App* command =
        app.add_subcommand("compare", "Compare two .vdb files or two images: RMSE, PSNR, largest difference");
    const auto options = std::make_shared<CompareOptions>();
    reads(command->add_option("file", options->file, "What to judge"))->required()->type_name("A");
    reads(command->add_option("reference", options->reference, "What it should be"))->required()->type_name("B");
    command->add_option("--grid", options->grid,
                        "Grid to compare (default: density, else the only one of type float or vec3s); NAME[1] is the "
                        "second of that name");
    command
        ->add_option("--max-rms", options->maxRms, "Exit with 1 if the RMSE, of all channels together, is above this")
        ->check(CLI::NonNegativeNumber.description(""));
    command->add_flag("--json", options->json, "Print JSON");
    addCommonOptions(*command, options->common);
    command->callback([options, &exitCode] { exitCode = runCompare(*options); });
}

}  // namespace raysweep::apps
