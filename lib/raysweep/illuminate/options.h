/// What a user of illuminate() may choose.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/sweep/directions.h"
#include "raysweep/sweep/interpolation.h"
#include "raysweep/sweep/ray_sums.h"

#include <openvdb/openvdb.h>

#include <functional>
#include <optional>

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

struct IlluminationRecord;

struct IlluminateOptions {
    /// ζ, the part of a voxel's unshot power that leaves when K directions pass it together, ζ/K along each (a mean
    /// over directions); K is the most that may, see `beams`. (0,1]. Not given: 0.1 with a coarse start (0.2 where
    /// voxels are thick), else 0.5. (Paper: K = 1 and 0.1, which from the dark needs ten times as many sweeps.)
    std::optional<double> zeta;
    /// Stop when the RMS difference of radiosity between estimates 20 sweeps or more apart, relative to its RMS, is
    /// below this (paper, section 2.2, with delta i = 20); 0: never. >= 0. See convergence.h.
    double tolerance = 0.01;
    /// Most sweeps in which power is injected; with tolerance 0 the exact number; 0: direct light only. >= 0.
    int sweeps = 10000;
    /// `shoot` ends when the unshot power is below this part of all that was injected, (0,1].
    double unshotShare = 1e-4;
    Remaining remaining = Remaining::shoot;
    Interpolation interpolation = Interpolation::nearest;
    Exchange exchange = Exchange::automatic;
    /// A voxel has a surface if opacity, averaged, changes by more than this per voxel there, and what is behind it is
    /// opaque, (0,1].
    double surfaceThreshold = 0.1;
    DirectionSet directions = DirectionSet::fibonacci;
    /// Directions of the first shuffled, rotated Fibonacci batch (about so many, if it is known how many there will
    /// be); each later one is as large as all before it. 0: 48 where several go together (`beams`), else 32. >= 0.
    int batch = 0;
    /// Media that are not periodic begin with a solution on voxels twice as long (and that with one on voxels twice as
    /// long again), and what is under way at the end is settled there, if `remaining` is `shoot`. Not so with this.
    bool darkStart = false;
    /// Directions that pass a brick together, reading the same unshot power, 0 to 8: quicker for each, a little worse
    /// as a sample. 0: 8 with a coarse start, if voxels are thin, else 1. Always 1 in periodic volumes, and of
    /// directions that are not `fibonacci`.
    int beams = 0;
    std::uint64_t seed = 1;                  ///< of directions and offsets; the same seed gives the same bits
    Periodic periodic{false, false, false};  ///< axes of index space along which the bricks' bounding box repeats
    /// Called after each `snapshotEvery` sweeps (0: never) with the number of sweeps and the estimate of radiosity so
    /// far, unshot power spread; `shines`, called before, with what shines by itself all the while
    /// (Illumination::emission), if anything does.
    int snapshotEvery = 0;
    std::function<void(int sweep, openvdb::GridBase::Ptr radiosity)> snapshot;
    std::function<void(openvdb::GridBase::Ptr emission)> shines;
    /// Called after every sweep with what its rays carried, W, for those who want to look closer.
    std::function<void(const Vec3& direction, const RaySums& totals)> afterSweep;
    /// Filled with all that it takes to make the same sweeps again; null: nothing is recorded. Periodic volumes
    /// cannot be.
    IlluminationRecord* record = nullptr;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

}  // namespace raysweep
