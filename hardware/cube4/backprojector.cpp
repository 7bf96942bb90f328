#include "cube4/backprojector.h"

#include "cube4/arithmetic.h"
#include "cube4/delay_line.h"
#include "cube4/fixed_point.h"
#include "cube4/offer_across.h"
#include "cube4/offer_along.h"
#include "cube4/ray_along.h"
#include "cube4/ray_return.h"
#include "cube4/ray_update.h"
#include "cube4/sequencer.h"

#include "raysweep/core/error.h"

#include <array>
#include <string>

namespace raysweep::cube4 {
namespace {

template <class Arithmetic>
class Machine {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    Machine(const Arithmetic& arithmetic, VoxelMemory<Word>& memory, const PassInput<Arithmetic>& input, int pipelines,
            const PassOptions& options)
        : arithmetic_(arithmetic),
          memory_(memory),
          input_(input),
          options_(options),
          pass_(input.setup.pass),
          sequencer_(input.traversal, input.slices, pipelines, intervalOf(pass_, options)),
          shape_(shapeOf(pipelines, sequencer_.parts(), input.traversal.reach > 0, pass_)),
          buffer_(input.traversal, pipelines, diverges()),
          readVoxels_(std::size_t(pipelines)),
          readRays_(std::size_t(pipelines)),
          voxelsWait_(pipelines, 3),
          rayAcross_(shape_),
          rayAlong_(shape_),
          exchange_(shape_, input.setup),
          writesWait_(pipelines, 1),
          endingWait_(pipelines, 2),
          offerAcross_(shape_),
          offerAlong_(shape_),
          rayUpdate_(pipelines, pass_),
          return_(shape_, diverges()) {
        // A ray that comes from a point and does not meet this part of the volume leaves as it came.
        result_.leaving = diverges() ? input.entering : RayPlane<Word>(input.traversal, input.slices);
    }

    PassResult<Word> run() {
        while (!sequencer_.done() || underWay_ > 0) tick();
        result_.raysEntered = buffer_.entered();
        result_.largestRay = rayUpdate_.largest;
        result_.rayWords = buffer_.raysPerPipeline() * std::size_t(shape_.rayWords);
        result_.bufferWords = rayAlong_.bufferWords() + offerAlong_.bufferWords() + return_.bufferWords();
        return std::move(result_);
    }

  private:
    /// Cycles from one partial beam to the next.
    static int intervalOf(Pass pass, const PassOptions& options) {
        if (pass == Pass::project) return 1;
        return options.overlap ? 2 : 4;
    }

    bool diverges() const { return input_.slices.front().diverges(); }

    static StageShape shapeOf(int pipelines, int parts, bool linear, Pass pass) {
        return {pipelines, parts, linear, pass == Pass::illuminate ? 1 : 2, pass == Pass::backproject ? 0 : 2};
    }

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
        return_.tick(rayUpdate_.out, rayUpdate_.rays, counters);
        const Lanes<typename RayAcross<Arithmetic>::Rays>& ending = endingWait_.pass(exchange_.rays);
        rayUpdate_.tick(arithmetic_, offerAlong_.out, ending, offerAlong_.offers, input_.traversal, buffer_,
                        result_.leaving);
        offerAlong_.tick(arithmetic_, offerAcross_.out, offerAcross_.offers, counters);
        writeVoxels();
        offerAcross_.tick(arithmetic_, exchange_.out, exchange_.offers, counters);
        exchange_.tick(arithmetic_, rayAlong_.out, voxelsWait_.pass(readVoxels_), rayAlong_.rays);
        rayAlong_.tick(arithmetic_, rayAcross_.out, rayAcross_.rays, counters);
        rayAcross_.tick(arithmetic_, raysRead_, readRays_, counters);
        raysRead_ = voxelsRead_;
        if (raysRead_) buffer_.read(raysRead_, 0, input_.traversal, input_.entering, readRays_, counters);
        voxelsRead_ = sequencer_.out;
        if (voxelsRead_) memory_.read(voxelsRead_, input_.traversal, readVoxels_, counters);
        sequencer_.tick(return_.out(), counters);
        if (sequencer_.out) ++underWay_;
        if (!options_.overlap) checkPort();
        if (options_.trace) record(*options_.trace);
    }

    /// One port for voxels and rays: one of the four accesses in a cycle.
    void checkPort() {
        Counters& n = result_.counters;
        const std::array<std::uint64_t, 4> used = {n.voxelReads, n.voxelWrites, n.rayReads, n.rayWrites};
        int accesses = 0;
        for (std::size_t i = 0; i < used.size(); ++i) accesses += used[i] != portUsed_[i];
        if (accesses > 1) n.conflicts += std::uint64_t(accesses - 1);
        portUsed_ = used;
    }

    /// Where voxels and rays share a port, a cycle later: that is when it is free.
    void writeVoxels() {
        if (pass_ == Pass::project) return;
        if (options_.overlap) {
            if (exchange_.out) memory_.write(exchange_.out, input_.traversal, exchange_.voxels, result_.counters);
            return;
        }
        const Lanes<Voxel<Word>>& waited = writesWait_.pass(exchange_.voxels);
        if (toWrite_) memory_.write(toWrite_, input_.traversal, waited, result_.counters);
        toWrite_ = exchange_.out;
    }

    void record(Trace& trace) const {
        recordTrace<Weight>(trace, {{"sequencer", &sequencer_.out},
                                    {"voxels read", &voxelsRead_},
                                    {"rays read", &raysRead_},
                                    {"ray_across", &rayAcross_.out},
                                    {"ray_along", &rayAlong_.out},
                                    {"exchange", &exchange_.out},
                                    {"offer_across", &offerAcross_.out},
                                    {"offer_along", &offerAlong_.out},
                                    {"ray_update", &rayUpdate_.out},
                                    {"router", &return_.out()}});
    }

    const Arithmetic& arithmetic_;
    VoxelMemory<Word>& memory_;
    const PassInput<Arithmetic>& input_;
    const PassOptions options_;
    const Pass pass_;
    PassResult<Word> result_;
    int underWay_ = 0;  ///< partial beams that were issued and whose rays are not back

    std::array<std::uint64_t, 4> portUsed_{};  ///< accesses up to the last cycle

    Sequencer<Weight> sequencer_;
    StageShape shape_;
    RayBuffer<Word> buffer_;
    Beam<Weight> voxelsRead_, raysRead_, toWrite_;
    Lanes<Voxel<Word>> readVoxels_;
    Lanes<Ray<Word>> readRays_;
    DelayLine<Voxel<Word>> voxelsWait_;
    RayAcross<Arithmetic> rayAcross_;
    RayAlong<Arithmetic> rayAlong_;
    Exchange<Arithmetic> exchange_;
    DelayLine<Voxel<Word>> writesWait_;
    DelayLine<typename RayAcross<Arithmetic>::Rays> endingWait_;
    OfferAcross<Arithmetic> offerAcross_;
    OfferAlong<Arithmetic> offerAlong_;
    RayUpdate<Arithmetic> rayUpdate_;
    RayReturn<Arithmetic> return_;
};

}  // namespace

void requireNoConflicts(const Counters& counters) {
    if (counters.conflicts > 0)
        throw Error("memory modules were used " + std::to_string(counters.conflicts) +
                    " times more than once in a cycle");
    if (counters.hazards > 0) throw Error(std::to_string(counters.hazards) + " rays were read before they were back");
}

template <class Arithmetic>
PassResult<typename Arithmetic::Word> runPass(const Arithmetic& arithmetic,
                                              VoxelMemory<typename Arithmetic::Word>& memory,
                                              const PassInput<Arithmetic>& input, int pipelines,
                                              const PassOptions& options) {
    auto result = Machine<Arithmetic>(arithmetic, memory, input, pipelines, options).run();
    result.counters.saturations = arithmetic.takeSaturations();
    requireNoConflicts(result.counters);
    return result;
}

template PassResult<float> runPass(const FloatArithmetic&, VoxelMemory<float>&, const PassInput<FloatArithmetic>&, int,
                                   const PassOptions&);
template PassResult<FixedPoint::Word> runPass(const FixedPoint&, VoxelMemory<FixedPoint::Word>&,
                                              const PassInput<FixedPoint>&, int, const PassOptions&);

}  // namespace raysweep::cube4
