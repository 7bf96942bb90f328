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

constexpr float kLeastRoot = 0.02f;  ///< of a colour: at 0 it could not move any more

constexpr int kEdge = 10;  ///< a brick and its neighbours' voxels

/// A brick with one voxel of its neighbours around it, colours as square roots.
struct Surroundings {
    HWY_ALIGN float values[kEdge * kEdge * kEdge][4];
    HWY_ALIGN float kept[kEdge * kEdge * kEdge];

    static int index(int x, int y, int z) { return (x * kEdge + y) * kEdge + z; }

    HWY_INLINE void set(const CompositeLayout& layout, const CompositeVoxel* voxels, const Index3& at, int to) {
        const std::size_t from = layout.voxel(at);
        const bool keeps = isSet(layout.masks[from >> 9], int(from >> 6 & 7), int(from >> 3 & 7), int(from & 7));
        const Four value = loadFour(&voxels[from].extinction);
        storeFour(firstOf(value, rootOf(value)), values[to]);
        kept[to] = keeps ? 1.0f : 0.0f;
    }

    HWY_INLINE void fill(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t b) {
        const Index3 origin = layout.origins[b];
        for (int x = 0; x < kEdge; ++x)
            for (int y = 0; y < kEdge; ++y)
                for (int z = 0; z < kEdge; ++z)
                    set(layout, voxels, origin + Index3(x - 1, y - 1, z - 1), index(x, y, z));
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
