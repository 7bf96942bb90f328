/// Arithmetic on denormal numbers is slow, and light that faint is nobody's.
#pragma once

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace raysweep {

/// While it lives, this thread takes denormal numbers for zero. Does nothing where the processor has no such mode.
class FlushDenormals {
  public:
#if defined(__SSE2__)
    FlushDenormals() : before_(_mm_getcsr()) {
        _mm_setcsr(before_ | kFlushToZero | kDenormalsAreZero);
    }
    ~FlushDenormals() {
        _mm_setcsr(before_);
    }

  private:
    static constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x0040;
    unsigned before_;
#else
    FlushDenormals() {}
#endif
  public:
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;
};

}  // namespace raysweep
