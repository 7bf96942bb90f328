/// ThreadSanitizer's view of tasks. oneTBB's library is not instrumented: the sanitizer does not see that a task begins
/// after what its parent did before, nor that it has ended when the parent goes on, so it is told. Nothing in other
/// builds.
#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#define RAYSWEEP_NOT_UNDER_TSAN __attribute__((no_sanitize("thread")))
#else
#define RAYSWEEP_NOT_UNDER_TSAN
#endif

namespace raysweep::detail {

/// Between a parent and its tasks; tasks are not ordered among themselves by it.
class TaskOrder {
  public:
#if defined(__SANITIZE_THREAD__)
    void tasksFollow() {
        __tsan_release(&begun_);
    }
    void taskBegins() {
        __tsan_acquire(&begun_);
    }
    void taskEnds() {
        __tsan_release(&ended_);
    }
    void allHaveEnded() {
        __tsan_acquire(&ended_);
    }

  private:
    char begun_ = 0, ended_ = 0;
#else
    void tasksFollow() {}
    void taskBegins() {}
    void taskEnds() {}
    void allHaveEnded() {}
#endif
};

}  // namespace raysweep::detail
