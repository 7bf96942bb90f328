/// What a pipeline is handed by the one before it in the ring.
#pragma once

#include "cube4/counters.h"
#include "cube4/words.h"

#include <algorithm>

namespace raysweep::cube4 {

/// Values of the voxels one to the left along a beam: those of the pipeline before, and for a part's first voxel the
/// last one of the part before, which that pipeline had a beam ago and has kept.
template <class T, class Weight>
class LeftNeighbour {
  public:
    explicit LeftNeighbour(int pipelines) : kept_(std::size_t(pipelines)) {}

    /// @param words of a T, for the count
    void shift(const Beam<Weight>& beam, const Lanes<T>& in, Lanes<T>& left, int words, Counters& counters) {
        const std::size_t pipelines = in.size(), first = std::size_t(beam.first);
        std::copy(in.begin(), in.end() - 1, left.begin() + 1);
        left[0] = in[pipelines - 1];
        left[first] = beam.part > 0 ? kept_[first == 0 ? pipelines - 1 : first - 1] : T{};
        std::copy(in.begin(), in.end(), kept_.begin());
        counters.wordsOn += handedOn(std::size_t(words), pipelines);
    }

  private:
    Lanes<T> kept_;
};

/// Beam buffer: values of the beam before, of which each pipeline is handed those of the pipeline before it: the same
/// voxels along the beam, one beam up.
template <class T, class Weight>
class BeamBuffer {
  public:
    explicit BeamBuffer(const StageShape& shape)
        : pipelines_(std::size_t(shape.pipelines)),
          values_(shape.linear ? pipelines_ * std::size_t(shape.parts) : pipelines_) {}

    /// Reads the values of the beam before into `before`, and keeps `in` in their place.
    void exchange(const Beam<Weight>& beam, const Lanes<T>& in, Lanes<T>& before, int words, Counters& counters) {
        T* const values = values_.data() + std::size_t(beam.part) * pipelines_;
        if (beam.row == 0) {
            std::fill(before.begin(), before.end(), T{});
        } else {
            std::copy(values, values + pipelines_ - 1, before.begin() + 1);
            before[0] = values[pipelines_ - 1];
            counters.wordsOn += handedOn(std::size_t(words), pipelines_);
        }
        std::copy(in.begin(), in.end(), values);
    }

    std::size_t wordsPerPipeline(int words) const { return values_.size() / pipelines_ * std::size_t(words); }

  private:
    std::size_t pipelines_;
    std::vector<T> values_;
};

}  // namespace raysweep::cube4
