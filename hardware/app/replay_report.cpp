#include "replay_report.h"

#include <nlohmann/json.hpp>

#include <iostream>

namespace raysweep::apps {
namespace {

std::string placeOf(const Index3& voxel) {
    return "(" + std::to_string(voxel.x) + "," + std::to_string(voxel.y) + "," + std::to_string(voxel.z) + ")";
}

MachineUse useOf(const cube4::ReconstructionReplay& result, const cube4::Counters& counters, double seconds) {
    return {counters, result.passes, result.voxels, result.bytesPerModule, result.bufferBytes, seconds};
}

}  // namespace

cube4::ReplaySetup replaySetup(const MachineArguments& a, cube4::Trace& trace) {
    trace.most = a.trace;
    cube4::ReplaySetup setup;
    setup.pipelines = a.pipelines;
    setup.overlap = !a.noOverlap;
    setup.sampling = a.sampling;
    setup.format = parseFormat(a);
    setup.trace = a.trace > 0 ? &trace : nullptr;
    return setup;
}

MachineUse useOf(const cube4::ReplayResult& result, std::size_t voxels, double seconds) {
    return {result.counters, result.passes, voxels, result.bytesPerModule, result.bufferBytes, seconds};
}

nlohmann::ordered_json toJson(const cube4::Agreement& agreement) {
    const Index3& at = agreement.worstAt;
    return {{"rms", agreement.rms},
            {"worst", agreement.worst},
            {"worst_at", {at.x, at.y, at.z}},
            {"voxels", agreement.voxels}};
}

nlohmann::ordered_json describeReplay(const MachineArguments& a, const cube4::IlluminationRecord& record,
                                      const cube4::ReplayResult& result, double seconds) {
    nlohmann::ordered_json json = describeMachine(a, useOf(result, record.box.voxels(), seconds));
    json["sweeps"] = result.sweeps;
    json["deposit"] = toJson(result.deposit);
    json["unshot"] = toJson(result.unshot);
    if (result.source.voxels > 0) json["direct_light"] = toJson(result.source);
    json["ray_power_difference"] = result.rayPower;
    json["balance"] = result.balance;
    json["start_share"] = result.startShare;
    json["settled_share"] = result.settledShare;
    json["direct_light_from_record"] = result.sourceFromRecord;
    if (a.format != "float") {
        json["rms_against_float"] = result.depositToFloat.rms;
        json["deposit_against_float"] = toJson(result.depositToFloat);
        json["unshot_against_float"] = toJson(result.unshotToFloat);
    }
    return json;
}

nlohmann::ordered_json describeReplay(const MachineArguments& a, const cube4::ReconstructionReplay& result) {
    cube4::Counters both = result.project;
    both += result.backproject;
    nlohmann::ordered_json json = describeMachine(a, useOf(result, both, result.seconds));
    json["project"] = describeMachine(a, useOf(result, result.project, 0));
    json["backproject"] = describeMachine(a, useOf(result, result.backproject, 0));
    json["updates"] = result.residuals.size();
    json["residuals"] = result.residuals;
    json["aligned_rays"] = result.alignedRays;
    json["volume"] = toJson(result.volume);
    if (a.format != "float") {
        json["rms_against_float"] = result.volumeToFloat.rms;
        json["volume_against_float"] = toJson(result.volumeToFloat);
    }
    return json;
}

void printAgreement(const std::string& what, const cube4::Agreement& agreement) {
    std::cout << what << ": RMS difference " << brief(agreement.rms, 3) << ", largest " << brief(agreement.worst, 3)
              << " at " << placeOf(agreement.worstAt) << "\n";
}

void printReplay(const cube4::ReplayResult& result) {
    printAgreement("deposit", result.deposit);
    printAgreement("unshot power", result.unshot);
    if (result.source.voxels > 0) printAgreement("direct light", result.source);
    std::cout << "rays: largest difference of a front's power " << brief(result.rayPower, 3) << "; balance "
              << brief(result.balance, 3) << "\n";
    if (result.depositToFloat.voxels > 0) printAgreement("deposit, to floats", result.depositToFloat);
    if (result.sourceFromRecord)
        std::cout << "taken from the record, not judged: direct light, as there are lights besides suns\n";
    if (result.startShare > 0)
        std::cout << "taken from the record, not judged: " << brief(100 * result.startShare)
                  << " % of the power, under way from a coarser level before the first sweep\n";
    if (result.settledShare > 0)
        std::cout << "taken from the record, not judged: " << brief(100 * result.settledShare)
                  << " % of the deposit, settled on a coarser level\n";
}

void printReplay(const cube4::ReconstructionReplay& result) {
    printAgreement("volume", result.volume);
    if (result.volumeToFloat.voxels > 0) printAgreement("volume, to floats", result.volumeToFloat);
    if (!result.alignedRays)
        std::cout << "the machine's rays are not the detector's: values were interpolated between the two\n";
}

}  // namespace raysweep::apps
