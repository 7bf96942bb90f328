/// What is said of a run that was done again.
#pragma once

#include "machine_options.h"

#include "cube4/replay.h"
#include "cube4/replay_reconstruction.h"

#include <nlohmann/json_fwd.hpp>

namespace raysweep::apps {

/// How the machine is to do a recorded run. @param trace takes what --trace asks for
cube4::ReplaySetup replaySetup(const MachineArguments& arguments, cube4::Trace& trace);

MachineUse useOf(const cube4::ReplayResult& result, std::size_t voxels, double seconds);

nlohmann::ordered_json toJson(const cube4::Agreement& agreement);

/// What `illuminate --replay` and `check` report.
nlohmann::ordered_json describeReplay(const MachineArguments& arguments, const cube4::IlluminationRecord& record,
                                      const cube4::ReplayResult& result, double seconds);
nlohmann::ordered_json describeReplay(const MachineArguments& arguments, const cube4::ReconstructionReplay& result);

void printAgreement(const std::string& what, const cube4::Agreement& agreement);
void printReplay(const cube4::ReplayResult& result);
void printReplay(const cube4::ReconstructionReplay& result);

}  // namespace raysweep::apps
