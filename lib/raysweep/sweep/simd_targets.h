/// Which instruction sets kernels are compiled for. Included before Highway.
#pragma once

// Machines with SSSE3 but not SSE4 are gone; every instruction set costs compile time.
#define HWY_DISABLED_TARGETS HWY_SSSE3
