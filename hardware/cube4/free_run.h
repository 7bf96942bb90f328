/// A scene lit by the machine itself, without a recorded run: suns, a sky, directions of its own.
#pragma once

#include "cube4/illumination.h"

#include "raysweep/core/progress.h"

#include <cstdint>
#include <vector>

namespace raysweep::cube4 {

struct DenseSun {
    Vec3 direction{0, 0, -1};  ///< in which its light travels, world space
    double irradiance = 1;     ///< W / world unit^2
};

struct SceneLight {
    std::vector<DenseSun> suns;
    double sky = 0;             ///< radiance from all sides, W / world unit^2 / sr
    int sweeps = 100;           ///< that inject light
    double unshotShare = 1e-4;  ///< afterwards sweeps go on until less than this part of all power is unshot
    std::uint64_t seed = 1;     ///< of directions and offsets

    /// @throw InvalidArgument naming field, value and bound
    void validate() const;
};

/// A sweep, with or without injecting light.
struct ScriptedSweep {
    SweepFront front;
    bool inject = true;
};

struct FreeRun {
    std::vector<ScriptedSweep> sweeps;  ///< as they were done: `repeat` does the same
    int injections = 0;
    FrontPower power;        ///< of all rays
    double unshotShare = 0;  ///< of all power, that was still unshot in the end
    bool complete = true;    ///< false: stopped by the progress callback
};

/// Adds the direct light of suns to `medium.source`.
void addDirectLight(DenseMedium& medium, const IlluminationSetup& setup, const std::vector<DenseSun>& suns);

/// Sweeps until all is shot. `machine` holds a medium with its sources. @param box of the medium
/// @param sourcePower that a sweep injects
FreeRun runFreely(Illumination& machine, const DenseBox& box, double sourcePower, const SceneLight& light,
                  const ProgressCallback& progress = {}, Trace* trace = nullptr);

/// The same sweeps in another machine. @return false if it was stopped
bool repeat(const FreeRun& run, Illumination& machine, const ProgressCallback& progress = {});

}  // namespace raysweep::cube4
