/// From what single voxels meet to what they are: source radiance and absorbed power.
///
///     S = (q_s + g D / n) / F,    F = 4 pi s V p  in a medium, measured at surfaces              (L5)
///     absorbed = (1 - g) D / n  = 4 pi s V S (1 - albedo) / albedo
///
/// with q_s the scattered part of the source, D the deposit of n injections, s the extinction, V the voxel's volume, p
/// its escape probability and g its effective albedo (sweep/escape.h, eq. L3 and L4; docs/illumination.md, eq. L5).
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// F / (4 pi) of the voxels of brick `b`, world unit^2, taken all to be medium.
void absorbingAreas(const MediumFields& medium, std::size_t b, float* area);

/// 1 - g of the voxels of brick `b`: the part of a deposit that stays. In doubles, and not from the g of the exchange:
/// where albedo is nearly 1, a float's 1 - g has no digits left.
void absorbedShares(const SolverState& state, int channel, std::size_t b, double* share);

/// By what F (eq. L5) the voxels of solids are known: parts of those that are active.
struct FurnaceShares {
    double medium = 0;  ///< the closed form of a medium, since they have no surface
    double white = 0;   ///< that of the white furnace (white_furnace.h)
};
FurnaceShares furnaceShares(const SolverState& state);

/// Source radiance of the voxels of a brick, in `radianceUnit`.
class BrickRadiance {
  public:
    BrickRadiance(const SolverState& state, int channel, std::size_t b);

    bool isKnown(int i) const {
        if (!(tau_[i] > 0)) return false;
        if (!isSurface(i)) return !state_.solid.surfaces.isInside(brick_, i);
        // Fog where a quad light is has no say of its own.
        return state_.solid.present && (!furnace_ || collected(i) > leastFurnace_);
    }

    bool isSurface(int i) const { return normals_ && raysweep::isSurface(normals_[i]); }

    /// 1 / F, in units of 1 / voxelFace. Without sweeps F of a surface is taken to be that of a flat wall.
    double perPower(int i) const {
        if (isSurface(i) && !furnace_) return 1 / kPi;
        if (!isSurface(i) && !white_) return double(perPower_[i]);
        const double sum = collected(i);
        return sum > 0 ? state_.power.injections / (4 * kPi * sum) : 0;
    }

    /// True if F is that of the white furnace.
    bool isWhite(int i) const { return white_ && double(white_[i]) > (settled_ ? kLeastWhite * own(i) : own(i)); }

    /// The part that comes straight from sources. @param perPower of the voxel
    double directly(int i, double perPower) const {
        if (!isSurface(i)) return double(source_[i]) * perPower;
        return seen_ ? double(seen_[i]) + double(emitted_[i]) * perPower : 0;
    }

    /// The part that is scattered of the radiance that the voxel has received: its deposit over F.
    double scattered(int i, double received) const { return double(g_[i]) * received; }

  private:
    /// A white furnace that gives less than this part of what the voxel would collect by itself hardly reaches it.
    static constexpr double kLeastWhite = 0.02;

    /// Sum over all injections of what the furnace left in the voxel, in units of its rays; `own`: without the white
    /// one.
    double own(int i) const {
        return isSurface(i) ? double(furnace_[i]) : state_.power.injections / (4 * kPi * double(perPower_[i]));
    }
    double collected(int i) const { return isWhite(i) ? double(white_[i]) : own(i); }

    const SolverState& state_;
    const std::size_t brick_;
    const PackedNormal* const normals_;
    const float* const tau_;
    const float* const source_;
    const float* seen_ = nullptr;
    const float* emitted_ = nullptr;
    const float* furnace_ = nullptr;
    const float* white_ = nullptr;
    bool settled_ = false;
    double leastFurnace_ = 0;
    alignas(64) float g_[kBrickVoxels];
    alignas(64) float perPower_[kBrickVoxels];  ///< as if all were medium; of no meaning in empty ones
};

}  // namespace raysweep
