#include "raysweep/reconstruct/voxel_fit.h"

#include <cmath>
#include <vector>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/reconstruct/voxel_fit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/four_floats-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// Extinction first, then three times colour.
HWY_INLINE Four extinctionAndColor(float extinction, float color) {
    return firstOf(setFour(extinction), setFour(color));
}

constexpr int kEdge = 10;  ///< a brick and its neighbours' voxels

/// A brick, and before each of its faces the voxels of its neighbour; colours as square roots. Edges and corners are
/// not set.
struct Surroundings {
    HWY_ALIGN float values[kEdge * kEdge * kEdge][4];
    HWY_ALIGN float kept[kEdge * kEdge * kEdge];

    static int index(int x, int y, int z) { return (x * kEdge + y) * kEdge + z; }

    HWY_INLINE void fill(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t b) {
        for (int x = 0; x < 8; ++x)
            for (int y = 0; y < 8; ++y)
                for (int z = 0; z < 8; ++z) set(layout, voxels, b, {x, y, z}, index(x + 1, y + 1, z + 1));
        for (int axis = 0; axis < 3; ++axis)
            for (const int side : {-1, 1}) fillFace(layout, voxels, b, axis, side);
    }

  private:
    HWY_INLINE void fillFace(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t b, int axis,
                             int side) {
        Index3 beside = layout.origins[b];
        beside[axis] += 8 * side;
        const std::size_t neighbour = layout.voxel(beside) >> 9;
        const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
        Index3 from, to;
        from[axis] = side < 0 ? 7 : 0;
        to[axis] = side < 0 ? 0 : kEdge - 1;
        for (int u = 0; u < 8; ++u)
            for (int v = 0; v < 8; ++v) {
                from[first] = u, from[second] = v;
                to[first] = u + 1, to[second] = v + 1;
                set(layout, voxels, neighbour, from, index(to.x, to.y, to.z));
            }
    }

    HWY_INLINE void set(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t brick,
                        const Index3& from, int to) {
        const std::size_t within = std::size_t(from.x << 6 | from.y << 3 | from.z);
        const Four value = loadFour(&voxels[brick << 9 | within].extinction);
        storeFour(firstOf(value, rootOf(value)), values[to]);
        kept[to] = isSet(layout.masks[brick], from.x, from.y, from.z) ? 1.0f : 0.0f;
    }
};

}  // namespace

void stepBrickDispatched(CompositeVoxel* HWY_RESTRICT voxels, CompositeVoxel* HWY_RESTRICT gradient,
                         AdamMoments* HWY_RESTRICT moments, const FittedVoxels& fitted, const AdamStep& step) {
    const Four rate = extinctionAndColor(step.extinctionRate * step.correction1, step.colorRate * step.correction1);
    const Four decay1 = setFour(step.decay1), decay2 = setFour(step.decay2), correction2 = setFour(step.correction2);
    const Four least = extinctionAndColor(0, kLeastRoot), most = extinctionAndColor(step.mostExtinction, 1);
    const Four clear = extinctionAndColor(0, 1);
    const Four zero = setFour(0), tiny = setFour(1e-12f), two = setFour(2);
    for (int i = 0; i < 512; ++i) {
        float* slopes = &gradient[i].extinction;
        Four slope = loadFour(slopes);
        if (isZero(slope)) continue;
        storeFour(zero, slopes);
        if (!(fitted.colored[std::size_t(i >> 6)] >> (i & 63) & 1)) continue;
        const bool isSolid = (fitted.solid[std::size_t(i >> 6)] >> (i & 63) & 1) != 0;
        const Four value = loadFour(&voxels[i].extinction), root = rootOf(value);
        slope = firstOf(slope, slope * root * two);
        AdamMoments& moment = moments[i];
        const Four before1 = loadFour(&moment.first.extinction), before2 = loadFour(&moment.second.extinction);
        const Four mean = mulAdd(decay1, before1 - slope, slope);
        const Four square = slope * slope, meanSquare = mulAdd(decay2, before2 - square, square);
        storeFour(mean, &moment.first.extinction);
        storeFour(meanSquare, &moment.second.extinction);
        const Four change = rate * mean / (rootOf(meanSquare * correction2) + tiny);
        const Four after = leastOf(mostOf(firstOf(value, root) - change, least), isSolid ? most : clear);
        storeFour(firstOf(after, after * after), &voxels[i].extinction);
    }
}

void smoothBrickDispatched(const CompositeLayout& layout, const CompositeVoxel* HWY_RESTRICT voxels, std::size_t b,
                           const SmoothWeights& weights, CompositeVoxel* HWY_RESTRICT gradient) {
    static thread_local Surroundings around;
    around.fill(layout, voxels, b);
    const Four weight = extinctionAndColor(weights.extinction, weights.color);
    const Four scale = extinctionAndColor(weights.extinctionScale, weights.colorScale), scale2 = scale * scale;
    const Four least = setFour(kLeastRoot), half = setFour(0.5f);
    const int to[6] = {1, -1, kEdge, -kEdge, kEdge * kEdge, -kEdge * kEdge};
    for (int i = 0; i < 512; ++i) {
        const int at = Surroundings::index((i >> 6) + 1, (i >> 3 & 7) + 1, (i & 7) + 1);
        if (around.kept[at] == 0) continue;
        const Four value = loadFour(around.values[at]);
        Four slope = setFour(0);
        for (const int n : to) {
            const Four difference = value - loadFour(around.values[at + n]);
            slope = mulAdd(difference / rootOf(mulAdd(difference, difference, scale2)), setFour(around.kept[at + n]),
                           slope);
        }
        slope = slope * weight;
        const float extinction = around.values[at][0];
        const Four sparse = setFour(weights.sparsity * 4 * extinction / (1 + 2 * extinction * extinction));
        float* total = &gradient[std::size_t(i)].extinction;
        const Four given = loadFour(total);
        storeFour(firstOf(given + slope + sparse, mulAdd(slope, half / mostOf(value, least), given)), total);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(stepBrickDispatched);
HWY_EXPORT(smoothBrickDispatched);

void stepBrick(CompositeVoxel* voxels, CompositeVoxel* gradient, AdamMoments* moments, const FittedVoxels& fitted,
               const AdamStep& step) {
    HWY_DYNAMIC_DISPATCH(stepBrickDispatched)(voxels, gradient, moments, fitted, step);
}

void smoothBrick(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t b,
                 const SmoothWeights& weights, CompositeVoxel* gradient) {
    HWY_DYNAMIC_DISPATCH(smoothBrickDispatched)(layout, voxels, b, weights, gradient);
}

double smoothingHelps(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t b,
                      const CompositeVoxel* gradient, const AdamMoments* moments) {
    SmoothWeights unit;
    unit.color = 1;
    std::vector<CompositeVoxel> rough(512);
    smoothBrick(layout, voxels, b, unit, rough.data());
    double sum = 0;
    for (std::size_t i = 0; i < 512; ++i)
        for (int c = 0; c < 3; ++c) {
            const float moment = (&moments[i].second.red)[c];
            if (!(moment > 0)) continue;
            // Colours move in their roots: both derivatives are times 2 root.
            const float square = 4 * (&voxels[b * 512 + i].red)[c];
            sum += double(square) * (&gradient[i].red)[c] * (&rough[i].red)[c] / std::sqrt(moment);
        }
    return sum;
}

}  // namespace raysweep
#endif  // HWY_ONCE
