// Compositing buffer: the rays between one slice and the next.
//
// Holds      of each pipeline the rays that it is to meet next, in a memory with a port for reading and one for writing
//            (rendering reads and writes a ray in every cycle). A ray (u,v) of the lattice has the same address, and
//            the pipeline that holds it moves with the slices (router.h).
// Per cycle  in: a partial beam whose rays to read, finished rays to write; out: the rays that were read.
// Latency    one cycle.
//
// An address is shared by p neighbours of a row. With one address more than a row needs, those at its two ends never
// share one: rays that are finished at one end would take the places of rays that are still to be read at the other.
//
// Where rays come from a point they move on by different ways, and have the address of their place in the next slice,
// in one of two banks: one for even slices and one for odd ones, so that none is written where another is still to be
// read.
//
// Every read is checked: that it finds the ray that it wants, finished in the slice before.
//
// Rays that enter the volume are not in the buffer: the address generator knows them by where they were a slice before.
#pragma once

#include "cube4/counters.h"
#include "cube4/traversal.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace raysweep::cube4 {

/// All rays of a pass by their lattice coordinates: what they carry when they enter, or when they leave.
template <class Word>
struct RayPlane {
    int lowU = 0, lowV = 0, width = 0, height = 0;
    std::vector<Ray<Word>> rays;

    RayPlane() = default;
    /// Room for all rays that a pass meets.
    template <class Weight>
    RayPlane(const Traversal& traversal, const std::vector<SliceSetup<Weight>>& slices) {
        int leastU = 0, mostU = 0, leastV = 0, mostV = 0;
        for (const SliceSetup<Weight>& slice : slices) {
            leastU = std::min(leastU, slice.shiftU), mostU = std::max(mostU, slice.shiftU);
            leastV = std::min(leastV, slice.shiftV), mostV = std::max(mostV, slice.shiftV);
        }
        lowU = -mostU, width = traversal.size.x - traversal.reach - leastU + mostU;
        lowV = -mostV, height = traversal.size.y - traversal.reach - leastV + mostV;
        rays.resize(std::size_t(width) * std::size_t(height));
    }

    Ray<Word>& at(int u, int v) { return rays[indexOf(u, v)]; }
    const Ray<Word>& at(int u, int v) const { return rays[indexOf(u, v)]; }

  private:
    std::size_t indexOf(int u, int v) const {
        return std::size_t(v - lowV) * std::size_t(width) + std::size_t(u - lowU);
    }
};

/// What tells a ray that is ready for slice k from all others: (u, v, k), u and v of the lattice.
using RayTag = std::array<std::int32_t, 3>;

template <class Word>
class RayBuffer {
  public:
    /// @param diverging rays come from a point
    RayBuffer(const Traversal& traversal, int pipelines, bool diverging = false)
        : pipelines_(pipelines),
          columns_((traversal.size.x + (diverging ? 1 : 2) * pipelines - 1) / pipelines),
          rows_(traversal.size.y),
          banks_(diverging ? 2 : 1),
          rays_(std::size_t(banks_) * std::size_t(columns_) * std::size_t(rows_) * std::size_t(pipelines)),
          tags_(rays_.size(), RayTag{{0, 0, -1}}),
          readIn_(std::size_t(pipelines), 0),
          writtenIn_(std::size_t(pipelines), 0) {}

    /// Words of rays in each pipeline.
    std::size_t raysPerPipeline() const { return rays_.size() / std::size_t(pipelines_); }

    void beginCycle() { ++cycle_; }

    /// Reads the rays whose lower voxels are `back` before those of `beam` along u and v; those that have just come in
    /// from `entering`.
    template <class Weight>
    void read(const Beam<Weight>& beam, int back, const Traversal& traversal, const RayPlane<Word>& entering,
              Lanes<Ray<Word>>& out, Counters& counters) {
        const SliceSetup<Weight>& slice = *beam.slice;
        if (slice.diverges()) {
            readDiverging(beam, back, entering, out, counters);
            return;
        }
        const int v = beam.row - back;
        const int lastU = traversal.size.x - 1 - traversal.reach, lastV = traversal.size.y - 1 - traversal.reach;
        const int wasV = v - slice.fromV;
        const bool newRow = slice.first || wasV < 0 || wasV > lastV;
        const RowAddress row = addressOf(v, slice.shiftU, slice.shiftV);
        forEachLane(beam, pipelines_, traversal.size.x, [&](std::size_t lane, int at) {
            const int u = at - back;
            if (u < 0 || u > lastU || v < 0 || v > lastV) {
                out[lane] = {};
                return;
            }
            const int was = u - slice.fromU;
            if (newRow || was < 0 || was > lastU) {
                out[lane] = entering.at(u - slice.shiftU, v - slice.shiftV);
                ++entered_;
                return;
            }
            out[lane] = readSlot(lane, row.slotOf(u), {u - slice.shiftU, v - slice.shiftV, slice.number}, counters);
        });
    }

    /// Address of a ray that comes from a point, at position (u, v) of slice k.
    int slotOf(int u, int v, int k) const { return ((k & 1) * rows_ + v) * columns_ + u / pipelines_; }

    /// Address of the ray at position (u, v) of `slice`.
    struct RowAddress {
        int base, shift, width, pipelines;
        int slotOf(int u) const {
            const int column = u - shift;
            return base + (column < 0 ? column + width : column) / pipelines;
        }
    };
    RowAddress addressOf(int row, int shiftU, int shiftV) const {
        const int width = columns_ * pipelines_;
        return {modulo(row - shiftV, rows_) * columns_, modulo(shiftU, width), width, pipelines_};
    }

    /// @param ray has `ray`, its `slot` and its `tag`
    template <class Finished>
    void write(std::size_t lane, const Finished& ray, Counters& counters) {
        counters.conflicts += writtenIn_[lane] == cycle_;
        writtenIn_[lane] = cycle_;
        ++counters.rayWrites;
        const std::size_t place = std::size_t(ray.slot) * std::size_t(pipelines_) + lane;
        rays_[place] = ray.ray;
        tags_[place] = ray.tag;
    }

    std::uint64_t entered() const { return entered_; }

  private:
    template <class Weight>
    void readDiverging(const Beam<Weight>& beam, int back, const RayPlane<Word>& entering, Lanes<Ray<Word>>& out,
                       Counters& counters) {
        const SliceSetup<Weight>& slice = *beam.slice;
        std::fill(out.begin(), out.end(), Ray<Word>{});
        const int row = beam.row - back;
        if (row < 0 || !slice.placesV[std::size_t(row)].hasRay) return;
        const Place<Weight>& v = slice.placesV[std::size_t(row)];
        forEachLane(beam, pipelines_, int(slice.placesU.size()), [&](std::size_t lane, int at) {
            const int column = at - back;
            if (column < 0 || !slice.placesU[std::size_t(column)].hasRay) return;
            const Place<Weight>& u = slice.placesU[std::size_t(column)];
            if (slice.first || u.from < 0 || v.from < 0) {
                out[lane] = entering.at(u.ray, v.ray);
                ++entered_;
            } else {
                out[lane] = readSlot(lane, slotOf(column, row, slice.number), {u.ray, v.ray, slice.number}, counters);
            }
        });
    }

    const Ray<Word>& readSlot(std::size_t lane, int slot, const RayTag& wanted, Counters& counters) {
        counters.conflicts += readIn_[lane] == cycle_;
        readIn_[lane] = cycle_;
        ++counters.rayReads;
        const std::size_t place = std::size_t(slot) * std::size_t(pipelines_) + lane;
        counters.hazards += tags_[place] != wanted;
        return rays_[place];
    }

    static int modulo(int value, int by) {
        const int rest = value % by;
        return rest < 0 ? rest + by : rest;
    }

    int pipelines_, columns_, rows_, banks_;
    std::vector<Ray<Word>> rays_;  ///< by address, then by pipeline
    std::vector<RayTag> tags_;     ///< of each: the machine has none, they are there to check it
    std::vector<std::uint64_t> readIn_, writtenIn_;
    std::uint64_t cycle_ = 0, entered_ = 0;
};

}  // namespace raysweep::cube4
