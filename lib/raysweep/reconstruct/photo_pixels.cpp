#include "raysweep/reconstruct/photo_pixels.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"

#include <algorithm>

namespace raysweep {
namespace {

bool isLeftOut(const PhotoPixels::Place& at, const PhotoFitOptions& options) {
    std::uint32_t h = options.seed * 0x9e3779b9u;
    for (const int c : {at.view, at.x / 8, at.y / 8}) {
        h = (h ^ std::uint32_t(c)) * 0x85ebca6bu;
        h ^= h >> 15;
    }
    return (h >> 8) * (1.0 / (1 << 24)) < options.leftOut;
}

}  // namespace

PhotoPixels::PhotoPixels(const std::vector<Photograph>& photographs) : photographs_(photographs) {
    std::uint64_t total = 0;
    for (const Photograph& photograph : photographs) {
        firsts_.push_back(std::uint32_t(total));
        total += std::uint64_t(photograph.matte.width) * std::uint64_t(photograph.matte.height);
    }
    requireField(total < (std::uint64_t(1) << 32), "pixels", total, "fewer than 2^32 in all pictures; reduce them");
    count_ = std::uint32_t(total);
}

int PhotoPixels::view(std::uint32_t pixel) const {
    return int(std::upper_bound(firsts_.begin(), firsts_.end(), pixel) - firsts_.begin() - 1);
}

PhotoPixels::Place PhotoPixels::place(std::uint32_t pixel) const {
    const int view = this->view(pixel);
    const Photograph& photograph = photographs_[std::size_t(view)];
    const int number = int(pixel - firsts_[std::size_t(view)]), width = photograph.matte.width;
    return {&photograph, view, number % width, number / width};
}

CompositeRay PhotoPixels::ray(std::uint32_t pixel, const PhotoLevel& level, int perSlice) const {
    const Place at = place(pixel);
    Ray ray = pixelRay(at.photograph->camera, at.x + 0.5, at.y + 0.5);
    ray.origin = (ray.origin - level.grid.voxel(0, 0, 0)) / level.grid.edge();
    return compositeRay(level.layout, ray, perSlice);
}

PixelTarget PhotoPixels::target(std::uint32_t pixel) const {
    const Place at = place(pixel);
    return pixelTarget(at.photograph->matte.at(at.x, at.y));
}

PixelSets pixelsMeeting(const PhotoPixels& pixels, const PhotoLevel& level, const PhotoFitOptions& options) {
    constexpr std::uint32_t kTogether = 4096;
    std::vector<PixelSets> parts((pixels.count() + kTogether - 1) / kTogether);
    parallelFor(parts.size(), [&](std::size_t n) {
        const std::uint32_t first = std::uint32_t(n) * kTogether;
        for (std::uint32_t p = first; p < std::min(pixels.count(), first + kTogether); ++p) {
            if (!meetsBricks(level.layout, pixels.ray(p, level, options.samplesPerSlice))) continue;
            (isLeftOut(pixels.place(p), options) ? parts[n].leftOut : parts[n].fitted).push_back(p);
        }
    });
    PixelSets all;
    for (const PixelSets& part : parts) {
        all.fitted.insert(all.fitted.end(), part.fitted.begin(), part.fitted.end());
        all.leftOut.insert(all.leftOut.end(), part.leftOut.begin(), part.leftOut.end());
    }
    return all;
}

void PhotoBatch::set(const PhotoPixels& all, const std::uint32_t* chosen, std::size_t count, const PhotoLevel& level,
                     int perSlice) {
    pixels.assign(chosen, chosen + count);
    std::sort(pixels.begin(), pixels.end());  // neighbours meet the same bricks
    unsorted_.resize(count);
    parallelFor(
        count, [&](std::size_t i) { unsorted_[i] = all.ray(pixels[i], level, perSlice); }, 256);
    order_.clear();
    for (int axis = 0; axis < 3; ++axis)
        for (std::size_t i = 0; i < count; ++i)
            if (unsorted_[i].axis == axis) order_.push_back(i);
    rays.resize(count);
    targets.resize(count);
    parallelFor(
        count,
        [&](std::size_t i) {
            rays[i] = unsorted_[order_[i]];
            targets[i] = all.target(pixels[order_[i]]);
        },
        256);
    errors.assign(count, 0);
}

double PhotoBatch::error() const {
    return orderedSum(
        errors.size(), [&](std::size_t i) { return double(errors[i]); }, 1024);
}

}  // namespace raysweep
