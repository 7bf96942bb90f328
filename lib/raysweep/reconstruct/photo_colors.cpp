#include "raysweep/reconstruct/photo_colors.h"

#include "raysweep/core/shuffle.h"

#include <cmath>
#include <numeric>
#include <random>

namespace raysweep {
namespace {

constexpr int kCell = 2;  ///< voxels along an edge that have one colour: both sides of a thin sheet have the same

/// Sets the voxels of each cell of a brick to their mean, weighted by opacity.
void poolBrick(CompositeVoxel* voxels, const float* opacities) {
    for (int first = 0; first < 512; ++first) {
        if (((first >> 6) % kCell | (first >> 3 & 7) % kCell | (first & 7) % kCell) != 0) continue;
        CompositeVoxel sum;
        float weight = 0;
        const auto forCell = [&](const auto& body) {
            for (int x = 0; x < kCell; ++x)
                for (int y = 0; y < kCell; ++y)
                    for (int z = 0; z < kCell; ++z) body(std::size_t(first + (x << 6 | y << 3 | z)));
        };
        forCell([&](std::size_t i) {
            weight += opacities[i];
            sum.red += opacities[i] * voxels[i].red;
            sum.green += opacities[i] * voxels[i].green;
            sum.blue += opacities[i] * voxels[i].blue;
        });
        const float part = weight > 0 ? 1 / weight : 0;
        forCell([&](std::size_t i) {
            voxels[i] = {voxels[i].extinction, part * sum.red, part * sum.green, part * sum.blue};
        });
    }
}

}  // namespace

LitSheets litSheets(const PhotoSurfaces& surfaces) {
    LitSheets to{&surfaces, sheetNormals(surfaces.layout, surfaces.voxels), std::vector<float>(surfaces.voxels.size())};
    for (std::size_t i = 0; i < to.opacities.size(); ++i) to.opacities[i] = -std::expm1(-surfaces.voxels[i].extinction);
    return to;
}

ColorSolver::ColorSolver(const std::vector<Photograph>& pictures, const LitSheets& sheets)
    : pictures_(pictures),
      sheets_(sheets),
      rays_(pictures.size()),
      sums_(sheets.surfaces->layout.voxelCount()),
      shown_(sums_.size()),
      order_(pictures.size()) {
    for (std::size_t n = 0; n < pictures.size(); ++n)
        setRays(rays_[n], pictures[n], sheets.surfaces->grid, sheets.surfaces->layout, 1, 0);
    std::iota(order_.begin(), order_.end(), std::size_t(0));
    std::mt19937 random(1);
    shuffle(order_, random);
}

std::vector<CompositeVoxel> ColorSolver::black() const {
    std::vector<CompositeVoxel> colors(sums_.size());
    for (std::size_t i = 0; i < colors.size(); ++i) colors[i].extinction = sheets_.surfaces->voxels[i].extinction;
    return colors;
}

SheetLight ColorSolver::light(const LightState& state, std::size_t view) const {
    const Vec3 travels = carriedAlong(state.light, pictures_.front().camera, camera(view)).normalized();
    const Vec3& ahead = camera(view).forward;
    return {float(state.ambient),
            float(state.diffuse),
            {float(-travels.x), float(-travels.y), float(-travels.z)},
            {float(-ahead.x), float(-ahead.y), float(-ahead.z)}};
}

void ColorSolver::solve(const std::vector<RayPixels>& targets, const LightState& state, int passes,
                        std::vector<CompositeVoxel>& colors) {
    for (int pass = 0; pass < passes; ++pass)
        for (const std::size_t n : order_) update(targets[n], light(state, n), n, colors);
}

RayPixels ColorSolver::seen(const std::vector<CompositeVoxel>& colors, const SheetLight& light, std::size_t view) {
    lightAll(colors, light);
    return seen(shown_, view);
}

RayPixels ColorSolver::seen(const std::vector<CompositeVoxel>& colors, std::size_t view) {
    seen_.resize(rays_[view].rays.size());
    composite(sheets_.surfaces->layout, colors.data(), rays_[view].rays.data(), seen_.size(), seen_.data());
    RayPixels to;
    for (const RayColor& color : seen_) to.push_back({color.red, color.green, color.blue});
    return to;
}

void ColorSolver::lightAll(const std::vector<CompositeVoxel>& colors, const SheetLight& light) {
    forVoxels([&](std::size_t i) {
        const float f = SheetBrightness(sheets_.normals[i], light).all;
        shown_[i] = {colors[i].extinction, f * colors[i].red, f * colors[i].green, f * colors[i].blue};
    });
}

void ColorSolver::update(const RayPixels& target, const SheetLight& light, std::size_t view,
                         std::vector<CompositeVoxel>& colors) {
    lightAll(colors, light);
    const auto rule = [&](std::size_t r, const RaySamples& samples, SampleShare* shares) {
        shareColors(rays_[view].shares[r], samples, shares);
        return std::array<float, 3>{target[r][0] - samples.color.red, target[r][1] - samples.color.green,
                                    target[r][2] - samples.color.blue};
    };
    compositeSpread(sheets_.surfaces->layout, shown_.data(), rays_[view].rays, rule, tape_, sums_.data());
    parallelFor(sheets_.surfaces->layout.brickCount() - 1, [&](std::size_t n) {
        const std::size_t first = (n + 1) * 512;
        for (std::size_t i = first; i < first + 512; ++i) {
            const float f = SheetBrightness(sheets_.normals[i], light).all;
            sums_[i] = {0, f * sums_[i].red, f * sums_[i].green, f * sums_[i].blue};
        }
        poolBrick(&sums_[first], &sheets_.opacities[first]);
        for (std::size_t i = first; i < first + 512; ++i) {
            colors[i].red += sums_[i].red;
            colors[i].green += sums_[i].green;
            colors[i].blue += sums_[i].blue;
            sums_[i] = {};
        }
    });
}

}  // namespace raysweep
