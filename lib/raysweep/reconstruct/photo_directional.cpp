#include "raysweep/reconstruct/photo_directional.h"

#include "raysweep/core/parallel.h"
#include "raysweep/reconstruct/photo_views.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raysweep {
namespace {

constexpr float kScale = SmoothWeights().colorScale;  ///< round tip of total variation

using Direction = std::array<float, 3>;

Direction directionTo(const ViewPoint& from, const Index3& voxel) {
    if (from.parallel) return {float(from.direction.x), float(from.direction.y), float(from.direction.z)};
    const float x = float(voxel.x - from.place.x), y = float(voxel.y - from.place.y), z = float(voxel.z - from.place.z);
    const float unit = 1 / std::sqrt(x * x + y * y + z * z);
    return {x * unit, y * unit, z * unit};
}

/// 2 root of c₀: what u is multiplied by.
Direction scalesOf(const CompositeVoxel& voxel) {
    const auto scale = [](float color) { return 2 * std::max(std::sqrt(color), kLeastRoot); };
    return {scale(voxel.red), scale(voxel.green), scale(voxel.blue)};
}

}  // namespace

ViewPoint viewPoint(const PhotoCamera& camera, const ReconstructionGrid& grid) {
    ViewPoint from;
    from.parallel = camera.projection == Camera::Projection::Orthographic;
    from.place = (camera.position - grid.voxel(0, 0, 0)) / grid.edge();
    from.direction = camera.forward;
    return from;
}

void showVoxels(const PhotoLevel& level, const ViewPoint& from, std::vector<CompositeVoxel>& shown) {
    shown.resize(level.voxels.size());  // what is not kept is and stays 0
    forKept(level.layout, [&](std::size_t i, const Index3& at) {
        const Direction d = directionTo(from, at);
        shown[i] = level.voxels[i];
        float* color = &shown[i].red;
        const ColorSlopes& slopes = level.slopes[i];
        for (int c = 0; c < 3; ++c)
            color[c] =
                std::max(0.0f, color[c] + d[0] * slopes.of[0][c] + d[1] * slopes.of[1][c] + d[2] * slopes.of[2][c]);
    });
}

void chainColors(const ViewPoint& from, const std::vector<CompositeVoxel>& shown, PhotoLevel& level) {
    forKept(level.layout, [&](std::size_t i, const Index3& at) {
        float* given = &level.gradient[i].red;
        if (given[0] == 0 && given[1] == 0 && given[2] == 0) return;
        const Direction d = directionTo(from, at);
        const float* color = &shown[i].red;
        for (int c = 0; c < 3; ++c) {
            if (!(color[c] > 0)) given[c] = 0;
            for (int axis = 0; axis < 3; ++axis) level.slopeGradient[i].of[axis][c] += d[std::size_t(axis)] * given[c];
        }
    });
}

void smoothSlopes(const SlopeWeights& weights, PhotoLevel& level) {
    const CompositeLayout& layout = level.layout;
    forKept(layout, [&](std::size_t i, const Index3& at) {
        const Direction scale = scalesOf(level.voxels[i]);
        float own[3][3], sum[3][3];
        for (int axis = 0; axis < 3; ++axis)
            for (int c = 0; c < 3; ++c) {
                own[axis][c] = level.slopes[i].of[axis][c] / scale[std::size_t(c)];
                const float u = own[axis][c];
                sum[axis][c] = weights.pull * u / std::sqrt(u * u + kScale * kScale);
            }
        for (int n = 0; n < 6 && weights.total > 0; ++n) {
            Index3 beside = at;
            beside[n >> 1] += (n & 1) != 0 ? 1 : -1;
            const std::size_t j = layout.voxel(beside);
            if (!layout.keeps(j)) continue;
            const Direction other = scalesOf(level.voxels[j]);
            for (int axis = 0; axis < 3; ++axis)
                for (int c = 0; c < 3; ++c) {
                    const float difference = own[axis][c] - level.slopes[j].of[axis][c] / other[std::size_t(c)];
                    sum[axis][c] += weights.total * difference / std::sqrt(difference * difference + kScale * kScale);
                }
        }
        for (int axis = 0; axis < 3; ++axis)
            for (int c = 0; c < 3; ++c) level.slopeGradient[i].of[axis][c] += sum[axis][c] / scale[std::size_t(c)];
    });
}

void stepSlopes(const AdamStep& step, PhotoLevel& level) {
    const float rate = step.colorRate * step.correction1;
    forKept(level.layout, [&](std::size_t i, const Index3&) {
        float* given = &level.slopeGradient[i].of[0][0];
        if (std::all_of(given, given + 9, [](float g) { return g == 0; })) return;
        const Direction scale = scalesOf(level.voxels[i]);
        float* values = &level.slopes[i].of[0][0];
        float *means = &level.slopeMoments[i].first.of[0][0], *squares = &level.slopeMoments[i].second.of[0][0];
        for (int n = 0; n < 9; ++n) {
            const float slope = given[n] * scale[std::size_t(n % 3)];
            means[n] = slope + step.decay1 * (means[n] - slope);
            squares[n] = slope * slope + step.decay2 * (squares[n] - slope * slope);
            values[n] -=
                scale[std::size_t(n % 3)] * rate * means[n] / (std::sqrt(squares[n] * step.correction2) + 1e-12f);
            given[n] = 0;
        }
    });
}

std::vector<CompositeVoxel> meanColors(const std::vector<Photograph>& photographs, PhotoLevel& level) {
    std::vector<CompositeVoxel> shown, sums(level.voxels.size());
    CompositeTape tape;
    PhotoRays rays;
    // The derivative of what all rays see of red, with respect to a voxel's red, is the voxel's part in them.
    const RayLoss red = [](std::size_t, std::size_t count, const RayColor*, RayColor* derivatives) {
        std::fill_n(derivatives, count, RayColor{0, 1, 0, 0});
    };
    for (const Photograph& photograph : picturesFor(photographs, level.grid)) {
        const ViewPoint from = viewPoint(photograph.camera, level.grid);
        showVoxels(level, from, shown);
        setRays(rays, photograph, level.grid, level.layout, 2, 0);
        level.gradient.assign(level.voxels.size(), {});
        compositeGradient(level.layout, shown.data(), rays.rays, red, tape, level.gradient.data());
        forKept(level.layout, [&](std::size_t i, const Index3&) {
            const float part = level.gradient[i].red;
            sums[i].extinction += part;
            sums[i].red += part * shown[i].red;
            sums[i].green += part * shown[i].green;
            sums[i].blue += part * shown[i].blue;
        });
    }
    level.gradient.assign(level.voxels.size(), {});
    forKept(level.layout, [&](std::size_t i, const Index3&) {
        const float parts = sums[i].extinction;
        const CompositeVoxel& voxel = level.voxels[i];
        sums[i] = parts > 0 ? CompositeVoxel{voxel.extinction, sums[i].red / parts, sums[i].green / parts,
                                             sums[i].blue / parts}
                            : voxel;
    });
    return sums;
}

}  // namespace raysweep
