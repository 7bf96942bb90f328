#include "raysweep/illuminate/voxel_radiance.h"

#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// F / (4 pi) in the paper's exchange: a fixed opacity times the mean cross-section of a ray. World area.
double paperAbsorbingArea(const MediumFields& medium, double tau) {
    const double volume = medium.volume.layout.voxelVolume, meanLength = medium.escape.meanStepLength();
    const double opacity = -std::expm1(-tau * std::cbrt(volume) / meanLength);
    return opacity * volume / meanLength * medium.escape.meanInverseLength();
}

/// Mean furnace deposit of a sweep in a voxel of a flat wall: 1/(4 pi) times the integral of the cosine.
constexpr double kFlatWall = 0.25;
/// Surface voxels that collect less than this part of a flat wall's are buried, or hardly there: their radiosity would
/// be a ratio of next to nothing and next to nothing.
constexpr double kLeastSeen = 0.02;

}  // namespace

void absorbingAreas(const MediumFields& medium, std::size_t b, float* area) {
    const float* const tau = medium.tau.brick(b);
    if (medium.model == ExchangeModel::asPrinted) {
        for (int i = 0; i < kBrickVoxels; ++i) area[i] = float(paperAbsorbingArea(medium, double(tau[i])));
        return;
    }
    // In floats, and nothing called: compilers make wide instructions of it.
    const EscapeFit fit = medium.escape.fit();
    const float perDepth = float(medium.volume.layout.voxelVolume / medium.escape.meanStepLength());
    for (int i = 0; i < kBrickVoxels; ++i) area[i] = tau[i] * perDepth * fit.probability(tau[i]);
}

void absorbedShares(const SolverState& state, int channel, std::size_t b, double* share) {
    const float* const tau = state.medium.tau.brick(b);
    const float* const albedo = state.medium.albedoView(channel).brick(b);
    const PackedNormal* const normals = state.solid.surfaces.normals(b);
    const bool scatterOnce = state.medium.model == ExchangeModel::asPrinted;
    const EscapeFit& fit = state.medium.escape.fit();
    for (int i = 0; i < kBrickVoxels; ++i) {
        const double stays = 1 - double(albedo[i]);
        const double p = scatterOnce || (normals && isSurface(normals[i])) ? 1 : fit.probability(double(tau[i]));
        share[i] = stays / (p + stays * (1 - p));
    }
}

FurnaceShares furnaceShares(const SolverState& state) {
    struct Counts {
        double medium = 0, white = 0;
        Counts& operator+=(const Counts& more) {
            medium += more.medium, white += more.white;
            return *this;
        }
    };
    if (!state.solid.present) return {};
    const Counts counts = orderedSum<Counts>(state.medium.volume.layout.brickCount(), [&](std::size_t b) {
        const BrickRadiance radiance(state, 0, b);
        Counts sum;
        for (int i = 0; i < kBrickVoxels; ++i) {
            if (!radiance.isKnown(i)) continue;
            if (radiance.isWhite(i))
                sum.white += 1;
            else if (!radiance.isSurface(i))
                sum.medium += 1;
        }
        return sum;
    });
    const double active = double(std::max<std::size_t>(1, state.medium.volume.layout.activeVoxels));
    return {counts.medium / active, counts.white / active};
}

BrickRadiance::BrickRadiance(const SolverState& state, int channel, std::size_t b)
    : state_(state),
      brick_(b),
      normals_(state.solid.surfaces.normals(b)),
      tau_(state.medium.tau.brick(b)),
      source_(state.power.hasSource() ? state.power.scatteredSource(channel).brick(b) : state.power.zero.brick(0)) {
    effectiveAlbedos(state, channel, b, g_);
    absorbingAreas(state.medium, b, perPower_);
    const float face = float(state.medium.voxelFace() / (4 * kPi));
    for (float& value : perPower_) value = face / value;
    if (state.solid.white.present()) white_ = state.solid.white.deposit.brick(b);
    settled_ = state.solid.white.settled;
    if (!normals_) return;
    const std::uint32_t slot = state.solid.surfaces.slots[b];
    if (!state.solid.furnace.empty()) furnace_ = state.solid.furnace.brick(slot);
    leastFurnace_ = kLeastSeen * kFlatWall * state.power.injections;
    if (!state.power.hasSource()) return;
    seen_ = state.solid.seen[channel].brick(slot);
    emitted_ = state.solid.emitted[channel].brick(slot);
}

}  // namespace raysweep
