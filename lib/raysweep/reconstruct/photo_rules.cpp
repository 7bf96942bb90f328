#include "raysweep/reconstruct/photo_rules.h"

#include <algorithm>
#include <cmath>

namespace raysweep {

std::array<float, 3> missing(const std::array<float, 4>& pixel, const RayColor& seen) {
    return {pixel[0] - seen.red, pixel[1] - seen.green, pixel[2] - seen.blue};
}

std::array<float, 3> paperRule(const PhotoRays& rays, std::size_t r, const RaySamples& s, SampleShare* shares) {
    const auto& pixel = rays.pixels[r];
    const float part = 1 / (float(s.ray.count) * s.ray.length);
    const float opacity = pixel[3] - (1 - s.color.transmittance);
    for (std::size_t i = 0; i < s.count; ++i) {
        const float share = part * rays.shares[r].at(s.numbers[i]);
        shares[i] = {share * opacity, share};
    }
    return missing(pixel, s.color);
}

std::array<float, 3> consistentRule(const PhotoRays& rays, std::size_t r, float mostDepth, const RaySamples& s,
                                    SampleShare* shares) {
    const auto& pixel = rays.pixels[r];
    float opacities = kLeastOpacity * s.ray.length * float(s.count);
    for (std::size_t i = 0; i < s.count; ++i) opacities += 1 - s.transmittances[i + 1] / s.transmittances[i];
    const float depth = -std::log(std::max(s.color.transmittance, 1e-30f));
    const float asked = std::min(mostDepth, -std::log(std::max(1 - pixel[3], 1e-30f)));
    float change = asked - depth;
    if (asked >= mostDepth) change = std::max(change, 0.0f);
    change /= std::max(opacities, 1e-6f);
    shareColors(rays.shares[r], s, shares);
    for (std::size_t i = 0; i < s.count; ++i) shares[i].extinction = rays.shares[r].at(s.numbers[i]) * change;
    return missing(pixel, s.color);
}

}  // namespace raysweep
