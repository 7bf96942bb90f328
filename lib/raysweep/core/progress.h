/// How long work reports how far it is, and how it is asked to stop.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace raysweep {

/// Called now and then from the thread that called, with the stage's name, maybe ": " and how it goes, and the fraction
/// done in [0,1]. Returning false asks the work to stop at the next convenient place and to return what it has.
using ProgressCallback = std::function<bool(const std::string& stage, double fraction)>;

/// Reports to `callback` if there is one. @return false when the computation should stop.
inline bool report(const ProgressCallback& callback, const std::string& stage, double fraction) {
    return !callback || callback(stage, fraction);
}

/// Wall-clock seconds since construction.
class Timer {
  public:
    double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point start_ = Clock::now();
};

}  // namespace raysweep
