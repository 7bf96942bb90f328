#include "raysweep/reconstruct/photo_loss.h"

#include "raysweep/image/image_io.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raysweep {
namespace {

/// The sRGB curve and its slope by linear interpolation: error below 2e-5, where the curve is bent most.
class EncodingTable {
  public:
    EncodingTable() {
        for (int i = 0; i <= kSteps; ++i) values_[std::size_t(i)] = srgbFromLinear(float(i) / kSteps);
        values_[kSteps + 1] = 2 * values_[kSteps] - values_[kSteps - 1];
    }

    struct Encoded {
        float value, slope;
    };
    /// Goes on straight above 1, so that what is too bright has a slope.
    Encoded at(float linear) const {
        const float place = std::max(linear, 0.0f) * kSteps;
        const std::size_t below = std::size_t(std::min(place, float(kSteps)));
        const float slope = values_[below + 1] - values_[below];
        return {values_[below] + (place - float(below)) * slope, slope * kSteps};
    }

  private:
    static constexpr int kSteps = 4096;
    std::array<float, kSteps + 2> values_;
};

const EncodingTable& encoding() {
    static const EncodingTable table;
    return table;
}

constexpr float kLeastAlpha = 1e-3f;  ///< below, colour is what there is over this: it must have some size

}  // namespace

PixelTarget pixelTarget(const float* pixel) {
    PixelTarget target;
    target.alpha = pixel[3];
    if (pixel[3] <= 0) return target;
    for (int c = 0; c < 3; ++c) target.color[c] = encoding().at(pixel[c] / pixel[3]).value * pixel[3];
    return target;
}

std::array<float, 4> pixelResidual(const PixelTarget& target, const RayColor& seen, const Backdrops& backdrops) {
    const float alpha = 1 - seen.transmittance, over = 1 / std::max(alpha, kLeastAlpha);
    const float alphaError = alpha - target.alpha;
    const float* colors = &seen.red;
    std::array<float, 4> residual;
    for (std::size_t c = 0; c < 3; ++c)
        residual[c] = encoding().at(colors[c] * over).value * alpha - target.color[c] - backdrops.mean * alphaError;
    residual[3] = std::sqrt(3 * backdrops.variance) * alphaError;
    return residual;
}

float pixelLoss(const PixelTarget& target, const RayColor& seen, const Backdrops& backdrops, RayColor& derivative) {
    const float alpha = 1 - seen.transmittance, over = 1 / std::max(alpha, kLeastAlpha);
    const float alphaError = alpha - target.alpha;
    const float* colors = &seen.red;
    float* slopes = &derivative.red;
    float byAlpha = 6 * backdrops.variance * alphaError;
    float loss = 3 * backdrops.variance * alphaError * alphaError;
    for (int c = 0; c < 3; ++c) {
        const float straight = colors[c] * over;
        const EncodingTable::Encoded encoded = encoding().at(straight);
        const float error = encoded.value * alpha - target.color[c];
        const float difference = 2 * (error - backdrops.mean * alphaError);
        slopes[c] = difference * encoded.slope * alpha * over;
        byAlpha += difference * (encoded.value - (alpha > kLeastAlpha ? straight * encoded.slope : 0) - backdrops.mean);
        loss += difference * difference / 4;
    }
    derivative.transmittance = -byAlpha;
    return loss;
}

}  // namespace raysweep
