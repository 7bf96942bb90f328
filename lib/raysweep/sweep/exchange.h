/// What rays and voxels exchange: Dachille, Mueller and Kaufman 2000, Algorithm 1, as corrected in
/// docs/illumination.md, eq. L2. What a ray of the paper's equation 1 gathers on its way to the eye (render.h), a ray
/// here leaves behind on its way from the light.
///
/// Along a direction a ray of power e goes one step of length len, its stretch in a slice, through a voxel of
/// extinction s and unshot power U:
///
///     Algorithm 1, `corrected`                          `asPrinted`
///     alpha = 1 - exp(-s len)                           alpha = 1 - exp(-s h), h an edge of the voxel
///     in    = e alpha                                   the same
///     out   = U min(1, zeta (alpha / (s len)) / p)      out = zeta U
///     D += in;   e += out - in                          the same
///     U += g in - out                                   U += albedo in - out
///
/// with p the voxel's escape probability and g its effective albedo (escape.h, eq. L3 and L4). Nothing here can become
/// negative, and what one side gains the other loses.
///
/// A voxel with a surface of normal n takes from rays that arrive (omega.n < 0), all of alpha: slices already show it
/// at its projected size. It shoots into those that leave, out = U min(1, 4 zeta) omega.n, a Lambert emitter, and does
/// not attenuate them, or the surface would shade itself. What it takes is scattered once, g = albedo.
///
/// In a sweep of direct light nothing is shot that a surface could shade, and it takes alpha from all rays: light comes
/// upon the voxels along a convex edge, or at a silhouette, against their normals, and would go on through them.
///
/// How much a surface voxel collects depends on how its neighbours on the same surface shade it, so it is measured:
/// beside its power a ray carries f, the *local furnace*, which is set to radiance 1 where it is outside of solids and
/// is taken in and attenuated like power inside them. What it leaves behind is the voxel's furnace deposit F.
///
/// Several beams that share an axis go through a row of bricks together: first those that meet its bricks in one order,
/// then, while the row is still in a core's cache, those that meet them in the other. All of them read the U that a
/// brick had before, and each shoots its part of that: none sees what another has just left there, which would bring it
/// back the way it came.
///
/// "Outside" has to be told with care, or rays are counted twice (F too large) or not at all. Inside are surface
/// voxels, and those marked as inside of solids (in bricks that have a surface): a ray set back to 1 there would count
/// again where it comes upon another surface from within, at every concave edge. A ray that cuts a step of a staircase
/// and soon meets the next one is still the same ray: it must have been outside for kSurfaceGap slices. But one that
/// left a wall through its surface, and not at a glancing angle (kLeavingCosine), is new, however near the next wall
/// is. (Measured in docs/decisions/0005.)
#pragma once

#include "raysweep/bricks/bricks.h"
#include "raysweep/bricks/surface.h"
#include "raysweep/sweep/escape.h"
#include "raysweep/sweep/front_rays.h"

namespace raysweep {

/// Voxels of a smaller optical depth count as empty.
constexpr float kThinnest = 1e-20f;

constexpr int kSurfaceGap = 2;
constexpr float kLeavingCosine = 0.5f;

/// How voxels scatter.
enum class ExchangeModel {
    corrected,  ///< the rules above
    asPrinted   ///< Algorithm 1 as printed; at surfaces in = e alpha |omega.n|, out = zeta U omega.n
};

/// One float per voxel of every brick, or one brick of values that all share (`stride` 0).
template <class T>
struct BrickView {
    T* data = nullptr;
    std::size_t stride = kBrickVoxels;
    T* brick(std::size_t b) const { return data + b * stride; }
    operator BrickView<const T>() const { return {data, stride}; }
};

inline BrickView<float> viewOf(BrickField& field) {
    return {field.brick(0), kBrickVoxels};
}
inline BrickView<const float> viewOf(const BrickField& field) {
    return {field.brick(0), kBrickVoxels};
}
/// The same brick for every one.
inline BrickView<const float> sharedView(const BrickField& field) {
    return {field.brick(0), 0};
}

/// The volume as the exchange sees it. Powers are in any unit, that of the rays.
struct ExchangeFields {
    int channels = 1;
    BrickView<const float> tau;                   ///< extinction * mean step length
    BrickView<const float> albedo[kMaxChannels];  ///< single-scattering albedo
    BrickView<const float> source[kMaxChannels];  ///< power added to `unshot` for each beam
    BrickView<float> unshot[kMaxChannels];        ///< U
    BrickView<float> deposit[kMaxChannels];       ///< D
    BrickView<float> fresh[kMaxChannels];         ///< deposit of this sweep alone; `linear` only
    const Surfaces* surfaces = nullptr;           ///< null: none
    BrickView<float> furnace;  ///< F of the surfaces' bricks, in units of a ray's; null: not measured
};

constexpr int kMostBeams = 8;  ///< in one sweep

/// What is constant during one sweep.
struct ExchangeConstants {
    ExchangeModel model = ExchangeModel::corrected;
    EscapeFit escape;
    float zeta = 0.5f;   ///< ζ/K: part of the unshot power that is shot along each of up to K beams, (0,1]
    float mostShot = 1;  ///< the most that a beam may take of it; together they must not take more than there is
    /// Of direct light: U is 0, and surfaces take from rays that leave, too. Not with `asPrinted`.
    bool direct = false;
};

/// A brick as a sweep meets it.
struct BrickVisit {
    std::uint32_t brick;  ///< kNoBrick: a margin, see marginsBelow
    int column, row;      ///< lateral coordinates of its low corner (of its image, in a periodic volume)
    int slice;            ///< number, in the order of travel, of its first slice
    std::uint32_t beyondRow, beyondColumn, beyondBoth;  ///< bricks next to it on the upper side; `linear` only
};

/// A beam of a sweep, and its rays.
struct SweptBeam {
    const Beam* beam;
    FrontRays* rays;
};

/// The beams of a sweep. All have the same axis, and go the same way along it and along its rows.
struct SweptBeams {
    std::vector<SweptBeam> along;    ///< meet the bricks of a row in the order of the visits; never none
    std::vector<SweptBeam> against;  ///< meet them in the opposite order

    SweptBeams(const std::vector<Beam>& beams, std::vector<FrontRays>& rays);
    const RayFront& front() const { return along.front().beam->front; }
    std::size_t count() const { return along.size() + against.size(); }
    float mostStepScale() const;
};

/// End of the row of bricks that `visits[first]` begins.
std::size_t endOfRow(const std::vector<BrickVisit>& visits, std::size_t first);

/// Takes the rays through rows of bricks, no brick before one that is upwind of it for `along`; every voxel meets one
/// ray of each beam (`nearest`).
void exchangeNearest(const SweptBeams& beams, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                     const ExchangeConstants& constants);

/// The same where a ray meets the 2x2 voxels around it with bilinear weights. U is only read, and the deposit goes to
/// `fresh`; when all bricks are done, `settleBrick` brings both up to date.
void exchangeLinear(const SweptBeams& beams, const std::vector<BrickVisit>& visits, const ExchangeFields& fields,
                    const ExchangeConstants& constants);

/// Ends a `linear` sweep for brick `b`: D += fresh, U += g fresh - out + source, fresh = 0.
void settleBrick(const std::vector<Beam>& beams, const ExchangeFields& fields, const ExchangeConstants& constants,
                 std::size_t b);

/// g of every voxel of a brick as the exchange computes it, with the model and the escape probability of `constants`.
/// `albedo`, `tau` and `g` have 512 values, and `normals`, unless it is null.
void effectiveAlbedos(const ExchangeConstants& constants, const PackedNormal* normals, const float* tau,
                      const float* albedo, float* g);

}  // namespace raysweep
