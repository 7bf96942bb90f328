/// The exchange of rays and voxels in doubles, voxel by voxel and ray by ray, as the head of sweep/exchange.h has it:
/// what kernels are compared with.
#pragma once

#include "raysweep/sweep/exchange.h"
#include "raysweep/sweep/sweep_volume.h"

#include <array>
#include <vector>

namespace raysweep::test {

/// What is exchanged, and how.
struct ExchangeCase {
    Interpolation interpolation = Interpolation::nearest;
    ExchangeModel model = ExchangeModel::corrected;
    int channels = 1;
    bool surfaces = true;  ///< in every other brick
    double thickest = 20;  ///< tau; up to 1.5 / step scale kernels have a shorter formula
    Periodic periodic = {false, false, false};
    bool direct = false;

    int reach() const { return interpolation == Interpolation::linear ? 1 : 0; }
};

/// Fields of a small random volume. `unshot`, `deposit`, `fresh` and `furnace` are what a sweep changes.
struct ExchangeVolume {
    explicit ExchangeVolume(const ExchangeCase& made);
    ExchangeFields fields();
    /// Makes what a sweep changes as it was made.
    void restore(const ExchangeVolume& before);

    int channels;
    SweepVolume sweepVolume;
    Escape escape;
    Surfaces surfaces;
    BrickField furnace;
    BrickField tau, albedo[kMaxChannels], source[kMaxChannels], unshot[kMaxChannels], deposit[kMaxChannels],
        fresh[kMaxChannels];
};

/// A field after a sweep, minus before; one value per voxel.
using PlainField = std::vector<double>;

/// What a sweep of one beam changes.
struct PlainChange {
    PlainField unshot[kMaxChannels], deposit[kMaxChannels];
    PlainField furnace;
    double escaped[kMaxChannels] = {0};
};

PlainChange plainSweep(const ExchangeVolume& volume, const ExchangeConstants& constants, const Beam& beam);

}  // namespace raysweep::test
