// The exchange between rays and voxels: Dachille, Mueller and Kaufman 2000, Algorithm 1, with the corrections of
// docs/illumination.md. Compiled once per instruction set; the best one that the machine has is chosen at run time.
#include "raysweep/sweep/exchange.h"

#include <algorithm>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/sweep/exchange.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<float, kBrickEdge>;
using Vec = hn::Vec<Lanes>;
using Mask = hn::Mask<Lanes>;
constexpr Lanes kLanes;

// Below this optical depth a voxel is as good as empty; it keeps alpha / tau from being 0 / 0.
constexpr float kThinnest = 1e-30f;

/// What a row of voxels does to any ray that passes it along the sweep's direction.
struct RowTerms {
    Vec opacity;      ///< alpha
    Vec shot;         ///< out / U
    Vec numerator;    ///< of the escape probability
    Vec denominator;
};

HWY_INLINE Vec polynomial(Vec t, float c1, float c2, float c3, float c4) {
    const Vec inner = hn::MulAdd(t, hn::Set(kLanes, c4), hn::Set(kLanes, c3));
    const Vec middle = hn::MulAdd(t, inner, hn::Set(kLanes, c2));
    return hn::MulAdd(t, hn::MulAdd(t, middle, hn::Set(kLanes, c1)), hn::Set(kLanes, 1.0f));
}

template <MediumExchange kModel>
HWY_INLINE RowTerms rowTerms(const ExchangeStep& step, Vec tau) {
    const Vec one = hn::Set(kLanes, 1.0f);
    const Vec along = hn::Max(hn::Mul(tau, hn::Set(kLanes, step.stepScale)), hn::Set(kLanes, kThinnest));
    RowTerms terms;
    terms.opacity = hn::Min(hn::Neg(hn::Expm1(kLanes, hn::Neg(along))), one);
    if (kModel == MediumExchange::paper) {
        terms.shot = hn::Set(kLanes, step.zeta);
        terms.numerator = terms.denominator = one;
        return terms;
    }
    const float* a = step.escape.a;
    const float* b = step.escape.b;
    terms.numerator = polynomial(tau, b[0], b[1], b[2], 0.0f);
    terms.denominator = polynomial(tau, a[0], a[1], a[2], a[3]);
    const Vec ratio = hn::Div(hn::Mul(terms.opacity, terms.denominator), hn::Mul(along, terms.numerator));
    terms.shot = hn::Min(hn::Mul(ratio, hn::Set(kLanes, step.zeta)), one);
    return terms;
}

/// g = albedo p / (1 - albedo (1 - p)) with p = n / d. Written without a difference of n and d: where p is below the
/// precision of a float, that would lose n and with it the power.
HWY_INLINE Vec effectiveAlbedo(const RowTerms& terms, Vec albedo) {
    const Vec scattered = hn::Mul(albedo, terms.numerator);
    const Vec absorbing = hn::Sub(hn::Set(kLanes, 1.0f), albedo);
    return hn::Div(scattered, hn::MulAdd(absorbing, terms.denominator, scattered));
}

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
};

/// Lanes [begin, end) of a row.
HWY_INLINE Mask lanesBetween(int lane, int begin, int end) {
    const Vec index = hn::Iota(kLanes, float(lane));
    return hn::And(hn::Ge(index, hn::Set(kLanes, float(begin))), hn::Lt(index, hn::Set(kLanes, float(end))));
}

/// Eight voxels of a slice and the eight rays at them. `rays` is the first channel's; the next are `raysStride` on.
/// With kClipped only lanes [begin, end) take part.
template <MediumExchange kModel, int kChannels, bool kClipped>
HWY_INLINE void exchangeRow(const ExchangeStep& step, const BrickRows& brick, int at, float* HWY_RESTRICT rays,
                            std::size_t raysStride, int begin, int end) {
    for (int lane = 0; lane < kBrickEdge; lane += int(hn::Lanes(kLanes))) {
        const Vec tau = hn::Load(kLanes, brick.tau + at + lane);
        RowTerms terms = rowTerms<kModel>(step, tau);
        Mask taking{};
        if (kClipped) {
            taking = lanesBetween(lane, begin, end);
            terms.opacity = hn::IfThenElseZero(taking, terms.opacity);
            terms.shot = hn::IfThenElseZero(taking, terms.shot);
        }
        for (int c = 0; c < kChannels; ++c) {
            float* const unshot = brick.unshot[c] + at + lane;
            float* const deposit = brick.deposit[c] + at + lane;
            float* const ray = rays + std::size_t(c) * raysStride + lane;
            const Vec e = hn::LoadU(kLanes, ray);
            const Vec U = hn::Load(kLanes, unshot);
            Vec added = hn::Load(kLanes, brick.source[c] + at + lane);
            if (kClipped) added = hn::IfThenElseZero(taking, added);
            const Vec g = effectiveAlbedo(terms, hn::Load(kLanes, brick.albedo[c] + at + lane));
            const Vec in = hn::Mul(e, terms.opacity);
            const Vec out = hn::Mul(U, terms.shot);
            const Vec newRay = hn::Add(hn::Sub(e, in), out);
            const Vec newUnshot = hn::MulAdd(g, in, hn::Add(hn::Sub(U, out), added));
            requireNonNegative(newRay);
            requireNonNegative(newUnshot);
            hn::Store(newUnshot, kLanes, unshot);
            hn::Store(hn::Add(hn::Load(kLanes, deposit), in), kLanes, deposit);
            hn::StoreU(newRay, kLanes, ray);
        }
    }
}

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void transposePlane(const float* HWY_RESTRICT from, float* HWY_RESTRICT to) {
    for (int i = 0; i < kBrickEdge; ++i)
        for (int j = 0; j < kBrickEdge; ++j) to[8 * i + j] = from[8 * j + i];
}
#else
/// 8x8 transpose in 4x4 blocks: to[8 i + j] = from[8 j + i].
HWY_INLINE void transposePlane(const float* HWY_RESTRICT from, float* HWY_RESTRICT to) {
    using Quad = hn::CappedTag<float, 4>;
    constexpr Quad quad;
    const hn::Repartition<double, Quad> pair;
    for (int i = 0; i < kBrickEdge; i += 4)
        for (int j = 0; j < kBrickEdge; j += 4) {
            const auto a = hn::Load(quad, from + 8 * (j + 0) + i), b = hn::Load(quad, from + 8 * (j + 1) + i);
            const auto c = hn::Load(quad, from + 8 * (j + 2) + i), d = hn::Load(quad, from + 8 * (j + 3) + i);
            const auto ab0 = hn::BitCast(pair, hn::InterleaveLower(quad, a, b));
            const auto ab1 = hn::BitCast(pair, hn::InterleaveUpper(quad, a, b));
            const auto cd0 = hn::BitCast(pair, hn::InterleaveLower(quad, c, d));
            const auto cd1 = hn::BitCast(pair, hn::InterleaveUpper(quad, c, d));
            hn::Store(hn::BitCast(quad, hn::InterleaveLower(pair, ab0, cd0)), quad, to + 8 * (i + 0) + j);
            hn::Store(hn::BitCast(quad, hn::InterleaveUpper(pair, ab0, cd0)), quad, to + 8 * (i + 1) + j);
            hn::Store(hn::BitCast(quad, hn::InterleaveLower(pair, ab1, cd1)), quad, to + 8 * (i + 2) + j);
            hn::Store(hn::BitCast(quad, hn::InterleaveUpper(pair, ab1, cd1)), quad, to + 8 * (i + 3) + j);
        }
}
#endif

/// Planes [first, last] of a brick; a plane is 64 values of one x.
HWY_INLINE void transposePlanes(const float* from, float* to, int first, int last) {
    for (int x = first; x <= last; ++x) transposePlane(from + 64 * x, to + 64 * x);
}

/// Copies of a brick's fields, transposed so that a z-slice has its rows (of y) contiguous.
template <int kChannels>
struct TransposedBrick {
    HWY_ALIGN float tau[kBrickVoxels];
    HWY_ALIGN float albedo[kChannels][kBrickVoxels];
    HWY_ALIGN float source[kChannels][kBrickVoxels];
    HWY_ALIGN float unshot[kChannels][kBrickVoxels];
    HWY_ALIGN float deposit[kChannels][kBrickVoxels];

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
        return rows;
    }

    void store(const BrickRows& to, int first, int last) const {
        for (int c = 0; c < kChannels; ++c) {
            transposePlanes(unshot[c], to.unshot[c], first, last);
            transposePlanes(deposit[c], to.deposit[c], first, last);
        }
    }
};

/// The energies of a tile's rays: rows padded on both sides by what a brick may overhang.
class TileRays {
  public:
    static constexpr int kPad = 16;

    TileRays(const RayTile& tile, int channels)
        : columns_(tile.columns.size()), rows_(tile.rows.size()), stride_(std::size_t(columns_ + 2 * kPad)),
          plane_(stride_ * std::size_t(rows_)), energy_(plane_ * std::size_t(channels), 0.0f) {}

    float* row(int row) { return energy_.data() + std::size_t(row) * stride_ + kPad; }
    int columns() const { return columns_; }
    int rows() const { return rows_; }
    std::size_t planeStride() const { return plane_; }

    /// Gives every ray that enters the volume its power; counts them.
    void enter(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
               TileSums& sums) {
        for (int r = 0; r < rows_; ++r) {
            const RayRange enters = raysThatEnter(front, tile.rows.begin + r);
            const int begin = std::max(enters.begin - tile.columns.begin, 0);
            const int end = std::min(enters.end - tile.columns.begin, columns_);
            if (end <= begin) continue;
            sums.rays += end - begin;
            for (int c = 0; c < fields.channels; ++c) {
                float* const rays = row(r) + std::size_t(c) * plane_;
                std::fill(rays + begin, rays + end, step.entering[c]);
            }
        }
        if (fields.arriving) arrive(front, tile, *fields.arriving, sums);
    }

    void leave(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, TileSums& sums) {
        if (fields.leaving) goOn(front, tile, *fields.leaving);
        for (int c = 0; c < fields.channels; ++c)
            for (int r = 0; r < rows_; ++r) {
                const float* const rays = row(r) + std::size_t(c) * plane_;
                double sum = 0;
                for (int u = 0; u < columns_; ++u) sum += double(rays[u]);
                sums.escaped[c] += sum;
            }
    }

  private:
    /// Rays that were inside in the slice before the first come from the repetition before.
    void arrive(const RayFront& front, const RayTile& tile, CrossingRays& arriving, TileSums& sums) {
        const auto inBoth = [&](const Lateral& lateral, const RayRange& ofTile) {
            const RayRange before = raysInside(front, lateral, -1), now = raysInside(front, lateral, 0);
            return RayRange{std::max({before.begin, now.begin, ofTile.begin}),
                            std::min({before.end, now.end, ofTile.end})};
        };
        const RayRange columns = inBoth(front.column, tile.columns), rows = inBoth(front.row, tile.rows);
        for (int r = rows.begin; r < rows.end; ++r) {
            sums.rays -= columns.size();
            for (int c = 0; c < arriving.channels; ++c)
                for (int u = columns.begin; u < columns.end; ++u)
                    row(r - tile.rows.begin)[std::size_t(c) * plane_ + std::size_t(u - tile.columns.begin)] =
                        arriving.at(c, r, u);
        }
    }

    /// Hands over the rays that are inside in the slice after the last.
    void goOn(const RayFront& front, const RayTile& tile, CrossingRays& leaving) {
        for (int r = 0; r < rows_; ++r) {
            const int rowThere = rayInNextRepetition(front, front.row, tile.rows.begin + r);
            if (rowThere < leaving.rows.begin || rowThere >= leaving.rows.end) continue;
            for (int u = 0; u < columns_; ++u) {
                const int there = rayInNextRepetition(front, front.column, tile.columns.begin + u);
                if (there < leaving.columns.begin || there >= leaving.columns.end) continue;
                for (int c = 0; c < leaving.channels; ++c) {
                    float& ray = row(r)[std::size_t(c) * plane_ + std::size_t(u)];
                    leaving.at(c, rowThere, there) = ray;
                    ray = 0;
                }
            }
        }
    }

    int columns_, rows_;
    std::size_t stride_, plane_;
    std::vector<float> energy_;
};

/// How the eight slices of a visited brick lie over a tile's rays, in the order of travel.
struct Overlap {
    int slice[kBrickEdge];              ///< slice of the brick
    int column[kBrickEdge];             ///< tile column of the ray at the slice's first column
    int row[kBrickEdge];                ///< tile row of the ray at the slice's first row
    int firstRow = kBrickEdge, lastRow = -1;  ///< rows of the brick met in any slice
    bool clipped = false;               ///< some column lies outside the tile

    Overlap(const RayFront& front, const RayTile& tile, const BrickVisit& visit) {
        const int columns = tile.columns.size(), rows = tile.rows.size();
        for (int j = 0; j < kBrickEdge; ++j) {
            slice[j] = front.ascending ? j : kBrickEdge - 1 - j;
            column[j] = visit.column - front.column.shift(visit.step + j) - tile.columns.begin;
            row[j] = visit.row - front.row.shift(visit.step + j) - tile.rows.begin;
            clipped = clipped || column[j] < front.reach || column[j] + kBrickEdge > columns;
            firstRow = std::min(firstRow, std::max(0, -row[j]));
            lastRow = std::max(lastRow, std::min(kBrickEdge, rows - row[j] + front.reach) - 1);
        }
        firstRow = std::max(0, firstRow);
    }

    bool missesColumns(int j, int columns, int reach) const {
        return column[j] + kBrickEdge <= 0 || column[j] - reach >= columns;
    }
};

template <MediumExchange kModel, int kChannels>
HWY_INLINE void exchangeBrick(const RayFront& front, const Overlap& overlap, const ExchangeStep& step,
                              const BrickRows& brick, TileRays& rays) {
    const int columns = rays.columns();
    for (int j = 0; j < kBrickEdge; ++j) {
        if (overlap.missesColumns(j, columns, 0)) continue;
        const int column = overlap.column[j], row = overlap.row[j];
        const int first = std::max(0, -row), last = std::min(kBrickEdge, rays.rows() - row) - 1;
        int at = overlap.slice[j] * front.axis.sliceStride + first * front.axis.rowStride;
        for (int r = first; r <= last; ++r, at += front.axis.rowStride) {
            float* const ray = rays.row(row + r) + column;
            if (overlap.clipped)
                exchangeRow<kModel, kChannels, true>(step, brick, at, ray, rays.planeStride(), -column, columns - column);
            else
                exchangeRow<kModel, kChannels, false>(step, brick, at, ray, rays.planeStride(), 0, kBrickEdge);
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
    return rows;
}

template <MediumExchange kModel, int kChannels>
void nearestTile(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                 TileSums& sums) {
    TileRays rays(tile, kChannels);
    rays.enter(front, tile, fields, step, sums);
    TransposedBrick<kChannels> transposed;
    for (const BrickVisit* visit = tile.begin; visit != tile.end; ++visit) {
        const Overlap overlap(front, tile, *visit);
        if (overlap.lastRow < overlap.firstRow) continue;
        const BrickRows brick = brickRows<kChannels>(fields, visit->brick);
        if (!front.axis.transposed) {
            exchangeBrick<kModel, kChannels>(front, overlap, step, brick, rays);
            continue;
        }
        const int first = overlap.firstRow, last = overlap.lastRow;
        const BrickRows turned =
            transposed.load(brick, fields.albedo[0].stride == 0, fields.source[0].stride == 0, first, last);
        exchangeBrick<kModel, kChannels>(front, overlap, step, turned, rays);
        transposed.store(brick, first, last);
    }
    rays.leave(front, tile, fields, sums);
}

// ---- linear -------------------------------------------------------------------------------------------------------

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
void settle(const ExchangeFields& fields, const ExchangeStep& step, std::size_t b) {
    for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes))) {
        const RowTerms terms = rowTerms<kModel>(step, hn::Load(kLanes, fields.tau.brick(b) + i));
        for (int c = 0; c < fields.channels; ++c) {
            float* const unshot = fields.unshot[c].brick(b) + i;
            float* const deposit = fields.deposit[c].brick(b) + i;
            float* const fresh = fields.fresh[c].brick(b) + i;
            const Vec U = hn::Load(kLanes, unshot), in = hn::Load(kLanes, fresh);
            const Vec g = effectiveAlbedo(terms, hn::Load(kLanes, fields.albedo[c].brick(b) + i));
            const Vec added = hn::Load(kLanes, fields.source[c].brick(b) + i);
            const Vec left = hn::Sub(U, hn::Mul(U, terms.shot));
            hn::Store(hn::MulAdd(g, in, hn::Add(left, added)), kLanes, unshot);
            hn::Store(hn::Add(hn::Load(kLanes, deposit), in), kLanes, deposit);
            hn::Store(hn::Zero(kLanes), kLanes, fresh);
        }
    }
}

// ---- one entry per instruction set --------------------------------------------------------------------------------

template <MediumExchange kModel>
void nearestChannels(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                     TileSums& sums) {
    fields.channels == 1 ? nearestTile<kModel, 1>(front, tile, fields, step, sums)
                         : nearestTile<kModel, 3>(front, tile, fields, step, sums);
}

template <MediumExchange kModel>
void linearChannels(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                    TileSums& sums) {
    fields.channels == 1 ? linearTile<kModel, 1>(front, tile, fields, step, sums)
                         : linearTile<kModel, 3>(front, tile, fields, step, sums);
}

}  // namespace

void nearestDispatched(const RayFront& front, const RayTile& tile, const ExchangeFields& fields,
                       const ExchangeStep& step, TileSums& sums) {
    step.model == MediumExchange::paper ? nearestChannels<MediumExchange::paper>(front, tile, fields, step, sums)
                                        : nearestChannels<MediumExchange::consistent>(front, tile, fields, step, sums);
}

void linearDispatched(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                      TileSums& sums) {
    step.model == MediumExchange::paper ? linearChannels<MediumExchange::paper>(front, tile, fields, step, sums)
                                        : linearChannels<MediumExchange::consistent>(front, tile, fields, step, sums);
}

void settleDispatched(const ExchangeFields& fields, const ExchangeStep& step, std::size_t b) {
    step.model == MediumExchange::paper ? settle<MediumExchange::paper>(fields, step, b)
                                        : settle<MediumExchange::consistent>(fields, step, b);
}

void effectiveAlbedosDispatched(const ExchangeStep& step, const float* tau, const float* albedo, float* g) {
    for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes))) {
        const Vec depth = hn::Load(kLanes, tau + i);
        const RowTerms terms = step.model == MediumExchange::paper ? rowTerms<MediumExchange::paper>(step, depth)
                                                                   : rowTerms<MediumExchange::consistent>(step, depth);
        hn::Store(effectiveAlbedo(terms, hn::Load(kLanes, albedo + i)), kLanes, g + i);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(nearestDispatched);
HWY_EXPORT(linearDispatched);
HWY_EXPORT(settleDispatched);
HWY_EXPORT(effectiveAlbedosDispatched);

void exchangeNearest(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                     TileSums& sums) {
    HWY_DYNAMIC_DISPATCH(nearestDispatched)(front, tile, fields, step, sums);
}

void exchangeLinear(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                    TileSums& sums) {
    HWY_DYNAMIC_DISPATCH(linearDispatched)(front, tile, fields, step, sums);
}

void settleBrick(const ExchangeFields& fields, const ExchangeStep& step, std::size_t b) {
    HWY_DYNAMIC_DISPATCH(settleDispatched)(fields, step, b);
}

void effectiveAlbedos(MediumExchange model, const EscapeFit& escape, const float* tau, const float* albedo, float* g) {
    ExchangeStep step;
    step.model = model;
    step.escape = escape;
    HWY_DYNAMIC_DISPATCH(effectiveAlbedosDispatched)(step, tau, albedo, g);
}

}  // namespace raysweep
#endif  // HWY_ONCE
