// Gradient: central differences of samples.
//
// Holds      samples of the last two slices and the last two beams, and those two to the left.
// Per cycle  in: samples; out: the sample one back along u, v and k, and its six neighbours.
// Latency    three cycles: along the beam, from beam to beam, from slice to slice. Neighbour: each stage takes what it
//            holds from the pipeline before.
//
// A cascade: each stage makes of a value the same one and those one and two before it along its axis.
#pragma once

#include "cube4/slice_buffer.h"

#include <array>

namespace raysweep::cube4 {

/// A sample and its neighbours; of the middle one all words, of the others the scalar.
template <class Word>
struct SampleNeighbours {
    Offer<Word> middle;
    std::array<Word, 3> below{}, above{};  ///< along u, v, k
};

template <class Arithmetic>
class Gradient {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    Gradient(const StageShape& shape, int rows)
        : neighbours(std::size_t(shape.pipelines)),
          left_(shape.pipelines),
          leftOfLeft_(shape.pipelines),
          beam_(shape),
          beamBefore_(shape),
          slice_(shape, rows),
          sliceBefore_(shape, rows),
          across_(neighbours.size()),
          acrossIn_(neighbours.size()),
          along_(neighbours.size()),
          samples_(neighbours.size()),
          samplesBefore_(neighbours.size()),
          alongBefore_(neighbours.size()),
          scalars_(neighbours.size()),
          scalarsBefore_(neighbours.size()) {}

    void tick(const Beam<Weight>& beam, const Lanes<Offer<Word>>& in, Counters& counters) {
        betweenSlices(alongBeam_, counters);
        betweenBeams(acrossBeam_, counters);
        alongTheBeam(beam, in, counters);
    }

    std::size_t bufferWords() const {
        return beam_.wordsPerPipeline(kAcrossWords) + beamBefore_.wordsPerPipeline(1) +
               slice_.wordsPerPipeline(kAlongWords) + sliceBefore_.wordsPerPipeline(1);
    }

    Beam<Weight> out;
    Lanes<SampleNeighbours<Word>> neighbours;

  private:
    static constexpr int kAcrossWords = 4, kAlongWords = 6;

    /// Neighbours along u are known.
    void alongTheBeam(const Beam<Weight>& beam, const Lanes<Offer<Word>>& in, Counters& counters) {
        acrossBeam_ = beam;
        if (!beam) return;
        left_.shift(beam, in, samples_, 2, counters);
        leftOfLeft_.shift(beam, samples_, samplesBefore_, 1, counters);
        for (std::size_t lane = 0; lane < in.size(); ++lane) {
            SampleNeighbours<Word>& sample = across_[lane];
            sample.middle = samples_[lane];
            sample.below[0] = samplesBefore_[lane].part;
            sample.above[0] = in[lane].part;
        }
    }

    /// Neighbours along v, too.
    void betweenBeams(const Beam<Weight>& beam, Counters& counters) {
        alongBeam_ = beam;
        if (!beam) return;
        beam_.exchange(beam, across_, acrossIn_, kAcrossWords, counters);
        for (std::size_t lane = 0; lane < across_.size(); ++lane) scalars_[lane] = acrossIn_[lane].middle.part;
        beamBefore_.exchange(beam, scalars_, scalarsBefore_, 1, counters);
        for (std::size_t lane = 0; lane < across_.size(); ++lane) {
            along_[lane] = acrossIn_[lane];
            along_[lane].below[1] = scalarsBefore_[lane];
            along_[lane].above[1] = across_[lane].middle.part;
        }
    }

    /// And along k.
    void betweenSlices(const Beam<Weight>& beam, Counters& counters) {
        out = beam;
        if (!beam) return;
        const bool first = beam.slice->number == 0;
        slice_.exchange(beam, first, along_, alongBefore_, kAlongWords, counters);
        for (std::size_t lane = 0; lane < along_.size(); ++lane) scalars_[lane] = alongBefore_[lane].middle.part;
        sliceBefore_.exchange(beam, first, scalars_, scalarsBefore_, 1, counters);
        for (std::size_t lane = 0; lane < along_.size(); ++lane) {
            neighbours[lane] = alongBefore_[lane];
            neighbours[lane].below[2] = scalarsBefore_[lane];
            neighbours[lane].above[2] = along_[lane].middle.part;
        }
    }

    LeftNeighbour<Offer<Word>, Weight> left_, leftOfLeft_;
    BeamBuffer<SampleNeighbours<Word>, Weight> beam_;
    BeamBuffer<Word, Weight> beamBefore_;
    SliceBuffer<SampleNeighbours<Word>, Weight> slice_;
    SliceBuffer<Word, Weight> sliceBefore_;
    Beam<Weight> acrossBeam_, alongBeam_;
    Lanes<SampleNeighbours<Word>> across_, acrossIn_, along_;
    Lanes<Offer<Word>> samples_, samplesBefore_;
    Lanes<SampleNeighbours<Word>> alongBefore_;
    Lanes<Word> scalars_, scalarsBefore_;
};

}  // namespace raysweep::cube4
