/// The only place that sees oneTBB. Every sum made here is the same for any number of threads.
#pragma once

#include "raysweep/core/task_order.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <atomic>
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

/// Threads that may work at the same time.
inline int threadCount() {
    using Control = oneapi::tbb::global_control;
    return std::min(int(Control::active_value(Control::max_allowed_parallelism)),
                    oneapi::tbb::this_task_arena::max_concurrency());
}

/// Calls `body(i)` for every i in [0, count), several at a time, in pieces of about `grain` or more.
template <class Body>
void parallelFor(std::size_t count, const Body& body, std::size_t grain = 1) {
    using Range = oneapi::tbb::blocked_range<std::size_t>;
    detail::TaskOrder order;
    order.tasksFollow();
    oneapi::tbb::parallel_for(Range(0, count, grain), [&](const Range& range) {
        order.taskBegins();
        for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
        order.taskEnds();
    });
    order.allHaveEnded();
}

/// Calls `body(i, j)` for every cell of a table of `rows` x `columns`, each after the cells (i-1, j) and (i, j-1).
/// There is no other order, and no barrier.
template <class Body>
void parallelWavefront(int rows, int columns, const Body& body) {
    if (rows <= 0 || columns <= 0) return;
    std::vector<std::atomic<int>> waitsFor(std::size_t(rows) * std::size_t(columns));
    const auto at = [&](int i, int j) { return std::size_t(i) * std::size_t(columns) + std::size_t(j); };
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) waitsFor[at(i, j)] = (i > 0) + (j > 0);
    detail::TaskOrder order;
    oneapi::tbb::task_group group;
    const auto isReady = [&](int i, int j) { return i < rows && j < columns && --waitsFor[at(i, j)] == 0; };
    // Goes on to the next row as long as it can: what the cell has left in the cache is needed there.
    const auto run = [&](const auto& self, int i, int j) -> void {
        for (;;) {
            // By this ThreadSanitizer sees that the cells before this one are done: oneTBB hands tasks over unseen.
            waitsFor[at(i, j)].load(std::memory_order_acquire);
            body(i, j);
            const bool down = isReady(i + 1, j), aside = isReady(i, j + 1);
            if (down && aside)
                group.run([&self, &order, i, j]() RAYSWEEP_NOT_UNDER_TSAN {
                    order.taskBegins();
                    self(self, i, j + 1);
                });
            if (!down && !aside) break;
            down ? ++i : ++j;
        }
        order.taskEnds();
    };
    order.tasksFollow();
    group.run_and_wait([&] { run(run, 0, 0); });
    order.allHaveEnded();
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
