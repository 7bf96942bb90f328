/// The only place that sees oneTBB. Every sum made here is the same for any number of threads.
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace raysweep {

/// While it lives, at most `threads` threads work; 0 leaves the choice to oneTBB (all cores).
class ThreadLimit {
  public:
    explicit ThreadLimit(int threads)
        : control_(oneapi::tbb::global_control::max_allowed_parallelism,
                   threads > 0 ? static_cast<std::size_t>(threads)
                               : oneapi::tbb::global_control::active_value(
                                     oneapi::tbb::global_control::max_allowed_parallelism)) {}

  private:
    oneapi::tbb::global_control control_;
};

/// Calls `body(i)` for every i in [0, count), several at a time, in pieces of about `grain` or more.
template <class Body>
void parallelFor(std::size_t count, const Body& body, std::size_t grain = 1) {
    using Range = oneapi::tbb::blocked_range<std::size_t>;
    oneapi::tbb::parallel_for(Range(0, count, grain), [&](const Range& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
    });
}

/// Sum of `term(i)` over [0, count). Terms are added in the order of i within fixed chunks, and the chunks in
/// order, so the result has the same bits whatever the number of threads. `Value` needs += and a zero default.
template <class Value = double, class Term>
Value orderedSum(std::size_t count, const Term& term, std::size_t chunk = 64) {
    std::vector<Value> partial((count + chunk - 1) / chunk, Value{});
    parallelFor(partial.size(), [&](std::size_t c) {
        const std::size_t end = std::min(count, (c + 1) * chunk);
        Value sum{};
        for (std::size_t i = c * chunk; i < end; ++i) sum += term(i);
        partial[c] = sum;
    });
    Value total{};
    for (const Value& p : partial) total += p;
    return total;
}

}  // namespace raysweep
