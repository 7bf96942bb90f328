/// A ray through a lit volume, front to back: the sum in the head of render.h.
#pragma once

#include "raysweep/camera/camera.h"
#include "raysweep/render/block_steps.h"
#include "raysweep/render/cell_blocks.h"
#include "raysweep/render/render.h"
#include "raysweep/render/sampler.h"

#include <openvdb/math/DDA.h>
#include <openvdb/math/Ray.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace raysweep {

/// Smallest integer not below x; std::ceil is as slow as std::floor (sampler.h).
inline std::int64_t ceilToInt(double x) {
    const auto truncated = std::int64_t(x);
    return truncated + (double(truncated) < x);
}

inline openvdb::Vec3d toVdb(const Vec3& v) {
    return openvdb::Vec3d(v.x, v.y, v.z);
}
inline void add(Color& sum, float weight, float s) {
    sum += grey(weight * s);
}
inline void add(Color& sum, float weight, const openvdb::Vec3s& s) {
    sum += Color(s.x(), s.y(), s.z()) * weight;
}

/// A ray in a grid's index space: o + t d.
struct IndexLine {
    openvdb::Vec3d origin, direction;
    IndexLine(const openvdb::Mat4d& indexFromWorld, const openvdb::Vec3d& o, const openvdb::Vec3d& d)
        : origin(indexFromWorld.transform(o)), direction(indexFromWorld.transform3x3(d)) {}
    openvdb::Vec3d at(double t) const { return origin + direction * t; }
};

struct RenderVolume::Content {
    openvdb::FloatGrid::ConstPtr density;  // 0 where inactive
    openvdb::GridBase::ConstPtr radiosity;
    double extinctionScale = 1;
    openvdb::Mat4d densityFromWorld, radiosityFromWorld;
    CellBlocks blocks;          // of both grids if they share their voxels
    openvdb::CoordBBox bounds;  // of the blocks, exclusive at its upper end
};

/// What a ray has gathered so far.
struct RayState {
    Color radiance = grey(0);
    double transmittance = 1;
};

/// Follows rays one after another; owns what a thread needs for it. Blocks have `kChannels` values at a corner: one is
/// density alone, more are density and radiosity.
template <class RadiosityGrid, int kChannels>
class RayMarcher {
  public:
    RayMarcher(const RenderVolume::Content& volume, const RenderOptions& options)
        : volume_(volume),
          options_(options),
          density_(*volume.density),
          around_(*volume.density),
          radiosity_(static_cast<const RadiosityGrid&>(*volume.radiosity)),
          densities_(*volume.density),
          radiosities_(static_cast<const RadiosityGrid&>(*volume.radiosity)),
          numbers_(*volume.blocks.numbers) {}

    RayState follow(const Ray& ray) {
        RayState state;
        if (!start(ray)) return state;
        IndexRay segment = ray_;
        while (segment.valid()) {
            const auto span = hdda_.march(segment, numbers_);
            if (!span.valid() || !crossSpan(span.t0, span.t1, state)) break;
            // A nudge, so that rounding does not find the same end again.
            segment = ray_;
            segment.setTimes(std::min(span.t1 + openvdb::math::Delta<double>::value(), ray_.t1()), ray_.t1());
        }
        return state;
    }

  private:
    using IndexRay = openvdb::math::Ray<double>;

    /// Sets up the ray in index space, t being the length there, so that one step is the same number of voxels in
    /// every direction. @return false if the ray misses the volume.
    bool start(const Ray& ray) {
        if (volume_.bounds.empty()) return false;
        const openvdb::Vec3d origin = toVdb(ray.origin);
        openvdb::Vec3d direction = toVdb(ray.direction);
        worldPerIndex_ = 1 / volume_.densityFromWorld.transform3x3(direction).length();
        direction *= worldPerIndex_;
        line_ = IndexLine(volume_.densityFromWorld, origin, direction);
        radiosityLine_ = IndexLine(volume_.radiosityFromWorld, origin, direction);
        ray_ = IndexRay(line_.origin, line_.direction, 0.0);
        if (!ray_.clip(volume_.bounds)) return false;
        // Start over near the volume, a whole number of steps on: the samples stay where they are, but an eye far away
        // costs no digits.
        const double step = options_.step, skipped = std::floor(ray_.t0() / step) * step;
        for (int axis = 0; axis < 3; ++axis) perDirection_[axis] = 1 / line_.direction[axis];
        line_.origin = line_.at(skipped);
        radiosityLine_.origin = radiosityLine_.at(skipped);
        // OpenVDB's rays begin after 0.
        const double begin = std::max(ray_.t0() - skipped, openvdb::math::Delta<double>::value());
        ray_ = IndexRay(line_.origin, line_.direction, begin, ray_.t1() - skipped);
        stepDepth_ = float(volume_.extinctionScale * step * worldPerIndex_);
        nextStep_ = 0;
        return true;
    }

    /// Takes the steps that touch [t0,t1] and were not taken yet. @return false when the ray is as good as dark.
    bool crossSpan(double t0, double t1, RayState& state) {
        const auto end = ceilToInt(t1 / options_.step);
        std::int64_t k = std::max(nextStep_, std::int64_t(t0 / options_.step));
        nextStep_ = std::max(nextStep_, end);
        for (pending_ = 0; k < end;) {
            const openvdb::Vec3d p = line_.at(timeOf(k));
            const openvdb::Coord origin =
                openvdb::Coord(floorToInt(p.x()), floorToInt(p.y()), floorToInt(p.z())) & ~(kBlockCells - 1);
            const std::int64_t last = std::clamp(ceilToInt(leaves(origin) / options_.step - 0.5), k + 1, end);
            const float* const block = blockAt(origin);
            if (!(block ? crossBlock(block, origin, k, last, state) : takePending(k, state))) return false;
            k = last;
        }
        return takePending(end, state);
    }

    double timeOf(std::int64_t step) const { return (double(step) + 0.5) * options_.step; }

    /// Where the ray, now in the block at `origin`, leaves it.
    double leaves(const openvdb::Coord& origin) const {
        double t = ray_.t1() + options_.step;
        for (int axis = 0; axis < 3; ++axis) {
            const double d = line_.direction[axis];
            const double side = origin[axis] + (d > 0 ? kBlockCells : 0);
            if (d != 0) t = std::min(t, (side - line_.origin[axis]) * perDirection_[axis]);
        }
        return t;
    }

    /// Steps k to `end` lie in the block at `origin`. Steps are taken some dozens at a time: a block's own are so few
    /// that one operation would wait for the other.
    bool crossBlock(const float* block, const openvdb::Coord& origin, std::int64_t k, std::int64_t end,
                    RayState& state) {
        BlockSteps steps;
        for (int axis = 0; axis < 3; ++axis) steps.perStep[axis] = float(line_.direction[axis] * options_.step);
        while (k < end) {
            const openvdb::Vec3d p = line_.at(timeOf(k)) - origin.asVec3d();
            for (int axis = 0; axis < 3; ++axis) steps.first[axis] = float(p[axis]);
            steps.count = int(std::min<std::int64_t>(kMostSteps - pending_, end - k));
            sampleSteps<kChannels>(block, steps, values_ + pending_);
            pending_ += steps.count;
            k += steps.count;
            if (pending_ == kMostSteps && !takePending(k, state)) return false;
        }
        return true;
    }

    /// Takes the steps before step `end` whose values were found.
    bool takePending(std::int64_t end, RayState& state) {
        float opacities[kMostSteps];
        findOpacities<kChannels>(values_, pending_, stepDepth_, opacities);
        RayState now = state;  // in registers
        bool on = true;
        const std::int64_t first = end - pending_;
        for (int i = 0; i < pending_ && on; ++i)
            if (opacities[i] > 0) on = takeStep(first + i, opacities[i], radiosityOf(values_[i], first + i), now);
        state = now;
        pending_ = 0;
        return on;
    }

    /// Null where there is nothing; the first and the last step of a span may reach out of it.
    const float* blockAt(const openvdb::Coord& origin) {
        int number = kNoBlock;
        if (!numbers_.probeValue(origin, number)) return nullptr;
        if (number != kNoBlock) return volume_.blocks.block(number);
        // In a large tile, or close to one.
        densities_.fill(origin, filled_, kChannels);
        if constexpr (kChannels > 1) radiosities_.fill(origin, filled_ + 1, kChannels);
        return filled_;
    }

    typename RadiosityGrid::ValueType radiosityOf(const float (&value)[kChannels], std::int64_t k) {
        if constexpr (kChannels == 1) return radiosity_(radiosityLine_.at(timeOf(k)));
        if constexpr (kChannels == 2) return value[1];
        if constexpr (kChannels == 4) return openvdb::Vec3s(value[1], value[2], value[3]);
    }

    bool takeStep(std::int64_t k, float opacity, const typename RadiosityGrid::ValueType& s, RayState& state) {
        const float weight = float(state.transmittance) * opacity;
        add(state.radiance, options_.lambert ? weight * cosine(line_.at(timeOf(k))) : weight, s);
        state.transmittance *= 1 - double(opacity);
        if (state.transmittance > options_.minTransmittance) return true;
        state.radiance *= float(1 / (1 - state.transmittance));
        state.transmittance = 0;
        return false;
    }

    /// max(0, -d.n) with n = -grad sigma / |grad sigma|, in world space.
    float cosine(const openvdb::Vec3d& p) {
        openvdb::Vec3d slope;  // along the axes of index space, per voxel
        for (int axis = 0; axis < 3; ++axis) {
            openvdb::Vec3d ahead = p, behind = p;
            ahead[axis] += 1, behind[axis] -= 1;
            slope[axis] = 0.5 * (double(around_(ahead)) - around_(behind));
        }
        // grad_world_j = sum_i d index_i / d world_j slope_i; OpenVDB's matrices stand to the right of row vectors.
        const openvdb::Mat4d& m = volume_.densityFromWorld;
        openvdb::Vec3d gradient;
        for (int j = 0; j < 3; ++j) gradient[j] = m[j][0] * slope[0] + m[j][1] * slope[1] + m[j][2] * slope[2];
        const double length = gradient.length();
        if (!(slope.length() > 1e-6 * density_(p)) || !(length > 0)) return 1;
        const double alongRay = slope.dot(line_.direction) / worldPerIndex_;  // d . grad sigma
        return float(std::max(0.0, alongRay / length));
    }

    const RenderVolume::Content& volume_;
    const RenderOptions& options_;
    LinearSampler<openvdb::FloatGrid> density_, around_;
    LinearSampler<RadiosityGrid> radiosity_;
    BlockFiller<openvdb::FloatGrid> densities_;
    BlockFiller<RadiosityGrid> radiosities_;
    openvdb::tree::ValueAccessor<const openvdb::Int32Tree, false> numbers_;
    openvdb::math::VolumeHDDA<openvdb::Int32Tree, IndexRay, openvdb::Int32Tree::RootNodeType::ChildNodeType::LEVEL>
        hdda_;
    IndexLine line_{openvdb::Mat4d::identity(), openvdb::Vec3d(0.0), openvdb::Vec3d(0.0)}, radiosityLine_ = line_;
    IndexRay ray_;
    openvdb::Vec3d perDirection_{0.0};  // 1 / line_.direction
    double worldPerIndex_ = 1;
    float filled_[kChannels * kBlockCorners * kBlockCorners * kBlockCorners];
    StepValue<kChannels> values_[kMostSteps];  // of steps that are not taken yet
    int pending_ = 0;
    float stepDepth_ = 0;  // optical depth of a step through density 1
    std::int64_t nextStep_ = 0;
};

}  // namespace raysweep
