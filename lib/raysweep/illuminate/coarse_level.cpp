#include "raysweep/illuminate/coarse_level.h"

#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/power_balance.h"
#include "raysweep/illuminate/voxel_radiance.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace raysweep {
namespace {

constexpr int kFactor = 2, kMerged = kFactor * kFactor * kFactor;
constexpr int kGrain = 16;  ///< bricks

/// Of the coarse brick that holds a fine one. Coarse coordinates begin at the low corner of the fine bricks' bounding
/// box, so that the levels of a volume shrink wherever it lies.
Index3 coarseOrigin(const BrickLayout& fine, const Index3& origin) {
    return (origin - fine.low) / (kFactor * kBrickEdge) * kBrickEdge;
}

BrickLayout coarseLayout(const BrickLayout& fine, std::vector<Index3> origins) {
    BrickLayout coarse;
    coarse.origins = std::move(origins);
    coarse.low = coarse.high = coarse.origins.front();
    for (const Index3& origin : coarse.origins)
        for (int axis = 0; axis < 3; ++axis) {
            coarse.low[axis] = std::min(coarse.low[axis], origin[axis]);
            coarse.high[axis] = std::max(coarse.high[axis], origin[axis] + kBrickEdge);
        }
    coarse.worldFromIndex = fine.worldFromIndex * double(kFactor);
    coarse.voxelVolume = fine.voxelVolume * kMerged;
    coarse.activeVoxels = coarse.brickCount() * kBrickVoxels;
    return coarse;
}

/// Optical depth of the voxel that replaces eight: as much light as through these comes through it along an axis, on
/// average over the axes and the four ways along each. (With their mean extinction a coarse medium of thick and thin
/// voxels would be far too dense: light goes around the thick ones.)
/// @param voxels in the order (x, y, z)
float coarseDepth(const float* tau, const int (&voxels)[kMerged]) {
    constexpr int kWays = kMerged / kFactor, kAxes = 3;
    constexpr float kThin = 1e-3f;
    float least = tau[voxels[0]], most = least, sum = 0;
    for (const int i : voxels) {
        least = std::min(least, tau[i]);
        most = std::max(most, tau[i]);
        sum += tau[i];
    }
    const float mean = sum / float(kWays);
    if (most - least <= kThin) return mean;
    double through = 0;
    for (int stride = 1; stride < kMerged; stride *= kFactor)
        for (int n = 0; n < kMerged; ++n)
            if ((n & stride) == 0) through += std::exp(-double(tau[voxels[n]]) - double(tau[voxels[n + stride]]));
    through /= kWays * kAxes;
    return through > 0 ? std::min(mean, float(-std::log(through))) : mean;
}

void scale(BrickField& field, double factor) {
    parallelFor(
        field.brickCount(),
        [&](std::size_t b) {
            for (int i = 0; i < kBrickVoxels; ++i) field.brick(b)[i] = float(double(field.brick(b)[i]) * factor);
        },
        kGrain);
}

/// Takes power that is not there from what is unshot, then from what was absorbed, everywhere the same part; what is
/// more than both has not escaped.
void takeAway(SolverState& state, int c, double power) {
    const auto take = [&](double from, const std::vector<BrickField*>& fields) {
        const double taken = std::min(power, from);
        if (!(taken > 0)) return;
        for (BrickField* const field : fields) scale(*field, 1 - taken / from);
        power -= taken;
    };
    PowerFields& fields = state.power;
    take(unshotPower(state).value[c], {&fields.unshot[c]});
    take(absorbedPower(state).value[c], {&fields.total[c], &fields.recent[c]});
    fields.swept.escaped[c] -= power;
}

}  // namespace

std::vector<Index3> coarseOrigins(const BrickLayout& fine) {
    std::vector<Index3> origins;
    origins.reserve(fine.brickCount());
    for (const Index3& origin : fine.origins) origins.push_back(coarseOrigin(fine, origin));
    std::sort(origins.begin(), origins.end(), lessOrigin);
    origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
    return origins;
}

template <class Visit>
void CoarseLevel::forEachVoxel(const SolverState& fine, std::size_t b, const Visit& visit) const {
    const BrickLayout& layout = fine.medium.volume.layout;
    const Index3 first = (layout.origins[b] - layout.low) / kFactor - state.medium.volume.layout.origins[parents_[b]];
    for (int i = 0; i < kBrickVoxels; ++i) {
        const Index3 at(first.x + (i >> 6) / kFactor, first.y + ((i >> 3) & 7) / kFactor, first.z + (i & 7) / kFactor);
        visit(i, int(offsetInBrick(at)));
    }
}

template <class Visit>
void CoarseLevel::forEachCoarseVoxel(const SolverState& fine, std::size_t b, const Visit& visit) const {
    int voxels[kBrickVoxels / kMerged][kMerged], coarse[kBrickVoxels / kMerged];
    forEachVoxel(fine, b, [&](int i, int j) {
        const int x = i >> 6, y = (i >> 3) & 7, z = i & 7;
        const int cell = (x >> 1) << 4 | (y >> 1) << 2 | z >> 1;
        voxels[cell][(x & 1) << 2 | (y & 1) << 1 | (z & 1)] = i;
        coarse[cell] = j;
    });
    for (int cell = 0; cell < kBrickVoxels / kMerged; ++cell) visit(voxels[cell], coarse[cell]);
}

CoarseLevel::CoarseLevel(const SolverState& fine, std::vector<Index3> coarse)
    : state(coarseLayout(fine.medium.volume.layout, std::move(coarse)), {false, false, false},
            fine.medium.escape.scaled(kFactor)) {
    state.medium.model = fine.medium.model;
    state.medium.channels = fine.medium.channels;
    state.power.unit = fine.power.unit;
    state.power.perInjection = fine.power.perInjection;
    state.medium.uniformAlbedo = fine.medium.uniformAlbedo;
    const std::vector<Index3>& origins = fine.medium.volume.layout.origins;
    for (const Index3& origin : origins)
        parents_.push_back(state.medium.volume.map.find(coarseOrigin(fine.medium.volume.layout, origin)));

    const std::size_t bricks = state.medium.volume.layout.brickCount();
    state.power.zero = BrickField(1);
    state.medium.tau = BrickField(bricks);
    for (int c = 0; c < state.medium.channels; ++c) {
        state.medium.albedo[c] = BrickField(fine.medium.uniformAlbedo ? 1 : bricks);
        if (fine.medium.uniformAlbedo)
            std::copy_n(fine.medium.albedo[c].brick(0), kBrickVoxels, state.medium.albedo[c].brick(0));
        if (fine.power.hasSource()) state.power.source[c] = BrickField(bricks);
        started_[c] = BrickField(bricks);
        changeDeposit_[c] = BrickField(bricks);
        changeUnshot_[c] = BrickField(bricks);
    }
    parallelFor(
        origins.size(),
        [&](std::size_t b) {
            const std::uint32_t parent = parents_[b];
            const float* const tau = fine.medium.tau.brick(b);
            forEachCoarseVoxel(fine, b, [&](const int(&voxels)[kMerged], int j) {
                float sum = 0;
                for (const int i : voxels) sum += tau[i];
                state.medium.tau.brick(parent)[j] = coarseDepth(tau, voxels);
                for (int c = 0; c < state.medium.channels; ++c)
                    for (const int i : voxels) {
                        if (fine.power.hasSource())
                            state.power.source[c].brick(parent)[j] += fine.power.source[c].brick(b)[i];
                        if (!fine.medium.uniformAlbedo && sum > 0)
                            state.medium.albedo[c].brick(parent)[j] += fine.medium.albedo[c].brick(b)[i] * tau[i] / sum;
                    }
            });
        },
        kGrain);
}

void CoarseLevel::start(SolverState& fine, double shot) {
    parallelFor(
        parents_.size(),
        [&](std::size_t b) {
            const std::uint32_t parent = parents_[b];
            alignas(64) float area[kBrickVoxels], coarseArea[kBrickVoxels], g[kBrickVoxels];
            absorbingAreas(fine.medium, b, area);
            absorbingAreas(state.medium, parent, coarseArea);
            for (int c = 0; c < fine.medium.channels; ++c) {
                effectiveAlbedos(fine, c, b, g);
                const float* const total = state.power.total[c].brick(parent);
                const float* const recent = state.power.recent[c].brick(parent);
                float* const unshot = fine.power.unshot[c].brick(b);
                forEachVoxel(fine, b, [&](int i, int j) {
                    double arriving = 0;
                    if (coarseArea[j] > 0)
                        arriving = (double(total[j]) + double(recent[j])) / std::max(1, state.power.injections) *
                                   double(area[i]) / double(coarseArea[j]) * double(g[i]);
                    if (fine.power.hasSource()) arriving += double(fine.power.source[c].brick(b)[i]);
                    unshot[i] = float(arriving / shot);
                    started_[c].brick(parent)[j] += unshot[i];
                });
            }
        },
        kGrain);
}

void CoarseLevel::takeChange(const SolverState& fine, int sign) {
    const std::size_t bricks = state.medium.volume.layout.brickCount();
    for (int c = 0; c < state.medium.channels; ++c) {
        state.power.unshot[c] = BrickField(bricks);
        state.power.total[c] = BrickField(bricks);
        state.power.recent[c] = BrickField(bricks);
        BrickField& change = state.power.unshot[c];
        parallelFor(
            parents_.size(),
            [&](std::size_t b) {
                forEachVoxel(fine, b,
                             [&](int i, int j) { change.brick(parents_[b])[j] += fine.power.unshot[c].brick(b)[i]; });
            },
            kGrain);
        parallelFor(
            bricks,
            [&](std::size_t b) {
                float* const values = change.brick(b);
                for (int i = 0; i < kBrickVoxels; ++i)
                    values[i] = std::max(0.0f, float(sign) * (values[i] - started_[c].brick(b)[i]));
            },
            kGrain);
    }
    state.power.swept = {};
}

void CoarseLevel::rememberChange(int sign) {
    for (int c = 0; c < state.medium.channels; ++c) {
        escaped_.value[c] += sign * state.power.swept.escaped[c];
        parallelFor(
            state.medium.volume.layout.brickCount(),
            [&](std::size_t b) {
                const float* const total = state.power.total[c].brick(b);
                const float* const recent = state.power.recent[c].brick(b);
                const float* const unshot = state.power.unshot[c].brick(b);
                for (int i = 0; i < kBrickVoxels; ++i) {
                    changeDeposit_[c].brick(b)[i] += float(sign) * (total[i] + recent[i]);
                    changeUnshot_[c].brick(b)[i] += float(sign) * unshot[i];
                }
            },
            kGrain);
    }
}

/// A fine voxel's part of what its coarse one was given is that of an even field, its F. What has to be parted is
/// absorbed power and not the deposit: of a deposit 1 - g stays, and the g of a coarse voxel is not that of the fine
/// ones.
///
///     D_i += (1 - g_c) D_c F_i / sum_k (1 - g_k) F_k,     where nothing is absorbed D_i += D_c F_i / sum_k F_k
double CoarseLevel::settleBrick(SolverState& fine, int c, std::size_t b) const {
    const std::uint32_t parent = parents_[b];
    alignas(64) float area[kBrickVoxels];
    double share[kBrickVoxels], coarseShare[kBrickVoxels];
    absorbingAreas(fine.medium, b, area);
    absorbedShares(fine, c, b, share);
    absorbedShares(state, c, parent, coarseShare);
    const float* const total = fine.power.total[c].brick(b);
    float* const recent = fine.power.recent[c].brick(b);
    float* const unshot = fine.power.unshot[c].brick(b);
    double missing = 0;
    forEachCoarseVoxel(fine, b, [&](const int(&voxels)[kMerged], int j) {
        double sum = 0, absorbing = 0;
        for (const int i : voxels) {
            sum += double(area[i]);
            absorbing += double(area[i]) * share[i];
        }
        const double given = double(changeDeposit_[c].brick(parent)[j]),
                     left = double(changeUnshot_[c].brick(parent)[j]);
        const double perArea = absorbing > 0 ? given * coarseShare[j] / absorbing : sum > 0 ? given / sum : 0;
        missing += std::max(0.0, -left);
        for (const int i : voxels) {
            const double part = sum > 0 ? double(area[i]) / sum : 1.0 / kMerged;
            const double deposit = double(recent[i]) + perArea * double(area[i]), least = -double(total[i]);
            unshot[i] = float(std::max(0.0, left) * part);
            recent[i] = float(std::max(least, deposit));
            missing += std::max(0.0, least - deposit) * share[i];
        }
    });
    return missing;
}

void CoarseLevel::settle(SolverState& fine) const {
    const ChannelPower missing = orderedSum<ChannelPower>(
        parents_.size(),
        [&](std::size_t b) {
            ChannelPower sum;
            for (int c = 0; c < fine.medium.channels; ++c) sum.value[c] = settleBrick(fine, c, b);
            return sum;
        },
        kGrain);
    for (int c = 0; c < fine.medium.channels; ++c) {
        fine.power.swept.escaped[c] += escaped_.value[c];
        takeAway(fine, c, missing.value[c]);
    }
}

}  // namespace raysweep
