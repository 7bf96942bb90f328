// Rays go through the volume in parallel, each leaving its samples' shares, which a piece of rays puts into the order
// of layers of bricks across the major axis: composite_spread.cpp adds them to voxels.
#include "raysweep/projector/composite.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/projector/composite_ray.h"
#include "raysweep/projector/composite_spread.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/projector/composite.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/composite_sampler-inl.h"

#include <hwy/contrib/math/math-inl.h>

#ifndef RAYSWEEP_COMPOSITE_ONCE
#define RAYSWEEP_COMPOSITE_ONCE
namespace raysweep {

/// What a thread keeps of the samples of its rays between compositing and derivative.
struct SampleRoom {
    std::vector<CompositeVoxel> samples;
    std::vector<float> transmittances;  ///< before each sample, and behind the last: one more for each ray
    std::vector<std::uint16_t> numbers;
    std::vector<std::uint32_t> firsts;       ///< sample of each ray, and the end
    std::vector<SampleShare> shares;         ///< what each is given
    std::vector<CompositeTape::Run> runs;    ///< ray after ray
    std::vector<CompositeTape::Part> parts;  ///< of each layer

    void reserve(const CompositeRay* rays, std::size_t count) {
        runs.clear();
        std::size_t most = 0;
        for (std::size_t r = 0; r < count; ++r) most += std::size_t(rays[r].count) + 8;
        if (samples.size() >= most && firsts.size() > count) return;
        samples.resize(most);
        transmittances.resize(most + count);
        numbers.resize(most);
        firsts.resize(count + 1);
        shares.resize(most);
    }
};

/// Layer of bricks that holds a slice, counted from the one around the volume.
inline int layerOf(int slice) {
    return (slice >> 3) + 1;
}

}  // namespace raysweep
#endif

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// What follows from the samples of one ray, front to back.
class FrontToBack {
  public:
    FrontToBack() : color_(setFour(0)) {}

    /// Takes `count` <= kChunk samples into account. @return how many, fewer if too little comes through
    HWY_INLINE int add(const CompositeVoxel* HWY_RESTRICT samples, float* HWY_RESTRICT transmittances, int count,
                       float length) {
        HWY_ALIGN float through[kChunk];  // what one sample leaves; of those behind `count` anything
        const auto four = hn::ShiftLeft<2>(hn::Iota(kWhole, 0));
        for (std::size_t i = 0; i < kChunk; i += hn::Lanes(kLanes)) {
            const auto extinction = hn::GatherIndex(kLanes, &samples[i].extinction, four);
            hn::Store(hn::Exp(kLanes, hn::Mul(hn::Set(kLanes, -length), extinction)), kLanes, through + i);
        }
        for (int i = 0; i < count; ++i) {
            const float behind = transmittance_ * through[i];
            transmittances[i] = transmittance_;
            color_ = mulAdd(setFour(transmittance_ - behind), load(samples + i), color_);
            transmittance_ = behind;
            if (behind < kLeastTransmittance) {
                count = i + 1;
                ended_ = true;
            }
        }
        transmittances[count] = transmittance_;
        return count;
    }

    bool ended() const { return ended_; }

    HWY_INLINE void store(RayColor& to) const {
        storeFour(color_, &to.transmittance);
        to.transmittance = transmittance_;
    }

  private:
    Four color_;
    float transmittance_ = 1;
    bool ended_ = false;
};

/// Notes a ray's runs.
class RunWriter {
  public:
    RunWriter(std::vector<CompositeTape::Run>& runs, std::size_t ray) : runs_(runs) {
        run_.ray = std::uint8_t(ray);
        run_.count = 0;
        run_.first = run_.layer = 0;
    }

    HWY_INLINE void add(int number, int slice) {
        const int layer = layerOf(slice);
        if (layer != run_.layer || number != run_.first + run_.count) {
            end();
            run_.first = std::uint16_t(number);
            run_.layer = std::uint16_t(layer);
            run_.count = 0;
        }
        ++run_.count;
    }

    HWY_INLINE void end() {
        if (run_.count > 0) runs_.push_back(run_);
    }

  private:
    std::vector<CompositeTape::Run>& runs_;
    CompositeTape::Run run_;
};

/// Places of a ray's samples, some at a time: when they are taken, the voxels of those behind them are asked for.
template <int kAxis>
class PlacesAhead {
  public:
    PlacesAhead(const CompositeLayout& layout, const CompositeVoxel* voxels, const CompositeRay& ray)
        : sampler_(layout), voxels_(voxels), ray_(ray) {}

    /// Places of sample `k` and those that follow it.
    HWY_INLINE const Places& from(int k) {
        if (next_ == k)
            taken_ = 1 - taken_;
        else
            find(k, places_[taken_]);
        next_ = k + kChunk;
        if (next_ < ray_.count) find(next_, places_[1 - taken_]);
        return places_[taken_];
    }

    HWY_INLINE bool isEmpty(const Places& places, int i) const { return sampler_.isEmpty(places.cell[i]); }

  private:
    HWY_INLINE void find(int k, Places& to) const {
        sampler_.locate(ray_, k, ray_.count - 1, to);
        sampler_.prefetch(voxels_, to, kChunk);
    }

    Sampler<kAxis> sampler_;
    const CompositeVoxel* voxels_;
    const CompositeRay& ray_;
    Places places_[2];
    int taken_ = 0;
    int next_ = -1;  ///< where the places begin that are not taken yet
};

/// One ray; its samples go to `room` from `first` on. @return where they end
template <int kAxis>
std::size_t compositeOne(const CompositeLayout& layout, const CompositeVoxel* HWY_RESTRICT voxels,
                         const CompositeRay& ray, SampleRoom& room, std::size_t first, float* transmittances,
                         RunWriter runs, RayColor& color) {
    const CellWalk walk(layout, ray);
    PlacesAhead<kAxis> ahead(layout, voxels, ray);
    FrontToBack light;
    std::size_t n = first;
    transmittances[0] = 1;
    for (int k = 0; k < ray.count && !light.ended();) {
        const int next = walk.next(k);
        if (next != k) {
            k = next;
            continue;
        }
        const Places& places = ahead.from(k);
        const int most = std::min(kChunk, ray.count - k);
        int count = 0;
        do {
            storeFour(sampleAt<kAxis>(voxels, places, count), &room.samples[n + std::size_t(count)].extinction);
            ++count;
        } while (count < most && !ahead.isEmpty(places, count));
        const int used = light.add(&room.samples[n], transmittances + (n - first), count, ray.length);
        for (int i = 0; i < used; ++i) {
            room.numbers[n + std::size_t(i)] = std::uint16_t(k + i);
            runs.add(k + i, places.slice[i]);
        }
        n += std::size_t(used);
        k += count;
    }
    runs.end();
    light.store(color);
    return n;
}

/// Eq. 2 for one ray of `count` samples, back to front.
void differentiateOne(const CompositeVoxel* HWY_RESTRICT samples, const float* HWY_RESTRICT transmittances,
                      std::size_t count, float length, const RayColor& derivative, SampleShare* HWY_RESTRICT to) {
    const Four zero = setFour(0), all = load(derivative);
    const Four summed = firstOf(setFour(1), all);  // 1, dL/dC
    // Σ_j>i T_j (1 − exp(−τ_j)) c_j, and in the first lane T dL/dT.
    Four behind = firstOf(all * setFour(transmittances[count]), zero);
    for (std::size_t i = count; i-- > 0;) {
        const Four color = firstOf(zero, load(samples + i));
        const float weight = transmittances[i] - transmittances[i + 1];
        const Four change = mulSub(setFour(transmittances[i + 1]), color, behind);
        to[i] = {sumOf(summed * change) * length, weight};
        behind = mulAdd(setFour(weight), color, behind);
    }
}

}  // namespace

void compositeDispatched(const CompositeLayout& layout, const CompositeVoxel* voxels, const CompositeRay* rays,
                         std::size_t count, SampleRoom& room, RayColor* colors) {
    room.reserve(rays, count);
    const auto one = [](int axis) {
        return axis == 0 ? compositeOne<0> : (axis == 1 ? compositeOne<1> : compositeOne<2>);
    };
    std::size_t n = 0;
    for (std::size_t r = 0; r < count; ++r) {
        room.firsts[r] = std::uint32_t(n);
        n = one(rays[r].axis)(layout, voxels, rays[r], room, n, room.transmittances.data() + n + r,
                              RunWriter(room.runs, r), colors[r]);
    }
    room.firsts[count] = std::uint32_t(n);
}

void differentiateDispatched(const CompositeRay* rays, std::size_t count, SampleRoom& room,
                             const RayColor* derivatives) {
    for (std::size_t r = 0; r < count; ++r) {
        const std::size_t first = room.firsts[r];
        differentiateOne(room.samples.data() + first, room.transmittances.data() + first + r,
                         room.firsts[r + 1] - first, rays[r].length, derivatives[r], room.shares.data() + first);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(compositeDispatched);
HWY_EXPORT(differentiateDispatched);

namespace {

/// Puts a piece's samples, which are in the order of rays, into that of layers.
void keep(SampleRoom& room, std::size_t layers, CompositeTape& tape, std::size_t number) {
    CompositeTape::Piece& piece = tape.pieces[number];
    std::vector<CompositeTape::Part>& parts = room.parts;  // how much, and then where the next goes
    parts.assign(layers, {});
    for (const CompositeTape::Run& run : room.runs) {
        parts[run.layer].share += run.count;
        ++parts[run.layer].end;
    }
    std::uint32_t share = 0, run = 0;
    for (std::size_t layer = 0; layer < layers; ++layer) {
        const CompositeTape::Part count = parts[layer];
        parts[layer] = {share, run, run};
        share += count.share;
        run += count.end;
        tape.parts[layer * tape.pieces.size() + number] = {parts[layer].share, parts[layer].run, run};
    }
    piece.used = share;
    if (piece.shares.size() < share) piece.shares.resize(share);
    if (piece.runs.size() < run) piece.runs.resize(run);
    const SampleShare* from = room.shares.data();
    for (const CompositeTape::Run& one : room.runs) {
        CompositeTape::Part& to = parts[one.layer];
        piece.runs[to.end++] = one;
        std::copy_n(from, one.count, piece.shares.data() + to.share);
        to.share += one.count;
        from += one.count;
    }
}

/// Sets the shares of a piece's samples, and what its rays share.
using PieceRule = std::function<void(std::size_t first, std::size_t count, SampleRoom& room, RayColor* shared)>;

/// Those of ray `r` of a piece.
RaySamples samplesOf(const SampleRoom& room, std::size_t r, const CompositeRay& ray, const RayColor& color) {
    const std::size_t begin = room.firsts[r];
    return {ray,
            color,
            room.samples.data() + begin,
            room.transmittances.data() + begin + r,
            room.numbers.data() + begin,
            room.firsts[r + 1] - begin};
}

/// All rays forth, and what `rule` makes of their samples back.
void traceAndSpread(const CompositeLayout& layout, const CompositeVoxel* voxels, const std::vector<CompositeRay>& rays,
                    const PieceRule& rule, CompositeTape& tape, CompositeVoxel* sums) {
    for (std::size_t r = 1; r < rays.size(); ++r)
        if (rays[r].axis < rays[r - 1].axis)
            throw InvalidArgument("rays must be in the order of their major axes; sort them");
    const std::size_t pieces = (rays.size() + kRaysTogether - 1) / kRaysTogether;
    const std::size_t layers = std::size_t(std::max({layout.tableDims.x, layout.tableDims.y, layout.tableDims.z}));
    tape.pieces.resize(pieces);
    tape.parts.resize(layers * pieces);
    tape.colors.resize(rays.size());
    tape.shared.resize(rays.size());
    parallelFor(pieces, [&](std::size_t piece) {
        thread_local SampleRoom room;
        const std::size_t first = piece * kRaysTogether, count = std::min(kRaysTogether, rays.size() - first);
        HWY_DYNAMIC_DISPATCH(compositeDispatched)
        (layout, voxels, rays.data() + first, count, room, tape.colors.data() + first);
        rule(first, count, room, tape.shared.data() + first);
        keep(room, layers, tape, piece);
    });
    tape.samples = 0;
    for (const CompositeTape::Piece& piece : tape.pieces) tape.samples += piece.used;
    spreadShares(layout, rays, tape, sums);
}

}  // namespace

void composite(const CompositeLayout& layout, const CompositeVoxel* voxels, const CompositeRay* rays, std::size_t count,
               RayColor* colors) {
    parallelFor((count + kRaysTogether - 1) / kRaysTogether, [&](std::size_t piece) {
        thread_local SampleRoom room;
        const std::size_t first = piece * kRaysTogether;
        HWY_DYNAMIC_DISPATCH(compositeDispatched)
        (layout, voxels, rays + first, std::min(kRaysTogether, count - first), room, colors + first);
    });
}

void compositeGradient(const CompositeLayout& layout, const CompositeVoxel* voxels,
                       const std::vector<CompositeRay>& rays, const RayLoss& loss, CompositeTape& tape,
                       CompositeVoxel* gradient) {
    const auto rule = [&](std::size_t first, std::size_t count, SampleRoom& room, RayColor* derivatives) {
        loss(first, count, tape.colors.data() + first, derivatives);
        HWY_DYNAMIC_DISPATCH(differentiateDispatched)(rays.data() + first, count, room, derivatives);
    };
    traceAndSpread(layout, voxels, rays, rule, tape, gradient);
}

void compositeSamples(const CompositeLayout& layout, const CompositeVoxel* voxels,
                      const std::vector<CompositeRay>& rays, const SampleVisitor& visit) {
    parallelFor((rays.size() + kRaysTogether - 1) / kRaysTogether, [&](std::size_t piece) {
        thread_local SampleRoom room;
        const std::size_t first = piece * kRaysTogether, count = std::min(kRaysTogether, rays.size() - first);
        RayColor colors[kRaysTogether];
        HWY_DYNAMIC_DISPATCH(compositeDispatched)
        (layout, voxels, rays.data() + first, count, room, colors);
        for (std::size_t r = 0; r < count; ++r) visit(first + r, samplesOf(room, r, rays[first + r], colors[r]));
    });
}

void compositeSpread(const CompositeLayout& layout, const CompositeVoxel* voxels, const std::vector<CompositeRay>& rays,
                     const SampleRule& rule, CompositeTape& tape, CompositeVoxel* sums) {
    const auto each = [&](std::size_t first, std::size_t count, SampleRoom& room, RayColor* shared) {
        for (std::size_t r = 0; r < count; ++r) {
            const std::array<float, 3> color =
                rule(first + r, samplesOf(room, r, rays[first + r], tape.colors[first + r]),
                     room.shares.data() + room.firsts[r]);
            shared[r] = {0, color[0], color[1], color[2]};
        }
    };
    traceAndSpread(layout, voxels, rays, each, tape, sums);
}

}  // namespace raysweep
#endif  // HWY_ONCE
