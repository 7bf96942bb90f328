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
};

template <MediumExchange kModel, int kChannels>
HWY_INLINE void prepareLinear(const RayFront& front, const ExchangeFields& fields, const ExchangeStep& step,
                              std::size_t b, LinearBrick<kChannels>& brick) {
    HWY_ALIGN float opacity[kBrickVoxels];
    HWY_ALIGN float out[kChannels][kBrickVoxels];
    const bool turn = front.axis.transposed;
    float* const opacityTo = turn ? opacity : brick.opacity;
    for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes))) {
        const RowTerms terms = rowTerms<kModel>(step, hn::Load(kLanes, fields.tau.brick(b) + i));
        hn::Store(terms.opacity, kLanes, opacityTo + i);
        for (int c = 0; c < kChannels; ++c) {
            const Vec U = hn::Load(kLanes, fields.unshot[c].brick(b) + i);
            hn::Store(hn::Mul(U, terms.shot), kLanes, (turn ? out[c] : brick.out[c]) + i);
            hn::Store(hn::Zero(kLanes), kLanes, brick.in[c] + i);
        }
    }
    if (!turn) return;
    transposePlanes(opacity, brick.opacity, 0, kBrickEdge - 1);
    for (int c = 0; c < kChannels; ++c) transposePlanes(out[c], brick.out[c], 0, kBrickEdge - 1);
}

template <int kChannels>
HWY_INLINE void finishLinear(const RayFront& front, const ExchangeFields& fields, std::size_t b,
                             const LinearBrick<kChannels>& brick) {
    HWY_ALIGN float turned[kBrickVoxels];
    for (int c = 0; c < kChannels; ++c) {
        const float* in = brick.in[c];
        if (front.axis.transposed) {
            transposePlanes(in, turned, 0, kBrickEdge - 1);
            in = turned;
        }
        float* const fresh = fields.fresh[c].brick(b);
        for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes)))
            hn::Store(hn::Add(hn::Load(kLanes, fresh + i), hn::Load(kLanes, in + i)), kLanes, fresh + i);
    }
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

/// Applies and clears the changes of the rays that slice j of a brick has met.
HWY_INLINE void applyChange(const Overlap& overlap, int j, int channels, TileRays& rays, TileRays& change) {
    const int firstColumn = std::max(0, overlap.column[j] - 1);
    const int endColumn = std::min(rays.columns(), overlap.column[j] + kBrickEdge);
    const int firstRow = std::max(0, overlap.row[j] - 1);
    const int endRow = std::min(rays.rows(), overlap.row[j] + kBrickEdge);
    for (int c = 0; c < channels; ++c)
        for (int row = firstRow; row < endRow; ++row) {
            float* const ray = rays.row(row) + std::size_t(c) * rays.planeStride();
            float* const delta = change.row(row) + std::size_t(c) * rays.planeStride();
            for (int u = firstColumn; u < endColumn; ++u) {
                // Weights that sum to 1 but for rounding can leave a dark ray at -1e-8 of what it carried.
                ray[u] = std::max(0.0f, ray[u] + delta[u]);
                delta[u] = 0;
            }
        }
}

template <MediumExchange kModel, int kChannels>
void linearTile(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                TileSums& sums) {
    TileRays rays(tile, kChannels), change(tile, kChannels);
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
            for (std::size_t i = 0; i < count; ++i) applyChange(overlaps[i], j, kChannels, rays, change);
        }
        for (std::size_t i = 0; i < count; ++i) finishLinear<kChannels>(front, fields, layer[i].brick, bricks[i]);
        layer = end;
    }
    rays.leave(front, tile, fields, sums);
}

template <MediumExchange kModel>
void linearChannels(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                    TileSums& sums) {
    fields.channels == 1 ? linearTile<kModel, 1>(front, tile, fields, step, sums)
                         : linearTile<kModel, 3>(front, tile, fields, step, sums);
}

}  // namespace

void linearDispatched(const RayFront& front, const RayTile& tile, const ExchangeFields& fields,
                      const ExchangeStep& step, TileSums& sums) {
    step.model == MediumExchange::paper ? linearChannels<MediumExchange::paper>(front, tile, fields, step, sums)
                                        : linearChannels<MediumExchange::consistent>(front, tile, fields, step, sums);
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
