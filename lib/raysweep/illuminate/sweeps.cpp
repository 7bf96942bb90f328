#include "raysweep/illuminate/sweeps.h"

#include "raysweep/illuminate/answer.h"
#include "raysweep/illuminate/coarse_level.h"
#include "raysweep/illuminate/convergence.h"
#include "raysweep/illuminate/power_balance.h"
#include "raysweep/illuminate/radiosity.h"
#include "raysweep/illuminate/sweep_recorder.h"
#include "raysweep/illuminate/white_furnace.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

namespace raysweep {
namespace {

constexpr int kLookInterval = 20;   ///< the paper's delta i: sweeps between estimates that are compared
constexpr int kFewestSweeps = 40;   ///< two estimates at least
constexpr int kFewGroups = 6;       ///< of directions: a batch of so many says little before it is complete
constexpr int kFoldInterval = 160;  ///< sweeps whose deposits floats add up without losing much
constexpr int kFinishInterval = 4;  ///< finishing sweeps between looks at what is left
constexpr int kCoarseSweeps = 40;
constexpr std::size_t kFewestBricks = 8;  ///< that a coarse level is worth while for
constexpr std::size_t kFewestMerged = 3;  ///< bricks that become one, on average
constexpr double kFurnaceUnshot = 1e-3;
constexpr int kFewestFurnaceSweeps = 400;
constexpr int kMostFinishing = 100000;  ///< a stop for media that lose power ever so slowly

/// Mean optical depth of a voxel from which on those twice as long are thick.
constexpr double kThickVoxels = 0.3;

/// What one sweep may draw on.
enum class Inject { everything, nothing };

/// How unshot power is shot.
struct Pace {
    double zeta;  ///< the part of it when `beams` beams go together: each of them shoots zeta / beams
    int beams;    ///< K: the most that go together
};

constexpr Pace kSettling{0.5, 1};  ///< of a change on a coarse level

/// The bricks of the coarse level to begin with; none if a solution is to begin in the dark. A coarse level averages
/// what is in a voxel: surfaces would be lost. The paper's way is to begin in the dark. And where bricks are scattered,
/// as many coarse ones would be just as much work.
std::vector<Index3> bricksToStartFrom(const SolverState& state, const IlluminateOptions& options) {
    const BrickLayout& layout = state.medium.volume.layout;
    if (!mayStartCoarse(options) || !state.solid.surfaces.empty() || state.solid.white.present() ||
        layout.brickCount() < kFewestBricks)
        return {};
    std::vector<Index3> origins = coarseOrigins(layout);
    return origins.size() * kFewestMerged <= layout.brickCount() ? std::move(origins) : std::vector<Index3>();
}

/// Of voxels that are not empty.
double meanDepth(const SolverState& state) {
    const double sum = sumOf(state.medium.tau),
                 count = double(std::max<std::size_t>(1, state.medium.volume.layout.activeVoxels));
    return sum / count;
}

/// What the options leave open. Begun in the dark, a small zeta wastes sweeps until as much is under way as there will
/// be. Begun from a coarse solution it averages over more directions what is scattered more than once; where voxels are
/// thick that solution is not that good, and power should move on. Measured with bench/quality.
Pace paceOf(const SolverState& state, const IlluminateOptions& options, bool coarse) {
    Pace pace{0.5, 1};
    if (coarse) pace = meanDepth(state) > kThickVoxels ? Pace{0.2, 1} : Pace{0.1, 8};
    if (options.zeta) pace.zeta = *options.zeta;
    if (options.beams > 0) pace.beams = options.beams;
    // Other sets have no groups: their directions would each shoot a part of what one alone should.
    if (isPeriodic(options.periodic) || options.directions != DirectionSet::fibonacci) pace.beams = 1;
    return pace;
}

/// Larger, where several directions go together, so that groups are.
int batchOf(const IlluminateOptions& options, const Pace& pace) {
    return options.batch > 0 ? options.batch : pace.beams > 1 ? 48 : 32;
}

class Solver {
  public:
    Solver(const Scene& scene, const IlluminateOptions& options, SolverState& state, const Pace& pace)
        : scene_(scene),
          options_(options),
          state_(state),
          zeta_(pace.zeta / pace.beams),
          mostBeams_(pace.beams),
          directions_({options.directions, batchOf(options, pace), options.seed, mostBeams_,
                       options.tolerance > 0 ? 0 : options.sweeps},
                      [inverse = state.medium.volume.layout.worldFromIndex.inverse()](const Vec3& direction) {
                          return directionClass(direction * inverse);
                      }),
          offsets_(options.seed ^ 0x9e3779b97f4a7c15ull) {}

    /// Sweeps the next directions that go together, `most` or fewer. @return their number
    int sweepNext(Inject inject, int most) {
        const std::vector<Vec3> directions = directions_.nextGroup(most);
        std::vector<Beam> beams;
        for (const Vec3& direction : directions) beams.push_back(nextBeam(direction, inject));
        const ExchangeConstants constants = this->constants();
        const ExchangeFields fields = exchangeFields(state_, inject == Inject::everything);
        const std::vector<RaySums> sums = sweep(state_.medium.volume, beams, options_.interpolation, fields, constants);
        if (options_.interpolation == Interpolation::linear) settle(state_.medium.volume, beams, fields, constants);
        sweepWhiteFurnace(state_, beams, options_.interpolation, constants, inject == Inject::everything);
        for (std::size_t i = 0; i < sums.size(); ++i) {
            for (int c = 0; c < state_.medium.channels; ++c) {
                state_.power.swept.injected[c] += sums[i].entered[c];
                state_.power.swept.escaped[c] += sums[i].escaped[c];
            }
            if (options_.afterSweep) options_.afterSweep(directions[i], inWatts(sums[i]));
        }
        if (options_.record) record(directions, beams, sums, inject);
        if (inject == Inject::everything) state_.power.injections += int(beams.size());
        return int(beams.size());
    }

    /// Sweeps the white furnace alone, without a sky.
    void sweepFurnaceNext() {
        std::vector<Beam> beams;
        for (const Vec3& direction : directions_.nextGroup(mostBeams_))
            beams.push_back(nextBeam(direction, Inject::nothing));
        sweepWhiteFurnace(state_, std::move(beams), options_.interpolation, constants(), false);
    }

    const DirectionSequence& directions() const { return directions_; }

    ExchangeConstants constants() const { return exchangeConstants(state_, zeta_, mostBeams_); }
    /// Part of the unshot power of a voxel that a beam shoots, on average over directions.
    double shotByBeam() const { return zeta_; }

    /// Power that was unshot, though never injected, before the first sweep.
    void startsWith(double unshot) { started_ = unshot; }
    bool hasStart() const { return started_ > 0; }
    /// Unshot power as part of all that was injected.
    double unshotShare() const {
        const double injected = injectedSoFar();
        return injected > 0 ? std::max(0.0, unshotPower(state_).sum() - started_) / injected : 0;
    }

    double injectedSoFar() const {
        double sum = 0;
        for (int c = 0; c < state_.medium.channels; ++c)
            sum += state_.power.perInjection.injected[c] * state_.power.injections + state_.power.swept.injected[c];
        return sum;
    }

  private:
    Beam nextBeam(const Vec3& direction, Inject inject) {
        const int reach = options_.interpolation == Interpolation::linear ? 1 : 0;
        const double column = uniform01(offsets_), row = uniform01(offsets_);
        Beam beam = darkBeam(state_.medium, parallelFront(state_.medium.volume.layout, direction, reach, {column, row},
                                                          state_.medium.volume.periodic));
        if (inject == Inject::everything) setSky(beam, direction);
        return beam;
    }

    /// A single direction stands for the whole sphere: rays carry the radiance over 4 pi steradians.
    void setSky(Beam& beam, const Vec3& direction) {
        const Color factor = scene_.sky.profile ? scene_.sky.profile(direction) : grey(1);
        for (int c = 0; c < state_.medium.channels; ++c) {
            beam.entering[c] = float(double(scene_.sky.radiance[c]) * std::max(0.0, double(factor[c])) * 4 * kPi *
                                     beam.front.crossSection / state_.power.unit);
            const double radiance = double(beam.entering[c]) / (4 * kPi * double(beam.furnaceRay));
            state_.power.brightest[c] = std::max(state_.power.brightest[c], radiance);
        }
    }

    void record(const std::vector<Vec3>& directions, const std::vector<Beam>& beams, const std::vector<RaySums>& sums,
                Inject inject) const {
        RecordedGroup group;
        group.inject = inject == Inject::everything;
        group.unshot = unshotPower(state_);
        for (std::size_t i = 0; i < beams.size(); ++i) {
            const RayFront& front = beams[i].front;
            group.beams.push_back({directions[i], front.column.offset, front.row.offset, {}, sums[i]});
            std::copy_n(beams[i].entering, kMaxChannels, group.beams.back().entering);
        }
        options_.record->groups.push_back(std::move(group));
    }

    RaySums inWatts(RaySums totals) const {
        for (int c = 0; c < kMaxChannels; ++c) {
            totals.entered[c] *= state_.power.unit;
            totals.escaped[c] *= state_.power.unit;
        }
        return totals;
    }

    const Scene& scene_;
    const IlluminateOptions& options_;
    SolverState& state_;
    const double zeta_;
    const int mostBeams_;
    double started_ = 0;
    DirectionSequence directions_;
    std::mt19937_64 offsets_;
};

/// Sweeps from `n` on to where it must be stopped: elsewhere groups of directions end where they do.
int sweepsToNextStop(int n, const IlluminateOptions& options) {
    const int most = options.sweeps - n;
    return options.snapshotEvery > 0 ? std::min(most, options.snapshotEvery - n % options.snapshotEvery) : most;
}

/// Where directions go in groups an estimate is good when a batch of them is complete. So it is looked at then, unless
/// it just has been, and not shortly before. Within a batch of a few groups it says little: only the first look, which
/// needs no good one, is there.
/// @param sweeps since the last look
bool isTimeToLook(int sweeps, bool first, const DirectionSequence& directions) {
    if (directions.groupSize() == 1) return sweeps >= kLookInterval;
    if (directions.left() == 0) return sweeps >= kLookInterval / 2;
    return sweeps >= kLookInterval && directions.left() >= kLookInterval / 2 &&
           (first || directions.batch() > kFewGroups * directions.groupSize());
}

/// Sweeps until the estimate stands still. @return how it ended
Termination iterate(Solver& solver, SolverState& state, const SweepJob& job, std::vector<ConvergencePoint>& history) {
    const IlluminateOptions& options = job.options;
    double done = 0;
    int looked = 0, folded = 0;
    while (state.power.injections < options.sweeps) {
        solver.sweepNext(Inject::everything, sweepsToNextStop(state.power.injections, options));
        const int n = state.power.injections;
        if (isTimeToLook(n - looked, looked == 0, solver.directions())) {
            const double rms = accumulateAndMeasureChange(state, n - std::exchange(looked, n));
            history.push_back({n, rms, solver.unshotShare()});
            if (n - folded >= kFoldInterval) {
                accumulateDeposits(state);
                folded = n;
            }
            if (n >= kFewestSweeps && rms < options.tolerance) return Termination::converged;
            // The difference falls like 1/n, so this is about the part of the sweeps that are done.
            if (rms > 0) done = std::max(done, std::min(1.0, options.tolerance / rms));
        }
        if (options.snapshot && options.snapshotEvery > 0 && n % options.snapshotEvery == 0)
            options.snapshot(n, snapshotGrid(state, job.scene, /*spread=*/!solver.hasStart()));
        if (!report(job.progress, "sweeping", std::max(done, double(n) / options.sweeps)))
            return Termination::interrupted;
    }
    return options.tolerance > 0 ? Termination::sweepLimit : Termination::converged;
}

/// Deposits all unshot power where it is likely to belong; what is scattered of it stays unshot.
void spreadRemaining(SolverState& state) {
    for (int c = 0; c < state.medium.channels; ++c) {
        const BrickField deposit = spreadUnshot(state, c);
        if (deposit.empty()) continue;  // nowhere to put it: it stays unshot
        for (std::size_t b = 0; b < state.medium.volume.layout.brickCount(); ++b) {
            alignas(64) float g[kBrickVoxels];
            effectiveAlbedos(state, c, b, g);
            for (int i = 0; i < kBrickVoxels; ++i) {
                state.power.recent[c].brick(b)[i] += deposit.brick(b)[i];
                state.power.unshot[c].brick(b)[i] = g[i] * deposit.brick(b)[i];
            }
        }
    }
}

/// Sweeps without injecting until no more than `enough` power is unshot. @return the number of sweeps
int shootRemaining(Solver& solver, SolverState& state, double enough, const ProgressCallback& progress,
                   Termination& termination) {
    const double first = unshotPower(state).sum();
    int sweeps = 0, folded = 0;
    for (double left = first; left > enough;) {
        if (sweeps >= kMostFinishing) {
            termination = Termination::sweepLimit;
            break;
        }
        for (const int end = sweeps + kFinishInterval; sweeps < end;)
            sweeps += solver.sweepNext(Inject::nothing, kMostBeams);
        if (sweeps - folded >= kLookInterval) {
            accumulateDeposits(state);
            folded = sweeps;
        }
        left = unshotPower(state).sum();
        const double done = std::log(first / left) / std::log(first / enough);
        if (!report(progress, "finishing", std::min(1.0, std::max(0.0, done)))) {
            termination = Termination::interrupted;
            break;
        }
    }
    return sweeps;
}

/// Sweeps the white furnace until hardly any of it is unshot, or that would take too long.
void settleFurnace(Solver& solver, SolverState& state, const ProgressCallback& progress, Termination& termination) {
    if (!state.solid.white.present()) return;
    const int most = std::max(kFewestFurnaceSweeps, 2 * state.power.injections);
    double left = unshotShareOfFurnace(state);
    for (int sweeps = 0; sweeps < most && left > kFurnaceUnshot; ++sweeps) {
        solver.sweepFurnaceNext();
        if (sweeps % kFinishInterval == 0) left = unshotShareOfFurnace(state);
        if (!report(progress, "furnace", double(sweeps) / most)) {
            termination = Termination::interrupted;
            break;
        }
    }
    state.solid.white.settled = left <= kFurnaceUnshot;
}

/// Solves the coarse level of `bricks` (which may start from one coarser still), and lets `state` begin where that has
/// ended.
std::unique_ptr<CoarseLevel> startFromCoarse(std::vector<Index3> bricks, SolverState& state, Solver& solver,
                                             const SweepJob& job, SweepRecord& record) {
    auto coarse = std::make_unique<CoarseLevel>(state, std::move(bricks));
    IlluminateOptions onCoarse = job.options;
    onCoarse.sweeps = kCoarseSweeps;
    onCoarse.tolerance = 0;
    onCoarse.snapshotEvery = 0;
    onCoarse.afterSweep = {};
    onCoarse.record = nullptr;
    onCoarse.seed = job.options.seed + 1;
    const SweepRecord solution = runSweeps(coarse->state, {job.scene, onCoarse, [&](const std::string&, double) {
                                                               return report(job.progress, "coarse start", 0);
                                                           }});
    record.coarseSweeps +=
        coarse->sweepCost(state) * (solution.sweeps + solution.finishingSweeps + solution.coarseSweeps);
    coarse->start(state, solver.shotByBeam());
    solver.startsWith(unshotPower(state).sum());
    return coarse;
}

/// Settles on the coarse level what has become more or less under way in `state` since the start.
void settleOnCoarse(CoarseLevel& coarse, SolverState& state, double enough, const SweepJob& job, SweepRecord& record) {
    IlluminateOptions onCoarse = job.options;
    onCoarse.afterSweep = {};
    onCoarse.record = nullptr;
    for (const int sign : {1, -1}) {
        coarse.takeChange(state, sign);
        // The same directions for both: their noise is the same.
        Solver solver(job.scene, onCoarse, coarse.state, kSettling);
        const int sweeps = shootRemaining(solver, coarse.state, enough, job.progress, record.termination);
        record.coarseSweeps += coarse.sweepCost(state) * sweeps;
        coarse.rememberChange(sign);
    }
    coarse.settle(state);
}

}  // namespace

SweepRecord runSweeps(SolverState& state, const SweepJob& job) {
    const IlluminateOptions& options = job.options;
    SweepRecord record;
    Timer timer;
    allocateSweepFields(state, options);
    allocateWhiteFurnace(state, options.interpolation);
    std::vector<Index3> coarseBricks = bricksToStartFrom(state, options);
    const bool fromCoarse = !coarseBricks.empty();
    Solver solver(job.scene, options, state, paceOf(state, options, fromCoarse));
    std::unique_ptr<CoarseLevel> coarse;
    if (fromCoarse) coarse = startFromCoarse(std::move(coarseBricks), state, solver, job, record);
    std::optional<SweepRecorder> recorder;
    if (options.record) recorder.emplace(*options.record, state, job.scene).begin(solver.constants(), fromCoarse);
    record.coarseSeconds = timer.seconds();
    timer = Timer();
    record.termination = iterate(solver, state, job, record.history);
    record.sweepSeconds = timer.seconds();
    timer = Timer();
    const bool shoot = options.remaining == Remaining::shoot, stopped = record.termination == Termination::interrupted;
    const double enough = options.unshotShare * solver.injectedSoFar();
    const bool finish = !coarse && shoot && !stopped;
    if (finish) record.finishingSweeps = shootRemaining(solver, state, enough, job.progress, record.termination);
    if (recorder) recorder->end();
    if (!stopped) settleFurnace(solver, state, job.progress, record.termination);
    if (coarse) settleOnCoarse(*coarse, state, enough, job, record);
    // Asked to stop, spreading is the quickest way to an answer that has all the power.
    else if (!finish && options.remaining != Remaining::drop)
        spreadRemaining(state);
    if (recorder) recorder->settle(coarse != nullptr);
    record.finishSeconds = timer.seconds();
    record.sweeps = state.power.injections;
    return record;
}

}  // namespace raysweep
