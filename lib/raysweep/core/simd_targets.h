/// Which instruction sets kernels are compiled for. Included before Highway.
#pragma once

// Machines with SSSE3 but not SSE4 are gone; every instruction set costs compile time.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// Under sanitizers one with vectors and one without are enough; release builds test all.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3 | HWY_AVX3_DL)
#else
#define HWY_DISABLED_TARGETS HWY_SSSE3
#endif
