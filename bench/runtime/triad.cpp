#include "triad.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/progress.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

using namespace raysweep;

double triadBandwidth() {
    static const double best = [] {
        constexpr std::size_t kCount = 1 << 25, kChunk = 1 << 15;
        std::vector<float> a(kCount, 1.0f), b(kCount, 2.0f), c(kCount, 3.0f);
        double fastest = 1e30;
        for (int run = 0; run < 12; ++run) {
            const Timer timer;
            parallelFor(kCount / kChunk, [&](std::size_t chunk) {
                float* const to = a.data() + chunk * kChunk;
                const float* const x = b.data() + chunk * kChunk;
                const float* const y = c.data() + chunk * kChunk;
                for (std::size_t i = 0; i < kChunk; ++i) to[i] = x[i] + 0.5f * y[i];
            });
            fastest = std::min(fastest, timer.seconds());
            benchmark::DoNotOptimize(a.data());
        }
        return 3.0 * double(kCount) * sizeof(float) / fastest;
    }();
    return best;
}
