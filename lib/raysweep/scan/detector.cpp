#include "raysweep/scan/detector.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace raysweep {
namespace {

void addNoise(Projections& projections, double photons, std::uint32_t seed) {
    parallelFor(std::size_t(projections.views), [&](std::size_t view) {
        std::mt19937_64 random(std::uint64_t(seed) << 32 | view);
        float* values = projections.view(int(view));
        for (std::size_t i = 0; i < projections.pixelsPerView(); ++i) {
            const double expected = photons * std::exp(-double(values[i]));
            if (!(expected >= 0)) continue;  // not measured
            // Beyond 1e8 the distribution is the normal one, and integers run out of room.
            const double counted = expected < 1e8
                                       ? double(std::poisson_distribution<long long>(expected)(random))
                                       : expected + std::sqrt(expected) * std::normal_distribution<double>()(random);
            values[i] = float(-std::log(std::max(counted, 0.5) / photons));
        }
    });
}

}  // namespace

void DetectorModel::validate() const {
    requireField(photons >= 0 && std::isfinite(photons), "detector photons", photons,
                 "0 (no noise) or more, and finite");
    requireField(saturation >= 0 && std::isfinite(saturation), "detector saturation", saturation,
                 "0 (none) or more, and finite");
    requireField(bits >= 0 && bits <= 24, "detector bits", bits, "0 (no rounding) to 24");
}

void detect(Projections& projections, const DetectorModel& model) {
    model.validate();
    if (model.photons > 0) addNoise(projections, model.photons, model.seed);
    if (model.saturation > 0) {
        projections.saturation = float(model.saturation);
        for (float& value : projections.values) value = std::min(value, projections.saturation);
    }
    if (model.bits > 0) {
        const float most = largestValue(projections);
        const float levels = float((1 << model.bits) - 1);
        if (most > 0)
            for (float& value : projections.values)
                if (!std::isnan(value))
                    value = std::round(std::clamp(value / most, 0.0f, 1.0f) * levels) / levels * most;
    }
}

}  // namespace raysweep
