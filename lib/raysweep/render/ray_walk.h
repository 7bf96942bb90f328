/// A ray's steps through the blocks of a grid, wherever there is anything.
#pragma once

#include "raysweep/camera/camera.h"
#include "raysweep/render/block_steps.h"
#include "raysweep/render/cell_blocks.h"
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

/// A ray in a grid's index space: o + t d.
struct IndexLine {
    openvdb::Vec3d origin{0.0}, direction{0.0};
    IndexLine() = default;
    IndexLine(const openvdb::Mat4d& indexFromWorld, const openvdb::Vec3d& o, const openvdb::Vec3d& d)
        : origin(indexFromWorld.transform(o)), direction(indexFromWorld.transform3x3(d)) {}
    openvdb::Vec3d at(double t) const { return origin + direction * t; }
};

/// A grid made ready for rays.
struct RayGrid {
    openvdb::Mat4d indexFromWorld;
    CellBlocks blocks;
    openvdb::CoordBBox bounds;  ///< of the blocks, exclusive at its upper end
};

/// Walks along rays one after another; owns what a thread needs for it. Blocks have `kChannels` values at a corner.
/// `FillBlock`, called with an origin and room for a block, fills those that are in large tiles, or close to one.
template <int kChannels, class FillBlock>
class RayWalk {
  public:
    RayWalk(const RayGrid& grid, FillBlock fillBlock)
        : grid_(grid), numbers_(*grid.blocks.numbers), fillBlock_(std::move(fillBlock)) {}

    /// Sets up the ray in index space, t being the length there, so that one step is the same number of voxels in
    /// every direction. @param step voxels  @return false if the ray misses the volume
    bool start(const Ray& ray, double step) {
        if (grid_.bounds.empty()) return false;
        step_ = step;
        const openvdb::Vec3d origin = toVdb(ray.origin);
        worldPerIndex_ = worldPerIndex(ray);
        line_ = IndexLine(grid_.indexFromWorld, origin, toVdb(ray.direction) * worldPerIndex_);
        ray_ = IndexRay(line_.origin, line_.direction, 0.0);
        if (!ray_.clip(grid_.bounds)) return false;
        // Start over near the volume, a whole number of steps on: the samples stay where they are, but an eye far away
        // costs no digits.
        skipped_ = std::floor(ray_.t0() / step) * step;
        for (int axis = 0; axis < 3; ++axis) perDirection_[axis] = 1 / line_.direction[axis];
        line_.origin = line_.at(skipped_);
        // OpenVDB's rays begin after 0.
        const double begin = std::max(ray_.t0() - skipped_, openvdb::math::Delta<double>::value());
        ray_ = IndexRay(line_.origin, line_.direction, begin, ray_.t1() - skipped_);
        nextStep_ = 0;
        return true;
    }

    /// Calls `take(first, count, values)` for steps that touch anything, at most kMostSteps of them, and in between
    /// some that do not, until it returns false or the ray has left the volume.
    template <class Take>
    void walk(const Take& take) {
        IndexRay segment = ray_;
        while (segment.valid()) {
            const auto span = hdda_.march(segment, numbers_);
            if (!span.valid() || !crossSpan(span.t0, span.t1, take)) break;
            // A nudge, so that rounding does not find the same end again.
            segment = ray_;
            segment.setTimes(std::min(span.t1 + openvdb::math::Delta<double>::value(), ray_.t1()), ray_.t1());
        }
    }

    /// Length of a voxel along the ray, world units.
    double worldPerIndex(const Ray& ray) const {
        return 1 / grid_.indexFromWorld.transform3x3(toVdb(ray.direction)).length();
    }
    double worldPerIndex() const { return worldPerIndex_; }

    const IndexLine& line() const { return line_; }  ///< from where steps are counted
    double skipped() const { return skipped_; }      ///< of the ray before that, voxels
    /// Middle of a step on line().
    double timeOf(std::int64_t step) const { return (double(step) + 0.5) * step_; }
    /// Where a step begins, world units from the eye.
    double distanceOf(std::int64_t step) const { return (skipped_ + double(step) * step_) * worldPerIndex_; }

  private:
    using IndexRay = openvdb::math::Ray<double>;

    /// Takes the steps that touch [t0,t1] and were not taken yet. @return false when `take` wants no more
    template <class Take>
    bool crossSpan(double t0, double t1, const Take& take) {
        const auto end = ceilToInt(t1 / step_);
        std::int64_t k = std::max(nextStep_, std::int64_t(t0 / step_));
        nextStep_ = std::max(nextStep_, end);
        for (pending_ = 0; k < end;) {
            const openvdb::Vec3d p = line_.at(timeOf(k));
            const openvdb::Coord origin =
                openvdb::Coord(floorToInt(p.x()), floorToInt(p.y()), floorToInt(p.z())) & ~(kBlockCells - 1);
            const std::int64_t last = std::clamp(ceilToInt(leaves(origin) / step_ - 0.5), k + 1, end);
            const float* const block = blockAt(origin);
            if (!(block ? crossBlock(block, origin, k, last, take) : takePending(k, take))) return false;
            k = last;
        }
        return takePending(end, take);
    }

    /// Where the ray, now in the block at `origin`, leaves it.
    double leaves(const openvdb::Coord& origin) const {
        double t = ray_.t1() + step_;
        for (int axis = 0; axis < 3; ++axis) {
            const double d = line_.direction[axis];
            const double side = origin[axis] + (d > 0 ? kBlockCells : 0);
            if (d != 0) t = std::min(t, (side - line_.origin[axis]) * perDirection_[axis]);
        }
        return t;
    }

    /// Steps k to `end` lie in the block at `origin`. Steps are taken some dozens at a time: a block's own are so few
    /// that one operation would wait for the other.
    template <class Take>
    bool crossBlock(const float* block, const openvdb::Coord& origin, std::int64_t k, std::int64_t end,
                    const Take& take) {
        BlockSteps steps;
        for (int axis = 0; axis < 3; ++axis) steps.perStep[axis] = float(line_.direction[axis] * step_);
        while (k < end) {
            const openvdb::Vec3d p = line_.at(timeOf(k)) - origin.asVec3d();
            for (int axis = 0; axis < 3; ++axis) steps.first[axis] = float(p[axis]);
            steps.count = int(std::min<std::int64_t>(kMostSteps - pending_, end - k));
            sampleSteps<kChannels>(block, steps, values_ + pending_);
            pending_ += steps.count;
            k += steps.count;
            if (pending_ == kMostSteps && !takePending(k, take)) return false;
        }
        return true;
    }

    /// Takes the steps before step `end` whose values were found.
    template <class Take>
    bool takePending(std::int64_t end, const Take& take) {
        const int count = pending_;
        pending_ = 0;
        return take(end - count, count, values_);
    }

    /// Null where there is nothing; the first and the last step of a span may reach out of it.
    const float* blockAt(const openvdb::Coord& origin) {
        int number = kNoBlock;
        if (!numbers_.probeValue(origin, number)) return nullptr;
        if (number != kNoBlock) return grid_.blocks.block(number);
        fillBlock_(origin, filled_);
        return filled_;
    }

    const RayGrid& grid_;
    openvdb::tree::ValueAccessor<const openvdb::Int32Tree, false> numbers_;
    openvdb::math::VolumeHDDA<openvdb::Int32Tree, IndexRay, openvdb::Int32Tree::RootNodeType::ChildNodeType::LEVEL>
        hdda_;
    FillBlock fillBlock_;
    IndexLine line_;
    IndexRay ray_;
    openvdb::Vec3d perDirection_{0.0};  // 1 / line_.direction
    double step_ = 1, skipped_ = 0, worldPerIndex_ = 1;
    float filled_[kChannels * kBlockCorners * kBlockCorners * kBlockCorners];
    StepValue<kChannels> values_[kMostSteps];  // of steps that are not taken yet
    int pending_ = 0;
    std::int64_t nextStep_ = 0;
};

}  // namespace raysweep
