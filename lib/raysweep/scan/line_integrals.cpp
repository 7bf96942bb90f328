#include "raysweep/scan/line_integrals.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace raysweep {
namespace {

constexpr float kUnmeasured = std::numeric_limits<float>::quiet_NaN();

void requireFrame(const std::vector<float>& frame, const char* name, const Projections& counts) {
    if (frame.size() != counts.pixelsPerView())
        throw InvalidArgument(std::string("the ") + name + " frame has " + std::to_string(frame.size()) +
                              " values, but the detector has " + std::to_string(counts.width) + "x" +
                              std::to_string(counts.height) + " pixels");
}

/// flat - dark; 0 for dead pixels.
std::vector<float> gains(const std::vector<float>& flat, const std::vector<float>& dark, double deadGain) {
    std::vector<float> gain(flat.size()), alive;
    for (std::size_t p = 0; p < gain.size(); ++p) {
        gain[p] = flat[p] - dark[p];
        if (!(gain[p] > 0) || !std::isfinite(gain[p])) gain[p] = 0;
        if (gain[p] > 0) alive.push_back(gain[p]);
    }
    if (alive.empty())
        throw InvalidArgument(
            "no pixel counts more without object (flat) than without beam (dark); are the frames swapped?");
    const auto middle = alive.begin() + std::ptrdiff_t(alive.size() / 2);
    std::nth_element(alive.begin(), middle, alive.end());
    for (float& g : gain)
        if (g < deadGain * *middle) g = 0;
    return gain;
}

/// In place: one view.
void toLineIntegrals(float* view, const std::vector<float>& gain, const std::vector<float>& dark,
                     double minimumTransmission, float saturation) {
    for (std::size_t p = 0; p < gain.size(); ++p) {
        if (gain[p] == 0 || !std::isfinite(view[p])) {
            view[p] = kUnmeasured;
            continue;
        }
        const double transmission = (double(view[p]) - dark[p]) / gain[p];
        const float value = transmission > minimumTransmission ? float(-std::log(transmission)) : saturation;
        view[p] = std::min(value, saturation);
    }
}

}  // namespace

void LineIntegralOptions::validate() const {
    requireField(minimumTransmission > 0 && minimumTransmission < 1, "minimumTransmission", minimumTransmission,
                 "above 0 and below 1");
    requireField(deadGain >= 0 && deadGain < 1, "deadGain", deadGain, "at least 0 and below 1");
}

LineIntegrals lineIntegrals(Projections counts, const std::vector<float>& flat, const std::vector<float>& dark,
                            const LineIntegralOptions& options) {
    options.validate();
    requireFrame(flat, "flat", counts);
    requireFrame(dark, "dark", counts);
    const std::vector<float> gain = gains(flat, dark, options.deadGain);
    LineIntegrals result;
    result.projections = std::move(counts);
    result.projections.saturation = float(-std::log(options.minimumTransmission));
    result.deadPixels = std::size_t(std::count(gain.begin(), gain.end(), 0.0f));
    parallelFor(std::size_t(result.projections.views), [&](std::size_t n) {
        toLineIntegrals(result.projections.view(int(n)), gain, dark, options.minimumTransmission,
                        result.projections.saturation);
    });
    return result;
}

}  // namespace raysweep
