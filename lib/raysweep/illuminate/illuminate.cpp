#include "raysweep/illuminate/illuminate.h"

#include "raysweep/core/error.h"
#include "raysweep/illuminate/answer.h"
#include "raysweep/illuminate/direct.h"
#include "raysweep/illuminate/emission.h"
#include "raysweep/illuminate/power_balance.h"
#include "raysweep/illuminate/sweep_recorder.h"
#include "raysweep/illuminate/sweeps.h"
#include "raysweep/illuminate/voxel_radiance.h"
#include "raysweep/scene/extremes.h"
#include "raysweep/volume/voxel_check.h"

#include <cmath>
#include <utility>

namespace raysweep {
namespace {

/// A voxel's light meets about one voxel of each shell around it in a sweep.
double sweepsToReach(const BrickLayout& layout, std::size_t emitters) {
    if (emitters == 0) return 0;
    const double radius = 0.5 * Vec3(layout.high - layout.low).length();
    return 4 * kPi * radius * radius / double(emitters);
}

/// @throw InvalidArgument for what a record does not hold: rays that come in again.
void requireRecordable(const IlluminateOptions& options) {
    if (isPeriodic(options.periodic)) throw about("record", InvalidArgument("a periodic volume cannot be replayed"));
}

void take(SweepRecord record, Illumination& result) {
    result.termination = record.termination;
    result.history = std::move(record.history);
    result.sweeps = record.sweeps;
    result.finishingSweeps = record.finishingSweeps;
    result.coarseSweeps = record.coarseSweeps;
    result.seconds.coarse = record.coarseSeconds;
    result.seconds.sweeps = record.sweepSeconds;
    result.seconds.finish = record.finishSeconds;
}

/// Light and media of any strength are taken; what follows from them need not fit into a float.
void requireFinite(const Illumination& result, const Scene& scene) {
    const PowerBalance& power = result.power;
    bool finite = std::isfinite(power.error());
    for (int c = 0; c < result.plan.channels; ++c)
        finite = finite && std::isfinite(power.injected[c]) && std::isfinite(power.absorbed[c]) &&
                 std::isfinite(power.escaped[c]) && std::isfinite(power.unshot[c]);
    const std::string cause = describeExtremes(scene);
    if (!finite) throw InvalidArgument("the power balance is infinite or not a number: " + cause);
    requireFiniteResult(*result.radiosity, cause);
    if (result.unshot) requireFiniteResult(*result.unshot, cause);
    if (result.emission) requireFiniteResult(*result.emission, cause);
}

}  // namespace

Illumination illuminate(const Scene& scene, const IlluminateOptions& options, const ProgressCallback& progress) {
    scene.validate();
    options.validate();
    if (!scene.points.empty() && isPeriodic(options.periodic))
        throw InvalidArgument("a point light cannot be used in a periodic volume: it would repeat as well");
    Illumination result;
    result.plan = planIllumination(scene, options);
    if (options.record) requireRecordable(options);

    Timer timer;
    SolverState state = prepareState(scene, options, result.plan);
    result.activeVoxels = state.medium.volume.layout.activeVoxels;
    result.thickShare = thickShare(state);
    if (result.plan.surfaces) result.surfaceVoxels = countSurfaceVoxels(state.solid.surfaces);
    result.seconds.prepare = timer.seconds();

    timer = Timer();
    const Emitters emitters = addDirectLight(state, scene);
    result.emittedPower = emitters.power;
    result.emission = shownEmission(state, scene.medium);
    if (result.emission && options.shines) options.shines(result.emission);
    result.sweepsToReach = sweepsToReach(state.medium.volume.layout, emitters.voxels);
    state.emission.reset();
    result.seconds.direct = timer.seconds();
    if (options.record) {
        recordScene(*options.record, state, scene, options);
        options.record->emission = result.emission;
    }
    if (!report(progress, "direct light", 1))
        result.termination = Termination::interrupted;
    else if (result.plan.sweeps && state.medium.volume.layout.brickCount() > 0)
        take(runSweeps(state, {scene, options, progress}), result);

    timer = Timer();
    result.power = powerBalance(state);
    const FurnaceShares shares = furnaceShares(state);
    result.mediumFurnaceShare = shares.medium;
    result.whiteFurnaceShare = shares.white;
    result.radiosity = finalGrid(state, scene);
    if (result.plan.unshotGrid) result.unshot = unshotGrid(state, scene);
    requireFinite(result, scene);
    result.seconds.output = timer.seconds();
    return result;
}

}  // namespace raysweep
