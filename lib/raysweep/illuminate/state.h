/// What the solver holds while it works: fields over the bricks, and the books of power.
#pragma once

#include "raysweep/bricks/surface.h"
#include "raysweep/illuminate/illuminate.h"

#include <cmath>

namespace raysweep {

/// Powers are kept in units of `powerUnit`, so that floats work for any voxel size and any strength of light.
struct SolverState {
    SolverState(BrickLayout layout, const Periodic& periodic, Escape ofVoxels)
        : volume(std::move(layout), periodic), escape(std::move(ofVoxels)) {}

    SweepVolume volume;
    Escape escape;
    ExchangeModel exchange = ExchangeModel::consistent;
    bool solids = false;  ///< surfaces are more than those of quad lights
    Surfaces surfaces;
    double surfaceThreshold = 0;
    int channels = 1;
    double powerUnit = 1;  ///< W

    BrickField tau;                   ///< extinction * mean step length
    BrickField albedo[kMaxChannels];  ///< one brick if uniform
    bool uniformAlbedo = true;
    BrickField
        source[kMaxChannels];  ///< power to be shot that each injection adds; empty without direct light or emission
    BrickField unshot[kMaxChannels];
    BrickField recent[kMaxChannels];                 ///< deposit since the last fold
    BrickField total[kMaxChannels];                  ///< deposit up to the last fold
    BrickField fresh[kMaxChannels];                  ///< deposit of this sweep; `linear` only
    std::vector<openvdb::FloatGrid::Ptr> quadAreas;  ///< see rasterizeQuad
    BrickField zero;                                 ///< one brick of nothing

    // Of the surfaces' bricks alone:
    BrickField furnace;                ///< sum of F over all injections; empty if not measured
    BrickField seen[kMaxChannels];     ///< S of direct light, in `radianceUnit`
    BrickField emitted[kMaxChannels];  ///< the part of `source` that is not in `seen`

    int injections = 0;
    PowerBalance perInjection;  ///< of direct light and emission, for one injection, in powerUnit
    PowerBalance swept;         ///< of the rays of all sweeps so far, in powerUnit

    /// A power spread over the face of a voxel and all directions.
    double voxelFace() const { return std::cbrt(volume.layout.voxelVolume) * std::cbrt(volume.layout.voxelVolume); }
    double radianceUnit() const { return powerUnit / voxelFace(); }  ///< W m^-2 sr^-1
    /// tau from which on a voxel without a surface is the inside of a solid, if there are solids: an opacity that would
    /// make a surface if it began there.
    double solidTau() const {
        if (!solids) return INFINITY;
        return -std::log1p(-surfaceThreshold) * escape.meanStepLength() / std::cbrt(volume.layout.voxelVolume);
    }
    bool hasSource() const { return !source[0].empty(); }
    BrickView<const float> albedoView(int channel) const {
        return uniformAlbedo ? sharedView(albedo[channel]) : viewOf(albedo[channel]);
    }
};

/// Fields of extinction and albedo, nothing lit yet. @throw InvalidArgument for voxels without meaning.
SolverState prepareState(const Scene& scene, const IlluminateOptions& options, const Plan& plan);

/// True if the options allow a solution to begin on a coarse level.
bool mayStartCoarse(const IlluminateOptions& options);

/// Fields that only sweeps need.
void allocateSweepFields(SolverState& state, const IlluminateOptions& options);

/// The fields as a sweep sees them. With `injecting` the sources add their power and the local furnace is measured.
ExchangeFields exchangeFields(SolverState& state, bool injecting);

/// Effective albedo of the 512 voxels of brick `b`.
void effectiveAlbedos(const SolverState& state, int channel, std::size_t b, float* g);

/// One power for each wavelength.
struct ChannelPower {
    double value[kMaxChannels] = {0};
    ChannelPower& operator+=(const ChannelPower& other);
    double sum() const { return value[0] + value[1] + value[2]; }
};

/// Sum over all voxels.
double sumOf(const BrickField& field);

/// The constants of a sweep of at most `beams` beams, each of which shoots the part `zeta`.
ExchangeConstants exchangeConstants(const SolverState& state, double zeta, int beams);

/// The beam of `front`, dark.
Beam darkBeam(const SolverState& state, const RayFront& front);

/// Part of the active voxels that are a medium and whose optical depth (extinction * edge of a cube of a voxel's
/// volume) is above 2.
double thickShare(const SolverState& state);

}  // namespace raysweep
