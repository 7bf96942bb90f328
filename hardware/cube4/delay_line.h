/// Registers that hold what has to wait for the stages beside it.
#pragma once

#include "cube4/words.h"

#include <utility>

namespace raysweep::cube4 {

template <class T>
class DelayLine {
  public:
    /// @param cycles at least 1
    DelayLine(int pipelines, int cycles) : registers_(std::size_t(cycles), Lanes<T>(std::size_t(pipelines))) {}

    /// Once in a cycle: takes `in`, and gives what was taken `cycles` cycles ago.
    Lanes<T>& pass(Lanes<T>& in) {
        std::swap(in, registers_[next_]);
        next_ = next_ + 1 == registers_.size() ? 0 : next_ + 1;
        return in;
    }

  private:
    std::vector<Lanes<T>> registers_;
    std::size_t next_ = 0;
};

}  // namespace raysweep::cube4
