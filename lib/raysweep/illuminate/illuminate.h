/// Global illumination of a volume by iterated energy backprojection (Dachille, Mueller and Kaufman 2000).
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/illuminate/history.h"
#include "raysweep/illuminate/options.h"
#include "raysweep/illuminate/plan.h"
#include "raysweep/illuminate/power_balance.h"
#include "raysweep/scene/scene.h"

#include <vector>

namespace raysweep {

struct IlluminationTimings {
    double prepare = 0, direct = 0, coarse = 0, sweeps = 0, finish = 0, output = 0;  ///< s
};

struct Illumination {
    openvdb::GridBase::Ptr
        radiosity;  ///< source radiance, W m^-2 sr^-1: FloatGrid if grey, else Vec3SGrid; one voxel wider
    /// What shines by itself and is no part of radiosity: emitted power per volume, W m^-3, on the voxels of the
    /// medium's own `emission` and one around them. Null where there is none, or all of it is of surfaces.
    openvdb::GridBase::Ptr emission;
    openvdb::GridBase::Ptr unshot;  ///< unshot power, W; null where the scene needs none
    Plan plan;
    PowerBalance power;
    Termination termination = Termination::direct;
    std::vector<ConvergencePoint> history;
    int sweeps = 0;           ///< in which power was injected
    int finishingSweeps = 0;  ///< in which only unshot power was shot
    /// Work on coarse levels before the first sweep and after the last, in sweeps of the solution's own level.
    double coarseSweeps = 0;
    std::size_t activeVoxels = 0;
    double thickShare = 0;    ///< part of the active voxels whose optical depth is above 2: too coarse to be accurate
    double emittedPower = 0;  ///< of the medium's `emission`, W, of all wavelengths
    std::size_t surfaceVoxels = 0;
    /// Of solids, parts of the active voxels: whose F is the closed form of a medium, since they have no surface, and
    /// whose F was swept as a white furnace, since the solids are soft or noisy. Others are surfaces, or inside.
    double mediumFurnaceShare = 0, whiteFurnaceShare = 0;
    /// About how many sweeps it takes until the voxels that emit (quads, emission) have once lit every other one; 0
    /// without emitters. Where it is large, a point light says the same in one pass.
    double sweepsToReach = 0;
    IlluminationTimings seconds;
};

/// Lights `scene`.
/// @throw InvalidArgument for options or a scene that cannot be worked with, or whose answer does not fit into floats.
Illumination illuminate(const Scene& scene, const IlluminateOptions& options = {},
                        const ProgressCallback& progress = {});

}  // namespace raysweep
