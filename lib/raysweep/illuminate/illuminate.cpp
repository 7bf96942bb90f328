// Inject-and-shoot iteration (paper, section 2.2): every sweep injects all light again and moves unshot power on; the
// answer is what has been deposited divided by the number of injections.
#include "raysweep/illuminate/illuminate.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/direct.h"
#include "raysweep/illuminate/estimate.h"
#include "raysweep/illuminate/lit_grids.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

constexpr int kFoldInterval = 20;       ///< the paper's delta i: sweeps between estimates that are compared
constexpr int kFewestSweeps = 40;       ///< two estimates at least
constexpr int kFinishInterval = 4;      ///< finishing sweeps between looks at what is left
constexpr int kMostFinishing = 100000;  ///< a stop for media that lose power ever so slowly

/// What one sweep may draw on.
enum class Inject { everything, nothing };

class Solver {
  public:
    Solver(const Scene& scene, const IlluminateOptions& options, SolverState& state)
        : scene_(scene),
          options_(options),
          state_(state),
          directions_(options.directions, options.batch, options.seed),
          offsets_(options.seed ^ 0x9e3779b97f4a7c15ull) {}

    void sweepOnce(Inject inject) {
        const Vec3 direction = directions_.next();
        const int reach = options_.interpolation == Interpolation::linear ? 1 : 0;
        const double column = uniform01(offsets_), row = uniform01(offsets_);
        const RayFront front =
            parallelFront(state_.volume.layout, direction, reach, column, row, state_.volume.periodic);
        ExchangeStep step = exchangeStep(state_, front, options_.zeta);
        if (inject == Inject::everything) setSky(step, front, direction);
        const ExchangeFields fields = exchangeFields(state_, inject == Inject::everything);
        const SweepTotals totals = sweep(state_.volume, front, options_.interpolation, fields, step);
        if (options_.interpolation == Interpolation::linear) settle(state_.volume, fields, step);
        for (int c = 0; c < state_.channels; ++c) {
            state_.swept.injected[c] += totals.entered[c];
            state_.swept.escaped[c] += totals.escaped[c];
        }
        if (inject == Inject::everything) ++state_.injections;
        if (options_.afterSweep) options_.afterSweep(direction, inWatts(totals));
    }

    double injectedSoFar() const {
        double sum = 0;
        for (int c = 0; c < state_.channels; ++c)
            sum += state_.perInjection.injected[c] * state_.injections + state_.swept.injected[c];
        return sum;
    }

  private:
    /// A single direction stands for the whole sphere: rays carry the radiance over 4 pi steradians.
    void setSky(ExchangeStep& step, const RayFront& front, const Vec3& direction) const {
        const Color factor = scene_.sky.profile ? scene_.sky.profile(direction) : grey(1);
        for (int c = 0; c < state_.channels; ++c)
            step.entering[c] = float(double(scene_.sky.radiance[c]) * std::max(0.0, double(factor[c])) * 4 * kPi *
                                     front.crossSection / state_.powerUnit);
    }

    SweepTotals inWatts(SweepTotals totals) const {
        for (int c = 0; c < kMaxChannels; ++c) {
            totals.entered[c] *= state_.powerUnit;
            totals.escaped[c] *= state_.powerUnit;
        }
        return totals;
    }

    const Scene& scene_;
    const IlluminateOptions& options_;
    SolverState& state_;
    DirectionSequence directions_;
    std::mt19937_64 offsets_;
};

openvdb::GridBase::Ptr radiosityGrid(const SolverState& state, const Scene& scene,
                                     const std::vector<BrickField>& radiosity) {
    auto grid = extendedGridFromFields(state.volume.layout, *scene.medium.density, radiosity);
    grid->setName("radiosity");
    return grid;
}

/// The estimate so far, with what is unshot spread.
openvdb::GridBase::Ptr snapshotGrid(const SolverState& state, const Scene& scene) {
    std::vector<BrickField> radiosity;
    for (int c = 0; c < state.channels; ++c) {
        radiosity.emplace_back(state.volume.layout.brickCount());
        computeRadiosity(state, c, spreadUnshot(state, c), radiosity.back());
    }
    return radiosityGrid(state, scene, radiosity);
}

/// The answer. It takes the place of the deposits, so that the peak of memory stays in the sweeps.
openvdb::GridBase::Ptr finalGrid(SolverState& state, const Scene& scene) {
    std::vector<BrickField> radiosity;
    for (int c = 0; c < state.channels; ++c) {
        BrickField& field = state.total[c];
        const bool swept = !field.empty();
        BrickField own = swept ? BrickField() : BrickField(state.volume.layout.brickCount());
        computeRadiosity(state, c, BrickField(), swept ? field : own);
        radiosity.push_back(std::move(swept ? field : own));
        state.recent[c] = BrickField();
    }
    // Without a sweep the sources are what is unshot, and still needed.
    if (state.injections > 0)
        for (BrickField& source : state.source) source = BrickField();
    return radiosityGrid(state, scene, radiosity);
}

/// Unshot power, W; without a sweep that is what the sources add. Takes the field from `state`.
openvdb::GridBase::Ptr unshotGrid(SolverState& state, const Scene& scene) {
    const bool swept = !state.unshot[0].empty();
    if (!swept && !state.hasSource()) return nullptr;
    std::vector<BrickField> fields;
    for (int c = 0; c < state.channels; ++c) {
        fields.push_back(std::move(swept ? state.unshot[c] : state.source[c]));
        const double scale = state.powerUnit / std::max(1, state.injections);
        parallelFor(
            fields.back().brickCount(),
            [&](std::size_t b) {
                for (int i = 0; i < kBrickVoxels; ++i) fields.back().brick(b)[i] *= float(scale);
            },
            16);
    }
    auto grid = gridFromFields(state.volume.layout, *scene.medium.density, fields);
    grid->setName("unshot");
    return grid;
}

/// Sweeps until the estimate stands still. @return how it ended
Termination iterate(Solver& solver, SolverState& state, const Scene& scene, const IlluminateOptions& options,
                    const ProgressCallback& progress, std::vector<ConvergencePoint>& history) {
    double done = 0;
    while (state.injections < options.sweeps) {
        solver.sweepOnce(Inject::everything);
        const int n = state.injections;
        if (n % kFoldInterval == 0) {
            const double rms = foldDeposits(state, kFoldInterval);
            const double injected = solver.injectedSoFar();
            history.push_back({n, rms, injected > 0 ? unshotPower(state).sum() / injected : 0});
            if (n >= kFewestSweeps && rms < options.tolerance) return Termination::converged;
            // The difference falls like 1/n, so this is about the part of the sweeps that are done.
            if (rms > 0) done = std::max(done, std::min(1.0, options.tolerance / rms));
        }
        if (options.snapshot && options.snapshotEvery > 0 && n % options.snapshotEvery == 0)
            options.snapshot(n, snapshotGrid(state, scene));
        if (!report(progress, "sweeping", std::max(done, double(n) / options.sweeps))) return Termination::interrupted;
    }
    return options.tolerance > 0 ? Termination::sweepLimit : Termination::converged;
}

/// Deposits all unshot power where it is likely to belong; what is scattered of it stays unshot.
void spreadRemaining(SolverState& state) {
    for (int c = 0; c < state.channels; ++c) {
        const BrickField deposit = spreadUnshot(state, c);
        if (deposit.empty()) continue;  // nowhere to put it: it stays unshot
        for (std::size_t b = 0; b < state.volume.layout.brickCount(); ++b) {
            alignas(64) float g[kBrickVoxels];
            effectiveAlbedos(state, c, b, g);
            for (int i = 0; i < kBrickVoxels; ++i) {
                state.recent[c].brick(b)[i] += deposit.brick(b)[i];
                state.unshot[c].brick(b)[i] = g[i] * deposit.brick(b)[i];
            }
        }
    }
}

/// Sweeps without injecting until hardly any power is unshot. @return the number of sweeps
int shootRemaining(Solver& solver, SolverState& state, const IlluminateOptions& options,
                   const ProgressCallback& progress, Termination& termination) {
    const double injected = solver.injectedSoFar();
    const double first = unshotPower(state).sum(), enough = options.unshotShare * injected;
    int sweeps = 0;
    for (double left = first; left > enough;) {
        if (sweeps >= kMostFinishing) {
            termination = Termination::sweepLimit;
            break;
        }
        for (int i = 0; i < kFinishInterval; ++i) solver.sweepOnce(Inject::nothing);
        sweeps += kFinishInterval;
        foldDeposits(state, 0);
        left = unshotPower(state).sum();
        const double done = std::log(first / left) / std::log(first / enough);
        if (!report(progress, "finishing", std::min(1.0, std::max(0.0, done)))) {
            termination = Termination::interrupted;
            break;
        }
    }
    return sweeps;
}

/// A voxel's light meets about one voxel of each shell around it in a sweep.
double sweepsToReach(const BrickLayout& layout, std::size_t emitters) {
    if (emitters == 0) return 0;
    const double radius = 0.5 * Vec3(layout.high - layout.low).length();
    return 4 * kPi * radius * radius / double(emitters);
}

void runSweeps(Illumination& result, SolverState& state, const Scene& scene, const IlluminateOptions& options,
               const ProgressCallback& progress) {
    Timer timer;
    allocateSweepFields(state, options);
    Solver solver(scene, options, state);
    result.termination = iterate(solver, state, scene, options, progress, result.history);
    result.seconds.sweeps = timer.seconds();
    const bool shoot = options.remaining == Remaining::shoot;
    if (shoot && result.termination != Termination::interrupted)
        result.finishingSweeps = shootRemaining(solver, state, options, progress, result.termination);
    // Asked to stop, spreading is the quickest way to an answer that has all the power.
    if (options.remaining == Remaining::spread || (shoot && result.termination == Termination::interrupted))
        spreadRemaining(state);
    result.seconds.finish = timer.seconds() - result.seconds.sweeps;
    result.sweeps = state.injections;
}

}  // namespace

Illumination illuminate(const Scene& scene, const IlluminateOptions& options, const ProgressCallback& progress) {
    scene.validate();
    options.validate();
    if (!scene.points.empty() && (options.periodic[0] || options.periodic[1] || options.periodic[2]))
        throw InvalidArgument("a point light cannot be used in a periodic volume: it would repeat as well");
    Illumination result;
    result.plan = planIllumination(scene, options);

    Timer timer;
    SolverState state = prepareState(scene, options, result.plan);
    result.activeVoxels = state.volume.layout.activeVoxels;
    result.thickShare = thickShare(state);
    if (result.plan.surfaces) result.surfaceVoxels = countSurfaceVoxels(state.surfaces);
    result.seconds.prepare = timer.seconds();

    timer = Timer();
    const Emitters emitters = addDirectLight(state, scene);
    result.invisibleEmitters = emitters.invisible;
    result.sweepsToReach = sweepsToReach(state.volume.layout, emitters.voxels);
    result.seconds.direct = timer.seconds();
    if (!report(progress, "direct light", 1))
        result.termination = Termination::interrupted;
    else if (result.plan.sweeps && state.volume.layout.brickCount() > 0)
        runSweeps(result, state, scene, options, progress);

    timer = Timer();
    result.power = balance(state);
    result.radiosity = finalGrid(state, scene);
    if (result.plan.unshotGrid) result.unshot = unshotGrid(state, scene);
    result.seconds.output = timer.seconds();
    return result;
}

}  // namespace raysweep
