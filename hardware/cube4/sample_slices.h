// Interpolation from slice to slice.
//
// Holds      the slice buffer: of each pipeline the voxels of the slice before.
// Per cycle  in: voxels; out: values between the slice before and this one, above each voxel.
// Latency    one cycle. Neighbour: the slice before, from the pipeline before.
//
// It comes first of the three interpolations: those along u and v have other weights in every slice, and both of a
// sample's slices need the same. Where samples lie in slices there is nothing to interpolate: voxels pass.
#pragma once

#include "cube4/slice_buffer.h"

namespace raysweep::cube4 {

template <class Arithmetic>
class SampleSlices {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    /// @param between weights of the slice before and this one  @param inSlices samples lie in slices
    SampleSlices(const StageShape& shape, int rows, const Between<Weight>& between, bool inSlices)
        : samples(std::size_t(shape.pipelines)),
          between_(between),
          inSlices_(inSlices),
          before_(samples.size()),
          buffer_(shape, inSlices ? 0 : rows) {}

    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, Lanes<Offer<Word>>& in, Counters& counters) {
        out = beam;
        if (!beam) return;
        if (inSlices_) {
            std::swap(samples, in);
            return;
        }
        buffer_.exchange(beam, beam.slice->number == 0, in, before_, kWords, counters);
        for (std::size_t lane = 0; lane < samples.size(); ++lane)
            samples[lane] = {arithmetic.mix(between_, before_[lane].part, in[lane].part),
                             arithmetic.mix(between_, before_[lane].given, in[lane].given)};
    }

    std::size_t bufferWords() const { return inSlices_ ? 0 : buffer_.wordsPerPipeline(kWords); }

    Beam<Weight> out;
    Lanes<Offer<Word>> samples;

  private:
    static constexpr int kWords = 2;

    Between<Weight> between_;
    bool inSlices_;
    Lanes<Offer<Word>> before_;
    SliceBuffer<Offer<Word>, Weight> buffer_;
};

}  // namespace raysweep::cube4
