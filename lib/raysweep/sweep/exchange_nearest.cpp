// `nearest`: a voxel meets one ray. Dachille, Mueller and Kaufman 2000, Algorithm 1, with the corrections of
// docs/illumination.md. Compiled once per instruction set; the best one that the machine has is chosen at run time.
#include "raysweep/sweep/exchange.h"
#include "raysweep/sweep/tile_rays.h"

#include <hwy/cache_control.h>

#include <algorithm>

#include "raysweep/sweep/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/sweep/exchange_nearest.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/sweep/exchange_terms-inl.h"
#include "raysweep/sweep/transpose-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

using Mask = hn::Mask<Lanes>;

HWY_INLINE void requireNonNegative(Vec value) {
    (void)value;
    HWY_DASSERT(hn::AllTrue(kLanes, hn::Ge(value, hn::Zero(kLanes))));
}

/// Pointers to the 512 values of one brick, in the order of the sweep.
struct BrickRows {
    const float* tau;
    const float* albedo[kMaxChannels];
    const float* source[kMaxChannels];
    float* unshot[kMaxChannels];
    float* deposit[kMaxChannels];
    const PackedNormal* normals;  ///< null: no surfaces
    float* furnace;               ///< null: not measured
};

/// A row of rays, and what goes with it.
struct RayRow {
    float* HWY_RESTRICT power;  ///< of the first channel; the next are `stride` on
    std::size_t stride;
    float* HWY_RESTRICT furnace;  ///< f; null if not measured
    float* HWY_RESTRICT slice;    ///< in which they were in a solid last
    int begin, end;               ///< lanes that take part, where the row is clipped
};

/// Lanes [begin, end) of a row.
HWY_INLINE Mask lanesBetween(int lane, int begin, int end) {
    const Vec index = hn::Iota(kLanes, float(lane));
    return hn::And(hn::Ge(index, hn::Set(kLanes, float(begin))), hn::Lt(index, hn::Set(kLanes, float(end))));
}

/// Nothing there that could change a ray or be changed by one. In sparse volumes many rows of a brick are like this.
template <int kChannels>
HWY_INLINE bool isEmpty(const BrickRows& brick, int at, Vec tau) {
    Vec any = tau;
    for (int c = 0; c < kChannels; ++c)
        any = hn::Or(any, hn::Or(hn::Load(kLanes, brick.unshot[c] + at), hn::Load(kLanes, brick.source[c] + at)));
    return hn::AllTrue(kLanes, hn::Eq(any, hn::Zero(kLanes)));
}

/// Stores lanes [begin, end) of a row, or all if not clipped. The other lanes may be another tile's: they stay
/// untouched, and what was loaded from them is masked, whatever it was.
template <bool kClipped>
HWY_INLINE void storeOwn(Vec value, float* to, int lane, int begin, int end) {
    if (!kClipped) return hn::Store(value, kLanes, to + lane);
    HWY_ALIGN float values[kBrickEdge];
    const int count = int(hn::Lanes(kLanes));
    hn::Store(value, kLanes, values);
    for (int i = std::max(lane, begin); i < std::min(lane + count, end); ++i) to[i] = values[i - lane];
}

/// Local furnace of eight rays.
template <bool kClipped>
HWY_INLINE void exchangeFurnace(const ExchangeStep& step, Vec opacity, const RowSolids& solids, float* furnace,
                                const RayRow& rays, int lane, int slice) {
    const Vec last = hn::LoadU(kLanes, rays.slice + lane), now = hn::Set(kLanes, float(slice));
    const Mask close = hn::Ge(last, hn::Set(kLanes, float(slice - kSurfaceGap)));
    const Vec f = hn::IfThenElse(close, hn::LoadU(kLanes, rays.furnace + lane), hn::Set(kLanes, step.furnaceRay));
    const Vec in = hn::IfThenElseZero(solids.inside, hn::Mul(f, opacity));
    const Vec lastNow = hn::IfThenElse(solids.leaving, hn::Set(kLanes, kLongAgo), last);
    hn::StoreU(hn::Sub(f, in), kLanes, rays.furnace + lane);
    hn::StoreU(hn::IfThenElse(solids.inside, now, lastNow), kLanes, rays.slice + lane);
    storeOwn<kClipped>(hn::Add(hn::Load(kLanes, furnace + lane), in), furnace, lane, rays.begin, rays.end);
}

/// Eight voxels of a slice and the eight rays at them. With kClipped only lanes [begin, end) take part.
template <ExchangeModel kModel, int kChannels, bool kClipped, bool kSurfaces>
HWY_INLINE void exchangeRow(const ExchangeStep& step, const BrickRows& brick, int at, const RayRow& rays, int slice) {
    for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
        const Vec tau = hn::Load(kLanes, brick.tau + at + lane);
        if (isEmpty<kChannels>(brick, at + lane, tau)) continue;
        RowTerms terms = rowTerms<kModel>(step, tau);
        RowSolids solids;
        if (kSurfaces) solids = applySurfaces<kModel>(step, brick.normals + at + lane, tau, terms);
        if (kClipped) {
            const Mask taking = lanesBetween(lane, rays.begin, rays.end);
            terms.opacity = hn::IfThenElseZero(taking, terms.opacity);
            terms.shot = hn::IfThenElseZero(taking, terms.shot);
        }
        if (kSurfaces && rays.furnace)
            exchangeFurnace<kClipped>(step, terms.opacity, solids, brick.furnace + at, rays, lane, slice);
        for (int c = 0; c < kChannels; ++c) {
            float* const unshot = brick.unshot[c] + at;
            float* const deposit = brick.deposit[c] + at;
            float* const ray = rays.power + std::size_t(c) * rays.stride + lane;
            const Vec e = hn::LoadU(kLanes, ray);
            const Vec U = hn::Load(kLanes, unshot + lane);
            const Vec added = hn::Load(kLanes, brick.source[c] + at + lane);
            const Vec g = effectiveAlbedo(terms, hn::Load(kLanes, brick.albedo[c] + at + lane));
            const Vec in = hn::Mul(e, terms.opacity);
            const Vec out = hn::Mul(U, terms.shot);
            const Vec newRay = hn::Add(hn::Sub(e, in), out);
            const Vec newUnshot = hn::MulAdd(g, in, hn::Add(hn::Sub(U, out), added));
            requireNonNegative(newRay);
            requireNonNegative(newUnshot);
            storeOwn<kClipped>(newUnshot, unshot, lane, rays.begin, rays.end);
            storeOwn<kClipped>(hn::Add(hn::Load(kLanes, deposit + lane), in), deposit, lane, rays.begin, rays.end);
            hn::StoreU(newRay, kLanes, ray);
        }
    }
}

/// Copies of a brick's fields, transposed so that a z-slice has its rows (of y) contiguous.
template <int kChannels>
struct TransposedBrick {
    HWY_ALIGN float tau[kBrickVoxels];
    HWY_ALIGN float albedo[kChannels][kBrickVoxels];
    HWY_ALIGN float source[kChannels][kBrickVoxels];
    HWY_ALIGN float unshot[kChannels][kBrickVoxels];
    HWY_ALIGN float deposit[kChannels][kBrickVoxels];
    HWY_ALIGN PackedNormal normals[kBrickVoxels];
    HWY_ALIGN float furnace[kBrickVoxels];

    BrickRows load(const BrickRows& from, bool uniformAlbedo, bool uniformSource, int first, int last) {
        BrickRows rows = from;
        transposePlanes(from.tau, tau, first, last);
        rows.tau = tau;
        for (int c = 0; c < kChannels; ++c) {
            // One brick shared by all holds one value: it is its own transpose.
            if (!uniformAlbedo) {
                transposePlanes(from.albedo[c], albedo[c], first, last);
                rows.albedo[c] = albedo[c];
            }
            if (!uniformSource) {
                transposePlanes(from.source[c], source[c], first, last);
                rows.source[c] = source[c];
            }
            transposePlanes(from.unshot[c], unshot[c], first, last);
            transposePlanes(from.deposit[c], deposit[c], first, last);
            rows.unshot[c] = unshot[c];
            rows.deposit[c] = deposit[c];
        }
        if (from.normals) {
            transposePlanes(from.normals, normals, first, last);
            rows.normals = normals;
        }
        if (from.furnace) {
            transposePlanes(from.furnace, furnace, first, last);
            rows.furnace = furnace;
        }
        return rows;
    }

    /// Gives back what the tile's rays have met; the rest of the brick may be another tile's.
    void store(const BrickRows& to, const Overlap& overlap, int columns, int rows) const {
        for (int r = overlap.firstRow; r <= overlap.lastRow; ++r) {
            const bool whole = overlap.meetsWholeRow(r, rows);
            const auto storeRow = [&](const float* from, float* into) {
                if (whole)
                    transposePlane(from + 64 * r, into + 64 * r);
                else
                    storePart(from + 64 * r, into + 64 * r, overlap, r, columns, rows);
            };
            for (int c = 0; c < kChannels; ++c) {
                storeRow(unshot[c], to.unshot[c]);
                storeRow(deposit[c], to.deposit[c]);
            }
            if (to.furnace) storeRow(furnace, to.furnace);
        }
    }

    static void storePart(const float* plane, float* to, const Overlap& overlap, int r, int columns, int rows) {
        for (int j = 0; j < kBrickEdge; ++j) {
            if (overlap.row[j] + r < 0 || overlap.row[j] + r >= rows) continue;
            const int slice = overlap.slice[j], end = std::min(kBrickEdge, columns - overlap.column[j]);
            for (int lane = std::max(0, -overlap.column[j]); lane < end; ++lane)
                to[8 * lane + slice] = plane[8 * slice + lane];
        }
    }
};

/// Asks for an eighth of the brick that comes next: it will be here when its turn comes.
template <int kChannels>
HWY_INLINE void prefetchEighth(const BrickRows& now, const BrickRows& next, int j) {
    constexpr int kEighth = kBrickVoxels / kBrickEdge, kLine = 16;
    for (int i = j * kEighth; i < (j + 1) * kEighth; i += kLine) {
        hwy::Prefetch(next.tau + i);
        for (int c = 0; c < kChannels; ++c) {
            hwy::Prefetch(next.unshot[c] + i);
            hwy::Prefetch(next.deposit[c] + i);
            if (next.source[c] != now.source[c]) hwy::Prefetch(next.source[c] + i);
        }
    }
}

template <ExchangeModel kModel, int kChannels, bool kSurfaces>
HWY_INLINE void exchangeBrick(const RayFront& front, const Overlap& overlap, int firstStep, const ExchangeStep& step,
                              const BrickRows& brick, const BrickRows& next, TileRays& rays) {
    const int columns = rays.columns();
    for (int j = 0; j < kBrickEdge; ++j) {
        prefetchEighth<kChannels>(brick, next, j);
        if (overlap.missesColumns(j, columns, 0)) continue;
        const int column = overlap.column[j], row = overlap.row[j];
        const int first = std::max(0, -row), last = std::min(kBrickEdge, rays.rows() - row) - 1;
        int at = overlap.slice[j] * front.axis.sliceStride + first * front.axis.rowStride;
        for (int r = first; r <= last; ++r, at += front.axis.rowStride) {
            RayRow row8{rays.row(row + r) + column, rays.planeStride(), nullptr, nullptr, -column, columns - column};
            if (kSurfaces && brick.furnace) {
                row8.furnace = rays.furnaceRow(row + r) + column;
                row8.slice = rays.sliceRow(row + r) + column;
            }
            if (overlap.clipped)
                exchangeRow<kModel, kChannels, true, kSurfaces>(step, brick, at, row8, firstStep + j);
            else
                exchangeRow<kModel, kChannels, false, kSurfaces>(step, brick, at, row8, firstStep + j);
        }
    }
}

template <int kChannels>
HWY_INLINE BrickRows brickRows(const ExchangeFields& fields, std::size_t b) {
    BrickRows rows{};
    rows.tau = fields.tau.brick(b);
    for (int c = 0; c < kChannels; ++c) {
        rows.albedo[c] = fields.albedo[c].brick(b);
        rows.source[c] = fields.source[c].brick(b);
        rows.unshot[c] = fields.unshot[c].brick(b);
        rows.deposit[c] = fields.deposit[c].brick(b);
    }
    rows.normals = fields.surfaces ? fields.surfaces->normals(b) : nullptr;
    if (rows.normals && fields.furnace.data) rows.furnace = fields.furnace.brick(fields.surfaces->slots[b]);
    return rows;
}

template <ExchangeModel kModel, int kChannels>
void nearestTile(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                 TileSums& sums) {
    TileRays rays(tile, kChannels, fields.furnace.data != nullptr);
    rays.enter(front, tile, fields, step, sums);
    TransposedBrick<kChannels> transposed;
    const auto exchangeAll = [&](const Overlap& overlap, int firstStep, const BrickRows& brick, const BrickRows& next) {
        if (brick.normals)
            exchangeBrick<kModel, kChannels, true>(front, overlap, firstStep, step, brick, next, rays);
        else
            exchangeBrick<kModel, kChannels, false>(front, overlap, firstStep, step, brick, next, rays);
    };
    for (const BrickVisit* visit = tile.begin; visit != tile.end; ++visit) {
        const Overlap overlap(front, tile, *visit);
        if (overlap.lastRow < overlap.firstRow) continue;
        const BrickRows brick = brickRows<kChannels>(fields, visit->brick);
        const BrickRows next = brickRows<kChannels>(fields, (visit + 1 == tile.end ? visit : visit + 1)->brick);
        if (!front.axis.transposed) {
            exchangeAll(overlap, visit->step, brick, next);
            continue;
        }
        const int first = overlap.firstRow, last = overlap.lastRow;
        const BrickRows turned =
            transposed.load(brick, fields.albedo[0].stride == 0, fields.source[0].stride == 0, first, last);
        exchangeAll(overlap, visit->step, turned, next);
        transposed.store(brick, overlap, rays.columns(), rays.rows());
    }
    rays.leave(front, tile, fields, sums);
}

template <ExchangeModel kModel>
void nearestChannels(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                     TileSums& sums) {
    fields.channels == 1 ? nearestTile<kModel, 1>(front, tile, fields, step, sums)
                         : nearestTile<kModel, 3>(front, tile, fields, step, sums);
}

}  // namespace

void nearestDispatched(const RayFront& front, const RayTile& tile, const ExchangeFields& fields,
                       const ExchangeStep& step, TileSums& sums) {
    step.model == ExchangeModel::paper ? nearestChannels<ExchangeModel::paper>(front, tile, fields, step, sums)
                                       : nearestChannels<ExchangeModel::consistent>(front, tile, fields, step, sums);
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(nearestDispatched);

void exchangeNearest(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                     TileSums& sums) {
    HWY_DYNAMIC_DISPATCH(nearestDispatched)(front, tile, fields, step, sums);
}

}  // namespace raysweep
#endif  // HWY_ONCE
