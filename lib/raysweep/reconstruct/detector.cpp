#include "raysweep/reconstruct/detector.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>

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
    const auto require = [](bool good, const char* field, double value, const char* bound) {
        if (good) return;
        std::ostringstream message;
        message << "detector " << field << " " << value << ": must be " << bound;
        throw InvalidArgument(message.str());
    };
    require(photons >= 0 && std::isfinite(photons), "photons", photons, "0 (no noise) or more, and finite");
    require(saturation >= 0 && std::isfinite(saturation), "saturation", saturation, "0 (none) or more, and finite");
    require(bits >= 0 && bits <= 24, "bits", bits, "0 (no rounding) to 24");
}

void detect(Projections& projections, const DetectorModel& model) {
    model.validate();
    if (model.photons > 0) addNoise(projections, model.photons, model.seed);
    if (model.saturation > 0) {
        projections.saturation = float(model.saturation);
        for (float& value : projections.values) value = std::min(value, projections.saturation);
    }
    if (model.bits > 0) {
        float most = 0;
        for (const float value : projections.values)
            if (value > most) most = value;
        const float levels = float((1 << model.bits) - 1);
        if (most > 0)
            for (float& value : projections.values)
                if (!std::isnan(value))
                    value = std::round(std::clamp(value / most, 0.0f, 1.0f) * levels) / levels * most;
    }
}

}  // namespace raysweep
