#include "cube4/replay.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/checksum.h"

#include <algorithm>
#include <cmath>

namespace raysweep::cube4 {
namespace {

IlluminationSetup setupFor(const IlluminationRecord& record, const ReplaySetup& setup) {
    IlluminationSetup machine;
    machine.pipelines = setup.pipelines;
    machine.overlap = setup.overlap;
    machine.resampling = record.resampling;
    machine.rule = record.rule;
    machine.zeta = record.zeta;
    machine.mostShot = record.mostShot;
    return machine;
}

std::vector<SweepFront> frontsOf(const RecordedGroup& group, int channel) {
    std::vector<SweepFront> fronts;
    for (const RecordedBeam& beam : group.beams)
        fronts.push_back({beam.direction, beam.offsetU, beam.offsetV, beam.entering[std::size_t(channel)]});
    return fronts;
}

double relative(double ours, double theirs) {
    const double scale = std::max(std::abs(ours), std::abs(theirs));
    return scale > 0 ? std::abs(ours - theirs) / scale : 0;
}

/// Power that rays brought in and out over the whole run.
struct RunPower {
    double entered = 0, escaped = 0, injected = 0;
    double worst = 0;  ///< see ReplayResult::rayPower
};

/// All groups of one wavelength. @return false if it was stopped
bool runGroups(const IlluminationRecord& record, int channel, double sourcePower, Illumination& machine,
               const ReplaySetup& setup, const ProgressCallback& progress, RunPower& power) {
    for (std::size_t g = 0; g < record.groups.size(); ++g) {
        const double done = (channel + double(g) / double(record.groups.size())) / record.channels;
        if (!report(progress, "replaying", done)) return false;
        const RecordedGroup& group = record.groups[g];
        const std::vector<FrontPower> fronts = machine.sweep(frontsOf(group, channel), group.inject, setup.trace);
        for (std::size_t i = 0; i < fronts.size(); ++i) {
            const double entered = group.beams[i].entered[std::size_t(channel)],
                         escaped = group.beams[i].escaped[std::size_t(channel)];
            for (const double off : {relative(fronts[i].entered, entered), relative(fronts[i].escaped, escaped)})
                if (!(off <= power.worst)) power.worst = off;  // so that NaN stays
            power.entered += fronts[i].entered;
            power.escaped += fronts[i].escaped;
            power.injected += group.inject ? sourcePower : 0;
        }
    }
    return true;
}

/// Differences, voxel by voxel.
class Comparison {
  public:
    void add(const Index3& voxel, double ours, double theirs) {
        const double off = std::abs(ours - theirs);
        ++agreement_.voxels;
        sum_ += theirs * theirs;
        difference_ += off * off;
        largest_ = std::max(largest_, std::abs(theirs));
        if (off <= agreement_.worst) return;  // not so for NaN
        agreement_.worst = off;
        agreement_.worstAt = voxel;
    }
    Agreement result() const {
        Agreement agreement = agreement_;
        agreement.rms = std::sqrt(sum_ > 0 ? difference_ / sum_ : difference_);
        if (largest_ > 0) agreement.worst /= largest_;
        return agreement;
    }

  private:
    Agreement agreement_;
    double sum_ = 0, difference_ = 0, largest_ = 0;
};

/// What of all power is not accounted for by what the machine holds, of all.
double balanceOf(const DenseMedium& medium, ExchangeRule rule, const Illumination& machine, const RunPower& power) {
    const DenseField gain = effectiveAlbedo(medium, rule), deposit = machine.deposit();
    double absorbed = 0;
    for (std::size_t i = 0; i < deposit.size(); ++i) absorbed += (1 - double(gain[i])) * double(deposit[i]);
    const double in = power.entered + power.injected + sumOf(medium.unshot);
    return in > 0 ? (in - absorbed - power.escaped - sumOf(machine.unshot())) / in : 0;
}

/// Direct light of the suns, found by the machine, against the source that was recorded.
Agreement compareSource(const IlluminationRecord& record, const DenseMedium& medium, const ReplaySetup& setup,
                        int channel) {
    const auto theirs = fieldOf(record.file, "source", true);
    if (record.otherSources || record.suns.empty() || !theirs) return {};
    const DenseField gain = effectiveAlbedo(medium, record.rule);
    DenseField ours(medium.extinction.size(), 0.0f);
    for (const RecordedSun& sun : record.suns) {
        FrontPower power;
        const DenseField deposit = directDeposit(medium, setupFor(record, setup), sun.direction, power);
        const double scale =
            sun.irradiance[std::size_t(channel)] * crossSection(record.box, sun.direction) / record.powerUnit;
        for (std::size_t i = 0; i < ours.size(); ++i) ours[i] += gain[i] * float(double(deposit[i]) * scale);
    }
    return compareFields(ours, *theirs, record.box, channel);
}

void take(const Illumination& machine, ReplayResult& result) {
    result.counters += machine.counters();
    result.passes += machine.passes();
    result.bytesPerModule = std::max(result.bytesPerModule, machine.bytesPerModule());
    result.bufferBytes = std::max(result.bufferBytes, machine.bufferBytes());
}

/// The answer: what was deposited in the machine, and what was settled elsewhere.
DenseField answerOf(const IlluminationRecord& record, const DenseMedium& medium, const DenseField& deposit, int channel,
                    double& settledShare) {
    DenseField all = deposit;
    if (const auto settled = fieldOf(record.file, "settled", true)) {
        const DenseField more = denseField(*settled, record.box, channel);
        double moved = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            all[i] += more[i];
            moved += std::abs(double(more[i]));
        }
        if (const double sum = sumOf(all); sum > 0) settledShare = std::max(settledShare, moved / sum);
    }
    const auto scattered = fieldOf(record.file, "source_scattered", true);
    if (!scattered) return radiosity(medium, setupFor(record, {}), all, std::max(1, record.injections));
    DenseMedium shown = medium;  // what a fire emits shines by itself
    shown.source = denseField(*scattered, record.box, channel);
    return radiosity(shown, setupFor(record, {}), all, std::max(1, record.injections));
}

}  // namespace

Agreement compareFields(const DenseField& ours, const openvdb::GridBase& theirs, const DenseBox& box, int channel) {
    return compareFields(ours, denseField(theirs, box, channel), box);
}

Agreement compareFields(const DenseField& ours, const DenseField& theirs, const DenseBox& box) {
    Comparison comparison;
    std::size_t i = 0;
    for (int z = box.low.z; z < box.high.z; ++z)
        for (int y = box.low.y; y < box.high.y; ++y)
            for (int x = box.low.x; x < box.high.x; ++x, ++i)
                comparison.add(Index3(x, y, z), double(ours[i]), double(theirs[i]));
    return comparison.result();
}

Agreement worseOf(const Agreement& a, const Agreement& b) {
    // Written so that NaN is the worst.
    Agreement worse = a.worst >= b.worst || std::isnan(a.worst) ? a : b;
    worse.rms = a.rms >= b.rms || std::isnan(a.rms) ? a.rms : b.rms;
    worse.voxels = std::max(a.voxels, b.voxels);
    return worse;
}

RadiosityJudgement judgeRadiosity(const IlluminationRecord& record, const ReplayResult& result,
                                  const openvdb::GridBase& radiosity) {
    const DenseMedium medium = mediumOf(record, 0);
    const double edge = std::cbrt(record.box.voxelVolume());
    RadiosityJudgement judgement;
    std::vector<bool> judged(medium.extinction.size());
    for (std::size_t i = 0; i < judged.size(); ++i) {
        const double opacity = -std::expm1(-double(medium.extinction[i]) * edge);
        const bool solid = record.surfaceOpacity > 0 && opacity >= record.surfaceOpacity;
        judged[i] = medium.extinction[i] > 0 && !medium.isSurface(i) && !solid;
        judgement.voxels += judged[i];
        judgement.active += medium.extinction[i] > 0;
    }
    for (int c = 0; c < record.channels; ++c) {
        DenseField ours = result.radiosityFields[std::size_t(c)], theirs = denseField(radiosity, record.box, c);
        for (std::size_t i = 0; i < theirs.size(); ++i)
            if (!judged[i]) theirs[i] = ours[i] = 0;
        judgement.agreement = worseOf(judgement.agreement, compareFields(ours, theirs, record.box));
    }
    return judgement;
}

DenseMedium mediumOf(const IlluminationRecord& record, int channel) {
    DenseMedium medium;
    medium.box = record.box;
    medium.extinction = denseField(*fieldOf(record.file, "extinction"), record.box);
    medium.albedo = record.albedo.empty() ? denseField(*fieldOf(record.file, "albedo"), record.box, channel)
                                          : DenseField(record.box.voxels(), float(record.albedo[std::size_t(channel)]));
    if (const auto normal = fieldOf(record.file, "normal", true))
        for (int axis = 0; axis < 3; ++axis) medium.normal[std::size_t(axis)] = denseField(*normal, record.box, axis);
    if (const auto source = fieldOf(record.file, "source", true))
        medium.source = denseField(*source, record.box, channel);
    if (const auto start = fieldOf(record.file, "unshot_start", true))
        medium.unshot = denseField(*start, record.box, channel);
    return medium;
}

void requireSameVolume(const IlluminationRecord& record, const openvdb::FloatGrid& grid) {
    if (const std::string found = checksum(grid); found != record.checksum)
        throw InvalidArgument("the volume is not the one that " + record.file.path +
                              " records: the checksum of grid '" + grid.getName() + "' is " + found + ", not " +
                              record.checksum);
}

ReplayResult replay(const IlluminationRecord& record, const ReplaySetup& setup, const ProgressCallback& progress) {
    ReplayResult result;
    const auto deposit = fieldOf(record.file, "deposit"), unshot = fieldOf(record.file, "unshot");
    for (const RecordedGroup& group : record.groups) result.sweeps += int(group.beams.size());
    result.sourceFromRecord = record.otherSources;
    for (int c = 0; c < record.channels; ++c) {
        const DenseMedium medium = mediumOf(record, c);
        const double sourcePower = sumOf(medium.source);
        if (const double all = sourcePower * record.injections + sumOf(medium.unshot); all > 0)
            result.startShare = std::max(result.startShare, sumOf(medium.unshot) / all);
        IlluminationSetup machineSetup = setupFor(record, setup);
        RunPower power;
        Illumination exact(medium, machineSetup);
        result.complete = runGroups(record, c, sourcePower, exact, setup, progress, power);
        if (!result.complete) return result;
        const Illumination* judged = &exact;
        std::optional<Illumination> rounded;
        if (setup.format) {
            machineSetup.format = setup.format;
            machineSetup.largestPower = exact.largestPower();
            machineSetup.largestDeposit = largestOf(exact.deposit());
            rounded.emplace(medium, machineSetup);
            power = {};
            result.complete = runGroups(record, c, sourcePower, *rounded, setup, progress, power);
            if (!result.complete) return result;
            judged = &*rounded;
            result.depositToFloat =
                worseOf(result.depositToFloat, compareFields(judged->deposit(), exact.deposit(), record.box));
            result.unshotToFloat =
                worseOf(result.unshotToFloat, compareFields(judged->unshot(), exact.unshot(), record.box));
        }
        result.depositFields.push_back(judged->deposit());
        result.deposit = worseOf(result.deposit, compareFields(result.depositFields.back(), *deposit, record.box, c));
        result.unshot = worseOf(result.unshot, compareFields(judged->unshot(), *unshot, record.box, c));
        result.source = worseOf(result.source, compareSource(record, medium, setup, c));
        if (!(power.worst <= result.rayPower)) result.rayPower = power.worst;
        const double balance = balanceOf(medium, record.rule, *judged, power);
        if (!(std::abs(balance) <= std::abs(result.balance))) result.balance = balance;
        result.radiosityFields.push_back(answerOf(record, medium, result.depositFields.back(), c, result.settledShare));
        for (float& value : result.radiosityFields.back()) value = float(double(value) * record.powerUnit);
        take(*judged, result);
    }
    return result;
}

}  // namespace raysweep::cube4
