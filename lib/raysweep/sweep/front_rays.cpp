#include "raysweep/sweep/front_rays.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace raysweep {
namespace {

constexpr int kPad = kBrickEdge;  ///< what a clipped row of a brick may overhang

RayRange widened(const RayRange& range, int by) {
    return {range.begin - by, range.end + by};
}

bool isPeriodic(const RayFront& front) {
    return front.periodic || front.column.periodic || front.row.periodic;
}

/// Puts ranges in order, and together where they overlap or less than `gap` is between them.
void merge(std::vector<RayRange>& ranges, int gap) {
    std::sort(ranges.begin(), ranges.end(), [](const RayRange& a, const RayRange& b) { return a.begin < b.begin; });
    std::vector<RayRange> merged;
    for (const RayRange& range : ranges) {
        if (range.empty()) continue;
        if (merged.empty() || std::int64_t(range.begin) - merged.back().end > gap)
            merged.push_back(range);
        else
            merged.back().end = std::max(merged.back().end, range.end);
    }
    ranges = std::move(merged);
}

}  // namespace

FrontRays::FrontRays(const Beam& beam, const BrickIndex& index, int margin, int channels, bool furnace)
    : channels_(channels),
      furnace_(furnace),
      rows_(widened(rayExtent(beam.front, beam.front.row), margin)),
      columns_(widened(rayExtent(beam.front, beam.front.column), margin)),
      column_(beam.front.column),
      row_(beam.front.row),
      spans_(std::size_t(rows_.size())),
      starts_(std::size_t(rows_.size())) {
    if (isPeriodic(beam.front)) {
        std::fill_n(spans_.data(), rows_.size(), columns_);
        usedRows_ = {rows_};
        usedColumns_ = {columns_};
    } else {
        spanBricks(beam.front, index);
    }
    makeRoom();
}

void FrontRays::spanBricks(const RayFront& front, const BrickIndex& index) {
    constexpr int kWide = 1 << 16;  // rays; below, it is not worth while to look for gaps
    const bool wide = rows_.size() > kWide || columns_.size() > kWide;
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
        if (!wide) continue;
        usedRows_.push_back(rows);
        for (std::size_t i = bricks.first; i < bricks.end; ++i)
            usedColumns_.push_back(reach(index.entries()[i].column, index.entries()[i].column, columnShift(slice),
                                         columnShift(end), columns_));
    }
    if (!wide) {
        usedRows_ = {rows_};
        usedColumns_ = {columns_};
    }
    merge(usedRows_, 0);
    merge(usedColumns_, kWide);
}

/// Rows one behind the other.
void FrontRays::makeRoom() {
    for (const RayRange& rows : usedRows_)
        for (int v = rows.begin; v < rows.end; ++v) {
            starts_[std::size_t(v - rows_.begin)] = std::ptrdiff_t(plane_) + kPad - span(v).begin;
            plane_ += std::size_t(span(v).size() + 2 * kPad);
        }
    rays_ = ZeroedArray<float>(plane_ * std::size_t(channels_ + (furnace_ ? 2 : 0)));
}

template <class Visit>
void FrontRays::forEachStretch(const Visit& visit) {
    for (const RayRange& rows : usedRows_)
        for (int v = rows.begin; v < rows.end; ++v)
            for (const RayRange& columns : usedColumns_) {
                const RayRange held{std::max(span(v).begin, columns.begin), std::min(span(v).end, columns.end)};
                if (!held.empty()) visit(v, held);
            }
}

void FrontRays::enter(const Beam& beam, CrossingRays* arriving) {
    forEachStretch([&](int v, const RayRange& held) {
        if (furnace_)
            std::fill(lastSlice() + rowStarts()[v] + held.begin - kPad, lastSlice() + rowStarts()[v] + held.end + kPad,
                      kLongAgo);
        const RayRange enters = raysThatEnter(beam.front, v);
        const int begin = std::max(enters.begin, held.begin), end = std::min(enters.end, held.end);
        if (end <= begin) return;
        entered_ += end - begin;
        for (int c = 0; c < channels_; ++c) {
            float* const rays = row(v) + std::size_t(c) * plane_;
            std::fill(rays + begin, rays + end, beam.entering[c]);
        }
    });
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
        constexpr std::ptrdiff_t kLanes = 8;  // added side by side, as wide instructions do
        double sum[kLanes] = {0};
        forEachStretch([&](int v, const RayRange& held) {
            const float* const rays = row(v) + std::size_t(c) * plane_;
            std::ptrdiff_t u = held.begin;
            for (; u + kLanes <= held.end; u += kLanes)
                for (std::ptrdiff_t lane = 0; lane < kLanes; ++lane) sum[lane] += double(rays[u + lane]);
            for (; u < held.end; ++u) sum[0] += double(rays[u]);
        });
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
