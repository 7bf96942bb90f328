#include "cube4/renderer.h"

#include "cube4/arithmetic.h"
#include "cube4/composite.h"
#include "cube4/delay_line.h"
#include "cube4/fixed_point.h"
#include "cube4/offer_across.h"
#include "cube4/offer_along.h"
#include "cube4/ray_return.h"
#include "cube4/sample_slices.h"
#include "cube4/sequencer.h"
#include "cube4/trace.h"

#include "raysweep/core/error.h"

#include <string>
#include <utility>

namespace raysweep::cube4 {
namespace {

template <class Arithmetic>
class Machine {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    Machine(const Arithmetic& arithmetic, VoxelMemory<Word>& memory, const RenderInput<Arithmetic>& input,
            int pipelines, Trace* trace)
        : arithmetic_(arithmetic),
          memory_(memory),
          input_(input),
          trace_(trace),
          lambert_(input.setup.lambert),
          sequencer_(input.traversal, input.slices, pipelines, 1,
                     {input.traversal.reach, renderDelay(input.inSlices, lambert_)}),
          shape_{pipelines, sequencer_.parts(), true, 2, 2},
          buffer_(input.traversal, pipelines, diverges()),
          voxels_(std::size_t(pipelines)),
          offers_(std::size_t(pipelines)),
          rays_(std::size_t(pipelines)),
          shadedWaits_(pipelines, 1),
          slices_(shape_, input.traversal.size.y, input.between, input.inSlices),
          across_(shape_),
          along_(shape_),
          gradient_(shape_, lambert_ ? input.traversal.size.y : 0),
          shade_(shape_, input.setup),
          composite_(shape_),
          return_(shape_, diverges()),
          entering_(input.entering ? *input.entering : RayPlane<Word>(input.traversal, input.slices)) {
        if (!input.entering)
            for (Ray<Word>& ray : entering_.rays) ray.weight = arithmetic.one();
        result_.leaving = entering_;  // a place of the lattice that no ray passes is seen through
    }

    PassResult<Word> run() {
        while (!sequencer_.done() || underWay_ > 0) tick();
        result_.raysEntered = buffer_.entered();
        result_.rayWords = buffer_.raysPerPipeline() * std::size_t(shape_.rayWords);
        result_.bufferWords = slices_.bufferWords() + along_.bufferWords() + (lambert_ ? gradient_.bufferWords() : 0) +
                              return_.bufferWords();
        return std::move(result_);
    }

  private:
    bool diverges() const { return input_.slices.front().diverges(); }

    /// From the last stage to the first, so that each still finds the registers of the one before it.
    void tick() {
        Counters& counters = result_.counters;
        ++counters.cycles;
        memory_.beginCycle();
        buffer_.beginCycle();
        if (return_.write(buffer_, counters)) --underWay_;
        if (return_.isFull()) {
            ++counters.stalls;
            sequencer_.note(return_.out());
            return;
        }
        return_.tick(composite_.out, composite_.rays, counters);
        composite_.tick(arithmetic_, raysRead_, rays_, shadedWaits_.pass(shade_.shaded), input_.traversal, buffer_,
                        result_.leaving);
        raysRead_ = shade_.out;
        if (raysRead_) buffer_.read(raysRead_, input_.traversal.reach, input_.traversal, entering_, rays_, counters);
        if (lambert_) {
            shade_.tick(arithmetic_, behind(gradient_.out), gradient_.neighbours);
            gradient_.tick(along_.out, along_.offers, counters);
        } else {
            shade_.tick(arithmetic_, along_.out, along_.offers);
        }
        along_.tick(arithmetic_, across_.out, across_.offers, counters);
        across_.tick(arithmetic_, slices_.out, slices_.samples, counters);
        slices_.tick(arithmetic_, voxelsRead_, offers_, counters);
        if (!input_.inSlices) slices_.out = behind(slices_.out);
        voxelsRead_ = sequencer_.out;
        if (voxelsRead_) readVoxels(counters);
        sequencer_.tick(return_.out(), counters);
        if (sequencer_.out) ++underWay_;
        if (trace_) record();
    }

    void readVoxels(Counters& counters) {
        memory_.read(voxelsRead_, input_.traversal, voxels_, counters);
        for (std::size_t lane = 0; lane < voxels_.size(); ++lane)
            offers_[lane] = {voxels_[lane].scalar, voxels_[lane].source};
    }

    /// What stages that hold a slice give belongs to the one before. The first one's has none: it is dropped.
    Beam<Weight> behind(Beam<Weight> beam) {
        if (!beam) return beam;
        if (beam.slice->number == 0) {
            --underWay_;
            return {};
        }
        beam.slice = &input_.slices[std::size_t(beam.slice->number - 1)];
        return beam;
    }

    void record() {
        if (lambert_)
            recordTrace<Weight>(*trace_, {{"sequencer", &sequencer_.out},
                                          {"voxels read", &voxelsRead_},
                                          {"sample_slices", &slices_.out},
                                          {"offer_across", &across_.out},
                                          {"offer_along", &along_.out},
                                          {"gradient", &gradient_.out},
                                          {"shade", &shade_.out},
                                          {"rays read", &raysRead_},
                                          {"composite", &composite_.out},
                                          {"router", &return_.out()}});
        else
            recordTrace<Weight>(*trace_, {{"sequencer", &sequencer_.out},
                                          {"voxels read", &voxelsRead_},
                                          {"sample_slices", &slices_.out},
                                          {"offer_across", &across_.out},
                                          {"offer_along", &along_.out},
                                          {"shade", &shade_.out},
                                          {"rays read", &raysRead_},
                                          {"composite", &composite_.out},
                                          {"router", &return_.out()}});
    }

    const Arithmetic& arithmetic_;
    VoxelMemory<Word>& memory_;
    const RenderInput<Arithmetic>& input_;
    Trace* const trace_;
    const bool lambert_;
    PassResult<Word> result_;
    int underWay_ = 0;  ///< partial beams that were issued and whose rays are not back

    Sequencer<Weight> sequencer_;
    StageShape shape_;
    RayBuffer<Word> buffer_;
    Beam<Weight> voxelsRead_, raysRead_;
    Lanes<Voxel<Word>> voxels_;
    Lanes<Offer<Word>> offers_;
    Lanes<Ray<Word>> rays_;
    DelayLine<Offer<Word>> shadedWaits_;
    SampleSlices<Arithmetic> slices_;
    OfferAcross<Arithmetic> across_;
    OfferAlong<Arithmetic> along_;
    Gradient<Arithmetic> gradient_;
    Shade<Arithmetic> shade_;
    Composite<Arithmetic> composite_;
    RayReturn<Arithmetic> return_;
    RayPlane<Word> entering_;
};

}  // namespace

template <class Arithmetic>
PassResult<typename Arithmetic::Word> runRender(const Arithmetic& arithmetic,
                                                VoxelMemory<typename Arithmetic::Word>& memory,
                                                const RenderInput<Arithmetic>& input, int pipelines, Trace* trace) {
    auto result = Machine<Arithmetic>(arithmetic, memory, input, pipelines, trace).run();
    result.counters.saturations = arithmetic.takeSaturations();
    requireNoConflicts(result.counters);
    return result;
}

template PassResult<float> runRender(const FloatArithmetic&, VoxelMemory<float>&, const RenderInput<FloatArithmetic>&,
                                     int, Trace*);
template PassResult<FixedPoint::Word> runRender(const FixedPoint&, VoxelMemory<FixedPoint::Word>&,
                                                const RenderInput<FixedPoint>&, int, Trace*);

}  // namespace raysweep::cube4
