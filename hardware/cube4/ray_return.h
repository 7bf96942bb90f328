/// The way back of finished rays to the compositing buffer: one router for parallel rays, another where they diverge.
#pragma once

#include "cube4/diverging_router.h"
#include "cube4/router.h"

namespace raysweep::cube4 {

template <class Arithmetic>
class RayReturn {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    RayReturn(const StageShape& shape, bool diverging) : diverges_(diverging), parallel_(shape), diverging_(shape) {}

    /// Writes what has come. Call it first in a cycle. @return a partial beam is done
    bool write(RayBuffer<Word>& buffer, Counters& counters) {
        if (diverges_) {
            diverging_.write(buffer, counters);
            return bool(diverging_.out());
        }
        if (!parallel_.out()) return false;
        for (std::size_t lane = 0; lane < parallel_.rays().size(); ++lane) {
            const FinishedRay<Word>& ray = parallel_.rays()[lane];
            if (ray.slot >= 0) buffer.write(lane, ray, counters);
        }
        return true;
    }

    /// Nothing must move in this cycle.
    bool isFull() const { return diverges_ && diverging_.isFull(); }

    void tick(const Beam<Weight>& beam, Lanes<FinishedRay<Word>>& in, Counters& counters) {
        if (diverges_)
            diverging_.tick(beam, in, counters);
        else
            parallel_.tick(beam, in, counters);
    }

    /// The last partial beam whose rays are back.
    const Beam<Weight>& out() const { return diverges_ ? diverging_.out() : parallel_.out(); }

    std::size_t bufferWords() const { return diverges_ ? diverging_.bufferWords() : 0; }

  private:
    bool diverges_;
    Router<Arithmetic> parallel_;
    DivergingRouter<Arithmetic> diverging_;
};

}  // namespace raysweep::cube4
