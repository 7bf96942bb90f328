/// Options of the machine itself, which all subcommands share, and what a report says of it.
#pragma once

#include "cli.h"

#include "cube4/backprojector.h"
#include "cube4/counters.h"
#include "cube4/fixed_point.h"
#include "cube4/perspective.h"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>

namespace raysweep::apps {

/// What the user typed.
struct MachineArguments {
    CommonOptions common;
    int pipelines = 16;
    std::string format = "float", rounding = "nearest";
    bool noOverlap = false;
    double clock = 100;           ///< MHz
    cube4::RaySampling sampling;  ///< of rays from a point
    std::size_t maxVoxels = std::size_t(256) * 256 * 256;
    std::size_t trace = 0;
    std::string tracePicture;
};

void addMachineOptions(CLI::App& app, MachineArguments& arguments);

/// For subcommands with rays from a point.
void addPerspectiveOptions(CLI::App& app, MachineArguments& arguments);

/// Checks what can be checked before the work. @throw CLI::ValidationError
void requireMachine(const CLI::App& command, const MachineArguments& arguments);

/// None: floats. @throw CLI::ValidationError
std::optional<cube4::NumberFormat> parseFormat(const MachineArguments& arguments);

/// What the machine was, and what was counted.
struct MachineUse {
    cube4::Counters counters;
    std::size_t passes = 0, voxels = 0;  ///< of a pass
    std::size_t bytesPerModule = 0, bufferBytes = 0;
    double seconds = 0;  ///< that emulating took
};
nlohmann::ordered_json describeMachine(const MachineArguments& arguments, const MachineUse& use);

/// A line for people: cycles, cycles a voxel, time at the clock.
void printUse(const std::string& what, const MachineArguments& arguments, const MachineUse& use);

/// Prints the table of --trace and draws --trace-picture, if they were asked for. @throw IoError
void showTrace(const MachineArguments& arguments, const cube4::Trace& trace);

}  // namespace raysweep::apps
