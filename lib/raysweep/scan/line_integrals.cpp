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
        if (g < deadGain * *middle || g * deadGain * deadGain > *middle) g = 0;
    return gain;
}

/// What the counts of one pixel say.
struct Pixel {
    float value = kUnmeasured;
    RayBound bound = RayBound::none;
    bool implausible = false;
};

Pixel pixelOf(double count, double gain, double dark, const LineIntegralOptions& options) {
    if (gain == 0 || !std::isfinite(count)) return {};
    const double transmission = (count - dark) / gain;
    if (std::abs(transmission) > options.maximumTransmission) return {kUnmeasured, RayBound::none, true};
    const double least = std::max(options.minimumTransmission, options.leastCount / gain);
    if (!(transmission > least)) return {float(-std::log(least)), RayBound::atLeast};
    return {float(-std::log(transmission)), count >= options.saturatedAbove ? RayBound::atMost : RayBound::none};
}

/// What was found in one view. In place. @param bounds of the view
struct ViewFindings {
    std::size_t implausible = 0;
    bool bounded = false;  ///< some say no more than a bound that `saturation` does not
};

ViewFindings toLineIntegrals(float* view, RayBound* bounds, const std::vector<float>& gain,
                             const std::vector<float>& dark, const LineIntegralOptions& options) {
    const float saturation = float(-std::log(options.minimumTransmission));
    ViewFindings found;
    for (std::size_t p = 0; p < gain.size(); ++p) {
        const Pixel pixel = pixelOf(view[p], gain[p], dark[p], options);
        view[p] = std::min(pixel.value, saturation);  // NaN stays
        bounds[p] = pixel.bound;
        found.implausible += pixel.implausible;
        found.bounded = found.bounded || (pixel.bound != RayBound::none && view[p] < saturation);
    }
    return found;
}

}  // namespace

void LineIntegralOptions::validate() const {
    requireField(minimumTransmission > 0 && minimumTransmission < 1, "minimumTransmission", minimumTransmission,
                 "above 0 and below 1");
    requireField(leastCount >= 0 && std::isfinite(leastCount), "leastCount", leastCount, "0 or more, and finite");
    requireField(!std::isnan(saturatedAbove), "saturatedAbove", saturatedAbove, "a number");
    requireField(maximumTransmission > 1, "maximumTransmission", maximumTransmission, "above 1");
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
    result.projections.bounds.resize(result.projections.values.size());
    std::vector<ViewFindings> found(std::size_t(result.projections.views));
    const std::size_t pixels = gain.size();
    parallelFor(found.size(), [&](std::size_t n) {
        found[n] = toLineIntegrals(result.projections.view(int(n)), result.projections.bounds.data() + n * pixels, gain,
                                   dark, options);
    });
    bool bounded = false;
    for (const ViewFindings& view : found) {
        result.implausible += view.implausible;
        bounded = bounded || view.bounded;
    }
    if (!bounded) result.projections.bounds = std::vector<RayBound>();  // `= {}` would keep the memory
    return result;
}

}  // namespace raysweep
