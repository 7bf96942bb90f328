#include "raysweep/illuminate/coarse_level.h"

#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/estimate.h"

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
    const BrickLayout& layout = fine.volume.layout;
    const Index3 first = (layout.origins[b] - layout.low) / kFactor - state.volume.layout.origins[parents_[b]];
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
    : state(coarseLayout(fine.volume.layout, std::move(coarse)), {false, false, false}, fine.escape.scaled(kFactor)) {
    state.exchange = fine.exchange;
    state.channels = fine.channels;
    state.powerUnit = fine.powerUnit;
    state.perInjection = fine.perInjection;
    state.uniformAlbedo = fine.uniformAlbedo;
    const std::vector<Index3>& origins = fine.volume.layout.origins;
    for (const Index3& origin : origins)
        parents_.push_back(state.volume.map.find(coarseOrigin(fine.volume.layout, origin)));

    const std::size_t bricks = state.volume.layout.brickCount();
    state.zero = BrickField(1);
    state.tau = BrickField(bricks);
    for (int c = 0; c < state.channels; ++c) {
        state.albedo[c] = BrickField(fine.uniformAlbedo ? 1 : bricks);
        if (fine.uniformAlbedo) std::copy_n(fine.albedo[c].brick(0), kBrickVoxels, state.albedo[c].brick(0));
        if (fine.hasSource()) state.source[c] = BrickField(bricks);
        started_[c] = BrickField(bricks);
        changeDeposit_[c] = BrickField(bricks);
        changeUnshot_[c] = BrickField(bricks);
    }
    parallelFor(
        origins.size(),
        [&](std::size_t b) {
            const std::uint32_t parent = parents_[b];
            const float* const tau = fine.tau.brick(b);
            forEachCoarseVoxel(fine, b, [&](const int(&voxels)[kMerged], int j) {
                float sum = 0;
                for (const int i : voxels) sum += tau[i];
                state.tau.brick(parent)[j] = coarseDepth(tau, voxels);
                for (int c = 0; c < state.channels; ++c)
                    for (const int i : voxels) {
                        if (fine.hasSource()) state.source[c].brick(parent)[j] += fine.source[c].brick(b)[i];
                        if (!fine.uniformAlbedo && sum > 0)
                            state.albedo[c].brick(parent)[j] += fine.albedo[c].brick(b)[i] * tau[i] / sum;
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
            absorbingAreas(fine, b, area);
            absorbingAreas(state, parent, coarseArea);
            for (int c = 0; c < fine.channels; ++c) {
                effectiveAlbedos(fine, c, b, g);
                const float* const total = state.total[c].brick(parent);
                const float* const recent = state.recent[c].brick(parent);
                float* const unshot = fine.unshot[c].brick(b);
                forEachVoxel(fine, b, [&](int i, int j) {
                    double arriving = 0;
                    if (coarseArea[j] > 0)
                        arriving = (double(total[j]) + double(recent[j])) / std::max(1, state.injections) *
                                   double(area[i]) / double(coarseArea[j]) * double(g[i]);
                    if (fine.hasSource()) arriving += double(fine.source[c].brick(b)[i]);
                    unshot[i] = float(arriving / shot);
                    started_[c].brick(parent)[j] += unshot[i];
                });
            }
        },
        kGrain);
}

void CoarseLevel::takeChange(const SolverState& fine, int sign) {
    const std::size_t bricks = state.volume.layout.brickCount();
    for (int c = 0; c < state.channels; ++c) {
        state.unshot[c] = BrickField(bricks);
        state.total[c] = BrickField(bricks);
        state.recent[c] = BrickField(bricks);
        BrickField& change = state.unshot[c];
        parallelFor(
            parents_.size(),
            [&](std::size_t b) {
                forEachVoxel(fine, b,
                             [&](int i, int j) { change.brick(parents_[b])[j] += fine.unshot[c].brick(b)[i]; });
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
    state.swept = {};
}

void CoarseLevel::bookChange(int sign) {
    state.injections = 1;
    state.perInjection = {};
    const PowerBalance became = balance(state);
    for (int c = 0; c < state.channels; ++c) {
        changed_.absorbed[c] += sign * became.absorbed[c];
        changed_.escaped[c] += sign * became.escaped[c];
        changed_.unshot[c] += sign * became.unshot[c];
        parallelFor(
            state.volume.layout.brickCount(),
            [&](std::size_t b) {
                for (int i = 0; i < kBrickVoxels; ++i) {
                    const float deposit = state.total[c].brick(b)[i] + state.recent[c].brick(b)[i];
                    changeDeposit_[c].brick(b)[i] += float(sign) * deposit;
                    changeUnshot_[c].brick(b)[i] += float(sign) * state.unshot[c].brick(b)[i];
                }
            },
            kGrain);
    }
}

PowerBalance CoarseLevel::settle(SolverState& fine) {
    PowerBalance power = balance(fine);
    for (int c = 0; c < fine.channels; ++c) {
        power.absorbed[c] += changed_.absorbed[c] / fine.injections;
        power.escaped[c] += changed_.escaped[c] / fine.injections;
        // What is left of the change has either sign. Less than nothing cannot be unshot: it was not absorbed.
        const double left = changed_.unshot[c] / fine.injections;
        power.unshot[c] = std::max(0.0, left);
        power.absorbed[c] += std::min(0.0, left);
    }
    parallelFor(
        parents_.size(),
        [&](std::size_t b) {
            const std::uint32_t parent = parents_[b];
            alignas(64) float area[kBrickVoxels];
            absorbingAreas(fine, b, area);
            forEachCoarseVoxel(fine, b, [&](const int(&voxels)[kMerged], int j) {
                float sum = 0;
                for (const int i : voxels) sum += area[i];
                for (int c = 0; c < fine.channels; ++c)
                    for (const int i : voxels) {
                        const float part = sum > 0 ? area[i] / sum : 0;
                        fine.unshot[c].brick(b)[i] = std::max(0.0f, changeUnshot_[c].brick(parent)[j]) * part;
                        float& recent = fine.recent[c].brick(b)[i];
                        recent =
                            std::max(-fine.total[c].brick(b)[i], recent + changeDeposit_[c].brick(parent)[j] * part);
                    }
            });
        },
        kGrain);
    return power;
}

}  // namespace raysweep
