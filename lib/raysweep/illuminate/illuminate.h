/// Global illumination of a volume by iterated energy backprojection (Dachille, Mueller and Kaufman 2000).
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/scene/scene.h"
#include "raysweep/sweep/directions.h"
#include "raysweep/sweep/sweep.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// What becomes of power that is still unshot when no more is injected (paper, section 2.2).
enum class Remaining {
    shoot,  ///< sweep on without injecting until hardly any is left
    drop,   ///< leave it out of the answer
    spread  ///< deposit it in proportion to density times gradient magnitude, without knowing where it would have gone
};

/// What rays and voxels exchange (docs/illumination.md).
enum class Exchange {
    automatic,  ///< `surface` if the medium is solid, else `medium`
    medium,     ///< every voxel scatters to all sides
    surface,    ///< voxels with a large gradient reflect as diffuse surfaces, the others are a medium
    paper       ///< Algorithm 1 as printed, with surfaces if the medium is solid
};

struct IlluminateOptions {
    /// Part of a voxel's unshot power that leaves in one sweep, [0,1]; 0: 0.1 with a coarse start, else 0.5. (Paper:
    /// 0.1, which then needs ten times as many sweeps.)
    std::optional<double> zeta;
    /// Stop when the RMS difference of radiosity between estimates 20 sweeps apart, relative to its RMS, is below this
    /// (paper, section 2.2, with delta i = 20); 0: never. >= 0.
    double tolerance = 0.01;
    /// Most sweeps in which power is injected; with tolerance 0 the exact number; 0: direct light only. >= 0.
    int sweeps = 10000;
    /// `shoot` ends when the unshot power is below this part of all that was injected, (0,1].
    double unshotShare = 1e-4;
    Remaining remaining = Remaining::shoot;
    Interpolation interpolation = Interpolation::nearest;
    Exchange exchange = Exchange::automatic;
    /// A voxel has a surface if opacity changes by more than this per voxel there, (0,1].
    double surfaceThreshold = 0.1;
    DirectionSet directions = DirectionSet::fibonacci;
    int batch = 32;  ///< directions of the first shuffled, rotated Fibonacci batch, >= 1; each batch is as
                     ///< large as all before it
    /// Media that are not periodic begin with a solution on voxels twice as long (and that with one on voxels twice as
    /// long again), and what is under way at the end is settled there, if `remaining` is `shoot`. Not so with this.
    bool darkStart = false;
    /// Directions that pass a brick together, reading the same unshot power, 0 to 8: quicker for each, a little worse
    /// as a sample. 0: 4 with a coarse start, if voxels are thin, else 1.
    int beams = 0;
    std::uint64_t seed = 1;                  ///< of directions and offsets; the same seed gives the same bits
    Periodic periodic{false, false, false};  ///< axes of index space along which the bricks' bounding box repeats
    /// Called after each `snapshotEvery` sweeps (0: never) with the number of sweeps and the estimate of radiosity so
    /// far, unshot power spread.
    int snapshotEvery = 0;
    std::function<void(int sweep, openvdb::GridBase::Ptr radiosity)> snapshot;
    /// Called after every sweep, for those who want to look closer.
    std::function<void(const Vec3& direction, const RaySums& totals)> afterSweep;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// What will be modelled, and why: only what the scene requires.
struct Plan {
    int channels = 1;         ///< wavelengths: 1 if everything is grey, else 3
    bool directPass = false;  ///< suns or points
    bool sweeps = false;      ///< anything can scatter, and there is light to scatter
    bool unshotGrid = false;
    bool surfaces = false;             ///< normals are found, and the local furnace is measured
    std::vector<std::string> reasons;  ///< one line each
};

Plan planIllumination(const Scene& scene, const IlluminateOptions& options);

/// Where the power went, W, per wavelength and per injection: injected = absorbed + escaped + unshot.
struct PowerBalance {
    double injected[kMaxChannels] = {0}, absorbed[kMaxChannels] = {0}, escaped[kMaxChannels] = {0},
           unshot[kMaxChannels] = {0};
    /// Largest |injected - absorbed - escaped - unshot| / injected of the wavelengths; 0 without light.
    double error() const;
};

enum class Termination {
    converged,    ///< the tolerance was met, or with tolerance 0 all sweeps were made
    sweepLimit,   ///< `sweeps` was reached first
    interrupted,  ///< the progress callback said stop; the answer is what there was
    direct        ///< nothing needed a sweep
};

struct ConvergencePoint {
    int sweep;
    double rms;          ///< relative RMS difference to the estimate 20 sweeps before
    double unshotShare;  ///< unshot power as part of the power injected so far
};

struct IlluminationTimings {
    double prepare = 0, direct = 0, coarse = 0, sweeps = 0, finish = 0, output = 0;  ///< s
};

struct Illumination {
    openvdb::GridBase::Ptr
        radiosity;  ///< source radiance, W m^-2 sr^-1: FloatGrid if grey, else Vec3SGrid; one voxel wider
    openvdb::GridBase::Ptr unshot;  ///< unshot power, W; null where the scene needs none
    Plan plan;
    PowerBalance power;
    Termination termination = Termination::direct;
    std::vector<ConvergencePoint> history;
    int sweeps = 0;           ///< in which power was injected
    int finishingSweeps = 0;  ///< in which only unshot power was shot
    std::size_t activeVoxels = 0;
    double thickShare = 0;  ///< part of the active voxels whose optical depth is above 2: too coarse to be accurate
    std::size_t invisibleEmitters =
        0;  ///< voxels that emit but have no extinction: they light others, unseen themselves
    std::size_t surfaceVoxels = 0;
    /// About how many sweeps it takes until the voxels that emit (quads, emission) have once lit every other one; 0
    /// without emitters. Where it is large, a point light says the same in one pass.
    double sweepsToReach = 0;
    IlluminationTimings seconds;
};

/// Lights `scene`.
/// @throw InvalidArgument for options or a scene that cannot be worked with.
Illumination illuminate(const Scene& scene, const IlluminateOptions& options = {},
                        const ProgressCallback& progress = {});

}  // namespace raysweep
