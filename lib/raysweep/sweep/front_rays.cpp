#include "raysweep/sweep/front_rays.h"

#include <algorithm>

namespace raysweep {
namespace {

constexpr int kPad = kBrickEdge;  ///< what a clipped row of a brick may overhang

RayRange widened(const RayRange& range, int by) {
    return {range.begin - by, range.end + by};
}

bool isPeriodic(const RayFront& front) {
    return front.periodic || front.column.periodic || front.row.periodic;
}

}  // namespace

FrontRays::FrontRays(const Beam& beam, const BrickIndex& index, int margin, int channels, bool furnace)
    : channels_(channels),
      furnace_(furnace),
      rows_(widened(rayExtent(beam.front, beam.front.row), margin)),
      columns_(widened(rayExtent(beam.front, beam.front.column), margin)),
      spans_(std::size_t(rows_.size())) {
    const RayFront& front = beam.front;
    for (int k = 0; k < front.slices; ++k) {
        columnShifts_.push_back(front.column.shift(k));
        rowShifts_.push_back(front.row.shift(k));
    }
    if (isPeriodic(front))
        std::fill(spans_.begin(), spans_.end(), columns_);
    else
        spanBricks(front, index);
    for (const RayRange& range : spans_) {
        starts_.push_back(std::ptrdiff_t(plane_) + kPad - range.begin);
        plane_ += std::size_t(range.size() + 2 * kPad);
    }
    rays_.assign(plane_ * std::size_t(channels + (furnace ? 2 : 0)), 0.0f);
}

void FrontRays::spanBricks(const RayFront& front, const BrickIndex& index) {
    for (const BrickIndex::Row& bricks : index.rows()) {
        const int slice = front.sliceNumber(bricks.layer);
        const auto reach = [&](int low, int high, int first, int last, const RayRange& all) {
            return RayRange{std::max(all.begin, low - front.reach - std::max(first, last)),
                            std::min(all.end, high + kBrickEdge - std::min(first, last))};
        };
        const int end = slice + kBrickEdge - 1;
        const RayRange rows = reach(bricks.row, bricks.row, rowShift(slice), rowShift(end), rows_);
        const RayRange columns = reach(index.entries()[bricks.first].column, index.entries()[bricks.end - 1].column,
                                       columnShift(slice), columnShift(end), columns_);
        for (int v = rows.begin; v < rows.end; ++v) {
            RayRange& all = span(v);
            all = all.empty() ? columns : RayRange{std::min(all.begin, columns.begin), std::max(all.end, columns.end)};
        }
    }
}

void FrontRays::enter(const Beam& beam, CrossingRays* arriving) {
    if (furnace_) std::fill_n(lastSlice(), plane_, kLongAgo);
    const RayRange lattice = rayExtent(beam.front, beam.front.row);
    for (int v = lattice.begin; v < lattice.end; ++v) {
        if (span(v).empty()) continue;
        const RayRange enters = raysThatEnter(beam.front, v);
        const int begin = std::max(enters.begin, span(v).begin), end = std::min(enters.end, span(v).end);
        if (end <= begin) continue;
        entered_ += end - begin;
        for (int c = 0; c < channels_; ++c) {
            float* const rays = row(v) + std::size_t(c) * plane_;
            std::fill(rays + begin, rays + end, beam.entering[c]);
        }
    }
    if (arriving) arrive(beam.front, *arriving);
}

RaySums FrontRays::leave(const Beam& beam, CrossingRays* leaving) {
    if (leaving) goOn(beam.front, *leaving);
    // Rays that enter the bounding box but meet no brick are not held: they come out as they went in.
    const double entered = countRaysThatEnter(beam.front);
    RaySums sums;
    for (int c = 0; c < channels_; ++c) {
        sums.entered[c] = entered * double(beam.entering[c]);
        sums.escaped[c] = (entered - entered_) * double(beam.entering[c]);
        constexpr std::size_t kLanes = 8;  // added side by side, as wide instructions do
        double sum[kLanes] = {0};
        const float* const rays = power() + std::size_t(c) * plane_;
        for (std::size_t i = 0; i < plane_ / kLanes * kLanes; i += kLanes)
            for (std::size_t lane = 0; lane < kLanes; ++lane) sum[lane] += double(rays[i + lane]);
        for (std::size_t i = plane_ / kLanes * kLanes; i < plane_; ++i) sum[0] += double(rays[i]);
        for (const double part : sum) sums.escaped[c] += part;
    }
    return sums;
}

/// Rays that were inside in the slice before the first come from the repetition before.
void FrontRays::arrive(const RayFront& front, CrossingRays& arriving) {
    const auto inBoth = [&](const Lateral& lateral) {
        const RayRange before = raysInside(front, lateral, -1), now = raysInside(front, lateral, 0);
        return RayRange{std::max(before.begin, now.begin), std::min(before.end, now.end)};
    };
    const RayRange columns = inBoth(front.column), rows = inBoth(front.row);
    for (int v = rows.begin; v < rows.end; ++v) {
        entered_ -= columns.size();
        for (int u = columns.begin; u < columns.end; ++u) {
            const std::ptrdiff_t ray = rowStarts()[v] + u;
            for (int c = 0; c < channels_; ++c)
                power()[std::ptrdiff_t(std::size_t(c) * plane_) + ray] = arriving.at(c, v, u);
            if (!furnace_ || arriving.furnace.empty()) continue;
            furnace()[ray] = arriving.furnaceAt(v, u);
            lastSlice()[ray] = arriving.sliceAt(v, u);
        }
    }
}

/// Hands over the rays that are inside in the slice after the last.
void FrontRays::goOn(const RayFront& front, CrossingRays& leaving) {
    const RayRange rows = rayExtent(front, front.row), columns = rayExtent(front, front.column);
    for (int v = rows.begin; v < rows.end; ++v) {
        const int rowThere = rayInNextRepetition(front, front.row, v);
        if (rowThere < leaving.rows.begin || rowThere >= leaving.rows.end) continue;
        for (int u = columns.begin; u < columns.end; ++u) {
            const int there = rayInNextRepetition(front, front.column, u);
            if (there < leaving.columns.begin || there >= leaving.columns.end) continue;
            const std::ptrdiff_t ray = rowStarts()[v] + u;
            for (int c = 0; c < channels_; ++c) {
                float& power = this->power()[std::ptrdiff_t(std::size_t(c) * plane_) + ray];
                leaving.at(c, rowThere, there) = power;
                power = 0;
            }
            if (!furnace_) continue;
            leaving.furnaceAt(rowThere, there) = furnace()[ray];
            leaving.sliceAt(rowThere, there) = lastSlice()[ray] - float(front.slices);
        }
    }
}

}  // namespace raysweep
