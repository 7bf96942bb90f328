/// Slice buffer: values of the slice before, of which each pipeline is handed those of the pipeline before it: the same
/// position, one slice back.
#pragma once

#include "cube4/ring.h"

namespace raysweep::cube4 {

template <class T, class Weight>
class SliceBuffer {
  public:
    /// @param rows beams of a slice
    SliceBuffer(const StageShape& shape, int rows)
        : pipelines_(std::size_t(shape.pipelines)),
          parts_(std::size_t(shape.parts)),
          values_(pipelines_ * parts_ * std::size_t(rows)) {}

    /// Reads the values of the slice before into `before`, and keeps `in` in their place. @param first no slice before
    void exchange(const Beam<Weight>& beam, bool first, const Lanes<T>& in, Lanes<T>& before, int words,
                  Counters& counters) {
        T* const values = values_.data() + (std::size_t(beam.row) * parts_ + std::size_t(beam.part)) * pipelines_;
        if (first) {
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
    std::size_t pipelines_, parts_;
    std::vector<T> values_;
};

}  // namespace raysweep::cube4
