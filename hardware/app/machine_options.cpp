#include "machine_options.h"

#include "hints.h"
#include "trace_picture.h"

#include "raysweep/core/output_file.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <iostream>

namespace raysweep::apps {
namespace {

constexpr int kMostPipelines = 1024;

/// Of those that a subcommand has; they are called the same in all.
void addFileRoles(CLI::App& app) {
    if (CLI::Option* const input = app.get_option_no_throw("input")) reads(input);
    if (CLI::Option* const replay = app.get_option_no_throw("--replay")) reads(replay, recordFiles);
    if (CLI::Option* const output = app.get_option_no_throw("--output")) writes(output);
    writes(app.get_option("--trace-picture"));
}

}  // namespace

void addMachineOptions(CLI::App& app, MachineArguments& a) {
    addCommonOptions(app, a.common);
    app.option_defaults()->group("Machine");
    app.add_option("--pipelines", a.pipelines, "Pipelines, and modules of voxel memory")
        ->capture_default_str()
        ->check(CLI::Range(1, kMostPipelines))
        ->type_name("P");
    app.add_option("--format", a.format,
                   "Numbers: float, or widths in bits: one for scalars and energies, or "
                   "SCALAR,ENERGY,PART,WEIGHT[,SUM] (part: opacities "
                   "and albedos; weight: of interpolation; sum: deposits and line integrals)")
        ->capture_default_str()
        ->type_name("float|BITS");
    app.add_option("--rounding", a.rounding, "Rounding of products: truncate, nearest or stochastic")
        ->capture_default_str()
        ->check(CLI::IsMember({"truncate", "nearest", "stochastic"}))
        ->type_name("HOW");
    app.add_flag("--no-overlap", a.noOverlap, "Voxels and rays share a port: read and written one after the other");
    app.add_option("--clock", a.clock, "Clock for the times that are printed, MHz")
        ->capture_default_str()
        ->check(CLI::Range(1e-3, 1e6))
        ->type_name("MHZ");
    app.add_option("--max-voxels", a.maxVoxels, "Largest volume, made dense, voxels")
        ->capture_default_str()
        ->check(CLI::Range(1.0, 1e12))
        ->type_name("N");
    app.add_option("--trace", a.trace, "Prints which partial beam is in which stage, for the first N cycles")
        ->type_name("N");
    app.add_option("--trace-picture", a.tracePicture, "The same as a picture, .svg (--trace says how many cycles)")
        ->type_name("FILE.svg");
    app.option_defaults()->group("Options");
    addFileRoles(app);
}

void addPerspectiveOptions(CLI::App& app, MachineArguments& a) {
    app.option_defaults()->group("Machine");
    app.add_option(
           "--least-spacing", a.sampling.leastSpacing,
           "Rays from a point are merged where they are closer than so many voxels, [0.01,1]; below 1 slices are "
           "passed several times")
        ->capture_default_str()
        ->type_name("X");
    app.add_option("--rays-per-pixel", a.sampling.raysPerPixel,
                   "Rays from a point: so many for each pixel along columns and rows, 1 to 64")
        ->capture_default_str()
        ->type_name("N");
    app.option_defaults()->group("Options");
}

std::optional<cube4::NumberFormat> parseFormat(const MachineArguments& a) {
    if (a.format == "float") return std::nullopt;
    constexpr int kMost = 5;
    constexpr double kMostBits = 64;
    std::vector<int> bits;
    for (const double value : parseNumbers(a.format, "--format", 1, kMost, "float, 16 or 16,16,12,12")) {
        if (value != std::floor(value) || std::abs(value) > kMostBits)
            usageError("--format", "widths are whole numbers of at most 64 bits");
        bits.push_back(int(value));
    }
    cube4::NumberFormat format;
    if (bits.size() == 1) {
        format.scalar = format.energy = bits[0];
    } else if (bits.size() < kMost - 1) {
        usageError("--format", "give one width, or SCALAR,ENERGY,PART,WEIGHT[,SUM]");
    } else {
        format.scalar = bits[0], format.energy = bits[1], format.part = bits[2], format.weight = bits[3];
        if (bits.size() == kMost) format.sum = bits[4];
    }
    format.rounding = a.rounding == "truncate"  ? cube4::Rounding::truncate
                      : a.rounding == "nearest" ? cube4::Rounding::nearest
                                                : cube4::Rounding::stochastic;
    format.seed = a.common.seed;
    return format;
}

void requireMachine(const CLI::App& command, const MachineArguments& a) {
    requireValid(command, [&] { a.sampling.validate(); });
    if (const auto format = parseFormat(a))
        requireValid(command, [&] {
            try {
                format->validate();
            } catch (const InvalidArgument& e) {
                throw about("format", e);
            }
        });
    if (a.tracePicture.empty()) return;
    requireFileOutput(a.tracePicture, "--trace-picture");
    if (std::filesystem::path(a.tracePicture).extension() != ".svg") usageError("--trace-picture", "is an .svg file");
    if (a.trace == 0) usageError("--trace-picture", "say with --trace how many cycles it is to show");
}

nlohmann::ordered_json describeMachine(const MachineArguments& a, const MachineUse& use) {
    const cube4::Counters& n = use.counters;
    const double voxelCycles = double(n.cycles) * a.pipelines;
    return {{"pipelines", a.pipelines},
            {"format", a.format},
            {"rounding", a.format == "float" ? "none" : a.rounding},
            {"passes", use.passes},
            {"cycles", n.cycles},
            {"cycles_per_voxel", double(n.cycles) / (double(use.passes) * double(use.voxels))},
            {"stalls", n.stalls},
            {"bank_conflicts", n.conflicts},
            {"saturations", n.saturations},
            {"partial_beams", n.beams},
            {"voxel_reads", n.voxelReads},
            {"voxel_writes", n.voxelWrites},
            {"ray_reads", n.rayReads},
            {"ray_writes", n.rayWrites},
            {"neighbour_words", n.wordsOn + n.wordsBack},
            {"neighbour_words_back", n.wordsBack},
            {"bound_cycles", n.boundCycles},
            {"bound_rays_peak", n.boundRays},
            {"meetings", n.meetings},
            {"queue_peak", n.queued},
            {"bytes_per_module", use.bytesPerModule},
            {"bytes", use.bytesPerModule * std::size_t(a.pipelines)},
            {"buffer_bytes_per_pipeline", use.bufferBytes},
            {"clock_mhz", a.clock},
            {"seconds_at_clock", double(n.cycles) / (a.clock * 1e6)},
            {"emulation_seconds", use.seconds},
            {"emulated_voxel_cycles_per_second", use.seconds > 0 ? voxelCycles / use.seconds : 0}};
}

void printUse(const std::string& what, const MachineArguments& a, const MachineUse& use) {
    const double perVoxel = double(use.counters.cycles) / (double(use.passes) * double(use.voxels));
    std::cout << what << ": " << use.passes << " passes, " << use.counters.cycles << " cycles, "
              << brief(perVoxel * a.pipelines, 4) << " per voxel and pipeline; " << use.counters.stalls << " stalls, "
              << use.counters.conflicts << " conflicts; " << brief(double(use.counters.cycles) / (a.clock * 1e6), 3)
              << " s at " << brief(a.clock, 4) << " MHz\n";
    if (use.counters.saturations > 0)
        std::cout << use.counters.saturations << " sums did not fit their words and became the largest that does\n";
}

void showTrace(const MachineArguments& a, const cube4::Trace& trace) {
    if (a.trace == 0) return;
    std::cout << traceTable(trace);
    if (!a.tracePicture.empty()) drawTrace(a.tracePicture, trace);
}

}  // namespace raysweep::apps
