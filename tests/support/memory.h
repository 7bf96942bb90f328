/// What work takes in memory.
#pragma once

#include "raysweep/core/memory.h"

#include <malloc.h>

#include <cstddef>
#include <optional>

namespace raysweep::test {

/// Bytes by which what this process held rose while `work` ran; none where that says nothing: where the system does not
/// tell, and under sanitizers, which put red zones around what is held and keep what is freed.
template <class Work>
std::optional<std::size_t> bytesTaken(const Work& work) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    work();
    return {};
#else
    ::malloc_trim(0);  // what earlier work freed would be taken again without a trace
    resetPeak();
    const std::size_t before = residentBytes();
    work();
    const std::size_t peak = peakResidentBytes();
    if (peak == 0) return {};
    return peak > before ? peak - before : 0;
#endif
}

}  // namespace raysweep::test
