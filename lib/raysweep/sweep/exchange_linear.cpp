// `linear`: a ray meets the 2x2 voxels around it. Dachille, Mueller and Kaufman 2000, Algorithm 1, with the corrections
// of docs/illumination.md. Compiled once per instruction set; the best one that the machine has is chosen at run time.
#include "raysweep/sweep/exchange.h"
#include "raysweep/sweep/tile_rays.h"

#include <vector>

#include "raysweep/sweep/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/sweep/exchange_linear.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/sweep/exchange_terms-inl.h"
#include "raysweep/sweep/transpose-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// A brick in a layer of a `linear` sweep: what its voxels do to rays, and what they receive.
template <int kChannels>
struct LinearBrick {
    HWY_ALIGN float opacity[kBrickVoxels];
    HWY_ALIGN float out[kChannels][kBrickVoxels];
    HWY_ALIGN float in[kChannels][kBrickVoxels];
    bool furnace = false;                 ///< has surfaces whose furnace is measured
    HWY_ALIGN float solid[kBrickVoxels];  ///< 1 where rays are inside a solid, -1 where they leave one, else 0
    HWY_ALIGN float furnaceIn[kBrickVoxels];
};

template <ExchangeModel kModel, int kChannels>
HWY_INLINE void prepareLinear(const RayFront& front, const ExchangeFields& fields, const ExchangeStep& step,
                              std::size_t b, LinearBrick<kChannels>& brick) {
    HWY_ALIGN float opacity[kBrickVoxels];
    HWY_ALIGN float solid[kBrickVoxels];
    HWY_ALIGN float out[kChannels][kBrickVoxels];
    const bool turn = front.axis.transposed;
    float* const opacityTo = turn ? opacity : brick.opacity;
    float* const solidTo = turn ? solid : brick.solid;
    const PackedNormal* const normals = fields.surfaces ? fields.surfaces->normals(b) : nullptr;
    brick.furnace = normals && fields.furnace.data;
    for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes))) {
        const Vec tau = hn::Load(kLanes, fields.tau.brick(b) + i);
        RowTerms terms = rowTerms<kModel>(step, tau);
        if (normals) {
            const RowSolids solids = applySurfaces<kModel>(step, normals + i, tau, terms);
            const Vec leaving = hn::IfThenElseZero(solids.leaving, hn::Set(kLanes, -1.0f));
            hn::Store(hn::IfThenElse(solids.inside, hn::Set(kLanes, 1.0f), leaving), kLanes, solidTo + i);
            hn::Store(hn::Zero(kLanes), kLanes, brick.furnaceIn + i);
        }
        hn::Store(terms.opacity, kLanes, opacityTo + i);
        for (int c = 0; c < kChannels; ++c) {
            const Vec U = hn::Load(kLanes, fields.unshot[c].brick(b) + i);
            hn::Store(hn::Mul(U, terms.shot), kLanes, (turn ? out[c] : brick.out[c]) + i);
            hn::Store(hn::Zero(kLanes), kLanes, brick.in[c] + i);
        }
    }
    if (!turn) return;
    transposePlanes(opacity, brick.opacity, 0, kBrickEdge - 1);
    if (normals) transposePlanes(solid, brick.solid, 0, kBrickEdge - 1);
    for (int c = 0; c < kChannels; ++c) transposePlanes(out[c], brick.out[c], 0, kBrickEdge - 1);
}

template <int kChannels>
HWY_INLINE void finishLinear(const RayFront& front, const ExchangeFields& fields, std::size_t b,
                             const LinearBrick<kChannels>& brick) {
    HWY_ALIGN float turned[kBrickVoxels];
    const auto add = [&](const float* in, float* to) {
        if (front.axis.transposed) {
            transposePlanes(in, turned, 0, kBrickEdge - 1);
            in = turned;
        }
        for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes)))
            hn::Store(hn::Add(hn::Load(kLanes, to + i), hn::Load(kLanes, in + i)), kLanes, to + i);
    };
    for (int c = 0; c < kChannels; ++c) add(brick.in[c], fields.fresh[c].brick(b));
    if (brick.furnace) add(brick.furnaceIn, fields.furnace.brick(fields.surfaces->slots[b]));
}

/// Bilinear weights of the 2x2 voxels around a ray; the same for all rays of a slice.
struct Stencil {
    float weight[2][2];  ///< [row][column]

    Stencil(const RayFront& front, int step) {
        const float fu = float(front.column.position(step) - front.column.shift(step));
        const float fv = float(front.row.position(step) - front.row.shift(step));
        weight[0][0] = (1 - fv) * (1 - fu);
        weight[0][1] = (1 - fv) * fu;
        weight[1][0] = fv * (1 - fu);
        weight[1][1] = fv * fu;
    }
};

/// Slice j of a brick: voxels take from the rays around them (all still as they were before this slice) and the changes
/// of the rays are added up in `change`. A voxel with weight [dv][du] to a ray is `du`, `dv` beyond the ray's shift.
template <int kChannels>
HWY_INLINE void linearSlice(const RayFront& front, const Overlap& overlap, int j, const Stencil& stencil,
                            LinearBrick<kChannels>& brick, TileRays& rays, TileRays& change) {
    for (int r = 0; r < kBrickEdge; ++r) {
        const int at = overlap.slice[j] * front.axis.sliceStride + r * front.axis.rowStride;
        for (int dv = 0; dv < 2; ++dv) {
            const int row = overlap.row[j] + r - dv;
            if (row < 0 || row >= rays.rows()) continue;
            for (int c = 0; c < kChannels; ++c)
                for (int du = 0; du < 2; ++du) {
                    const Vec weight = hn::Set(kLanes, stencil.weight[dv][du]);
                    const std::size_t plane = std::size_t(c) * rays.planeStride();
                    float* const ray = rays.row(row) + plane + overlap.column[j] - du;
                    float* const delta = change.row(row) + plane + overlap.column[j] - du;
                    for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
                        const Vec opacity = hn::Mul(weight, hn::Load(kLanes, brick.opacity + at + lane));
                        const Vec in = hn::Mul(opacity, hn::LoadU(kLanes, ray + lane));
                        const Vec out = hn::Mul(weight, hn::Load(kLanes, brick.out[c] + at + lane));
                        float* const into = brick.in[c] + at + lane;
                        hn::Store(hn::Add(hn::Load(kLanes, into), in), kLanes, into);
                        hn::StoreU(hn::Add(hn::LoadU(kLanes, delta + lane), hn::Sub(out, in)), kLanes, delta + lane);
                    }
                }
        }
    }
}

/// The rays that slice j of a brick meets.
struct MetRays {
    int firstColumn, endColumn, firstRow, endRow;

    MetRays(const Overlap& overlap, int j, const TileRays& rays)
        : firstColumn(std::max(0, overlap.column[j] - 1)),
          endColumn(std::min(rays.columns(), overlap.column[j] + kBrickEdge)),
          firstRow(std::max(0, overlap.row[j] - 1)),
          endRow(std::min(rays.rows(), overlap.row[j] + kBrickEdge)) {}
};

/// Local furnace of the rays that slice j of a brick meets, before the slice: 1 for those that come from outside.
HWY_INLINE void renewFurnace(const ExchangeStep& step, const MetRays& met, int slice, TileRays& rays) {
    for (int row = met.firstRow; row < met.endRow; ++row)
        for (int u = met.firstColumn; u < met.endColumn; ++u)
            if (rays.sliceRow(row)[u] < float(slice - kSurfaceGap)) rays.furnaceRow(row)[u] = step.furnaceRay;
}

/// What slice j of a brick takes of the local furnace. `change` adds up what rays lose, and how much more of each is
/// inside a solid than leaves one.
HWY_INLINE void furnaceSlice(const RayFront& front, const Overlap& overlap, int j, const Stencil& stencil,
                             const float* opacity, const float* solid, float* furnaceIn, TileRays& rays,
                             TileRays& change) {
    for (int r = 0; r < kBrickEdge; ++r)
        for (int dv = 0; dv < 2; ++dv) {
            const int row = overlap.row[j] + r - dv;
            if (row < 0 || row >= rays.rows()) continue;
            const int at = overlap.slice[j] * front.axis.sliceStride + r * front.axis.rowStride;
            for (int du = 0; du < 2; ++du)
                for (int lane = 0; lane < kBrickEdge; ++lane) {
                    const int u = overlap.column[j] - du + lane;
                    if (u < 0 || u >= rays.columns()) continue;
                    const float weight = stencil.weight[dv][du];
                    const float in = solid[at + lane] > 0 ? weight * opacity[at + lane] * rays.furnaceRow(row)[u] : 0;
                    furnaceIn[at + lane] += in;
                    change.furnaceRow(row)[u] += in;
                    change.sliceRow(row)[u] += weight * solid[at + lane];
                }
        }
}

/// Takes what solids took off the local furnace of the rays that slice j of a brick meets.
HWY_INLINE void applyFurnace(const MetRays& met, int slice, TileRays& rays, TileRays& change) {
    for (int row = met.firstRow; row < met.endRow; ++row)
        for (int u = met.firstColumn; u < met.endColumn; ++u) {
            float &taken = change.furnaceRow(row)[u], &inside = change.sliceRow(row)[u];
            rays.furnaceRow(row)[u] = std::max(0.0f, rays.furnaceRow(row)[u] - taken);
            if (inside != 0) rays.sliceRow(row)[u] = inside > 0 ? float(slice) : kLongAgo;
            taken = inside = 0;
        }
}

/// Applies and clears the changes of the rays that slice j of a brick has met.
HWY_INLINE void applyChange(const MetRays& met, int channels, TileRays& rays, TileRays& change) {
    for (int c = 0; c < channels; ++c)
        for (int row = met.firstRow; row < met.endRow; ++row) {
            float* const ray = rays.row(row) + std::size_t(c) * rays.planeStride();
            float* const delta = change.row(row) + std::size_t(c) * rays.planeStride();
            for (int u = met.firstColumn; u < met.endColumn; ++u) {
                // Weights that sum to 1 but for rounding can leave a dark ray at -1e-8 of what it carried.
                ray[u] = std::max(0.0f, ray[u] + delta[u]);
                delta[u] = 0;
            }
        }
}

/// Takes the local furnace through slice j of the bricks of a layer.
template <int kChannels>
void furnaceThroughSlice(const RayFront& front, const std::vector<Overlap>& overlaps,
                         std::vector<LinearBrick<kChannels>>& bricks, int j, const ExchangeStep& step, int slice,
                         TileRays& rays, TileRays& change) {
    const Stencil stencil(front, slice);
    const auto forEach = [&](const auto& visit) {
        for (std::size_t i = 0; i < overlaps.size(); ++i)
            if (bricks[i].furnace) visit(MetRays(overlaps[i], j, rays), i);
    };
    forEach([&](const MetRays& met, std::size_t) { renewFurnace(step, met, slice, rays); });
    forEach([&](const MetRays&, std::size_t i) {
        furnaceSlice(front, overlaps[i], j, stencil, bricks[i].opacity, bricks[i].solid, bricks[i].furnaceIn, rays,
                     change);
    });
    forEach([&](const MetRays& met, std::size_t) { applyFurnace(met, slice, rays, change); });
}

template <ExchangeModel kModel, int kChannels>
void linearTile(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                TileSums& sums) {
    const bool furnace = fields.furnace.data != nullptr;
    TileRays rays(tile, kChannels, furnace), change(tile, kChannels, furnace);
    rays.enter(front, tile, fields, step, sums);
    std::vector<LinearBrick<kChannels>> bricks;
    std::vector<Overlap> overlaps;
    for (const BrickVisit* layer = tile.begin; layer != tile.end;) {
        const BrickVisit* end = layer;
        while (end != tile.end && end->step == layer->step) ++end;
        const std::size_t count = std::size_t(end - layer);
        bricks.resize(std::max(bricks.size(), count));
        overlaps.clear();
        for (std::size_t i = 0; i < count; ++i) {
            overlaps.emplace_back(front, tile, layer[i]);
            prepareLinear<kModel, kChannels>(front, fields, step, layer[i].brick, bricks[i]);
        }
        for (int j = 0; j < kBrickEdge; ++j) {
            const Stencil stencil(front, layer->step + j);
            for (std::size_t i = 0; i < count; ++i)
                if (!overlaps[i].missesColumns(j, rays.columns(), 1))
                    linearSlice<kChannels>(front, overlaps[i], j, stencil, bricks[i], rays, change);
            for (std::size_t i = 0; i < count; ++i) applyChange(MetRays(overlaps[i], j, rays), kChannels, rays, change);
            if (furnace)
                furnaceThroughSlice<kChannels>(front, overlaps, bricks, j, step, layer->step + j, rays, change);
        }
        for (std::size_t i = 0; i < count; ++i) finishLinear<kChannels>(front, fields, layer[i].brick, bricks[i]);
        layer = end;
    }
    rays.leave(front, tile, fields, sums);
}

template <ExchangeModel kModel>
void linearChannels(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                    TileSums& sums) {
    fields.channels == 1 ? linearTile<kModel, 1>(front, tile, fields, step, sums)
                         : linearTile<kModel, 3>(front, tile, fields, step, sums);
}

}  // namespace

void linearDispatched(const RayFront& front, const RayTile& tile, const ExchangeFields& fields,
                      const ExchangeStep& step, TileSums& sums) {
    step.model == ExchangeModel::paper ? linearChannels<ExchangeModel::paper>(front, tile, fields, step, sums)
                                       : linearChannels<ExchangeModel::consistent>(front, tile, fields, step, sums);
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(linearDispatched);

void exchangeLinear(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                    TileSums& sums) {
    HWY_DYNAMIC_DISPATCH(linearDispatched)(front, tile, fields, step, sums);
}

}  // namespace raysweep
#endif  // HWY_ONCE
