/// What the solver holds while it works: what light meets, where solids have surfaces, and power on its way.
#pragma once

#include "raysweep/bricks/surface.h"
#include "raysweep/illuminate/options.h"
#include "raysweep/illuminate/plan.h"
#include "raysweep/illuminate/power_balance.h"
#include "raysweep/sweep/sweep.h"

#include <cmath>
#include <utility>
#include <vector>

namespace raysweep {

/// What light meets, whether it shines or not.
struct MediumFields {
    MediumFields(BrickLayout layout, const Periodic& periodic, Escape ofVoxels)
        : volume(std::move(layout), periodic), escape(std::move(ofVoxels)) {}

    SweepVolume volume;
    Escape escape;
    ExchangeModel model = ExchangeModel::corrected;
    int channels = 1;
    BrickField tau;                   ///< extinction * mean step length
    BrickField albedo[kMaxChannels];  ///< one brick if uniform
    bool uniformAlbedo = true;

    BrickView<const float> albedoView(int channel) const {
        return uniformAlbedo ? sharedView(albedo[channel]) : viewOf(albedo[channel]);
    }
    double voxelEdge() const { return std::cbrt(volume.layout.voxelVolume); }  ///< of a cube of a voxel's volume
    double voxelFace() const { return voxelEdge() * voxelEdge(); }
};

/// See white_furnace.h. Powers are in a ray's units of the local furnace.
struct WhiteFurnace {
    BrickField albedo;  ///< one brick of 1
    BrickField unshot, deposit, fresh;
    double injected = 0;
    bool settled = false;  ///< hardly anything is unshot

    bool present() const { return !deposit.empty(); }
};

/// Surfaces of solids and of quad lights, and what they show. The fields are of the surfaces' bricks alone.
struct SolidFields {
    bool present = false;  ///< there are surfaces besides those of quad lights
    Surfaces surfaces;
    std::vector<openvdb::FloatGrid::Ptr> quadAreas;  ///< see rasterizeQuad
    BrickField furnace;                              ///< sum of F over all injections; empty if not measured
    WhiteFurnace white;                              ///< where the local one cannot be trusted
    BrickField seen[kMaxChannels];                   ///< S of direct light, in `radianceUnit`
    BrickField emitted[kMaxChannels];                ///< the part of `source` that is not in `seen`
};

/// Power, in a unit that lets floats work for any voxel size and any strength of light.
struct PowerFields {
    double unit = 1;  ///< W
    /// What each injection adds to what is to be shot; empty without direct light or emission.
    BrickField source[kMaxChannels];
    /// The part of `source` that a medium's radiosity shows: all but what is emitted and has not been scattered yet
    /// (emission.h). Empty without emission, where it is `source`.
    BrickField scattered[kMaxChannels];
    BrickField unshot[kMaxChannels];
    BrickField recent[kMaxChannels];  ///< deposit since the last look (convergence.h)
    BrickField total[kMaxChannels];   ///< deposit up to the last look
    BrickField fresh[kMaxChannels];   ///< deposit of this sweep; `linear` only
    BrickField zero;                  ///< one brick of nothing

    int injections = 0;
    /// Radiance of the brightest ray that came in, in `radianceUnit`.
    double brightest[kMaxChannels] = {0};
    PowerBalance perInjection;  ///< of direct light and emission, for one injection, in `unit`
    PowerBalance swept;         ///< what rays of all sweeps so far brought in and out, in `unit`

    bool hasSource() const { return !source[0].empty(); }
    const BrickField& scatteredSource(int channel) const {
        return scattered[channel].empty() ? source[channel] : scattered[channel];
    }
};

struct SolverState {
    SolverState(BrickLayout layout, const Periodic& periodic, Escape ofVoxels)
        : medium(std::move(layout), periodic, std::move(ofVoxels)) {}

    MediumFields medium;
    openvdb::GridBase::ConstPtr emission;  ///< on the voxels of the density, see emissionOnVoxels; null: none
    SolidFields solid;
    PowerFields power;

    /// W m^-2 sr^-1: a unit of power spread over the face of a voxel and all directions.
    double radianceUnit() const { return power.unit / medium.voxelFace(); }
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

/// Sum over all voxels.
double sumOf(const BrickField& field);

/// The constants of a sweep of at most `beams` beams, each of which shoots the part `zeta`: what they shoot together
/// over their number.
ExchangeConstants exchangeConstants(const SolverState& state, double zeta, int beams);

/// The beam of `front`, dark.
Beam darkBeam(const MediumFields& medium, const RayFront& front);

/// Part of the active voxels that are a medium and whose optical depth (extinction * edge of a cube of a voxel's
/// volume) is above 2.
double thickShare(const SolverState& state);

}  // namespace raysweep
