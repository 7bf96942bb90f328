/// Steps of a fit of extinction and colour, brick by brick: Adam, and what keeps the volume smooth and sparse.
/// D. P. Kingma and J. Ba, "Adam: A Method for Stochastic Optimization", ICLR 2015.
#pragma once

#include "raysweep/projector/composite_volume.h"

#include <cstddef>

namespace raysweep {

constexpr float kLeastRoot = 0.02f;  ///< of a colour: at 0 it could not move any more

/// Running means of a voxel's derivative and of its square.
struct AdamMoments {
    CompositeVoxel first, second;
};

struct AdamStep {
    float extinctionRate = 0, colorRate = 0;  ///< length of a step whose derivatives agree; colour: of its square root
    float decay1 = 0.9f, decay2 = 0.99f;      ///< of the means from one update to the next
    float correction1 = 1, correction2 = 1;   ///< 1 / (1 - decay^updates)
    float mostExtinction = 100;               ///< 1 / edge of a voxel
};

/// Voxels of a brick that are fitted.
struct FittedVoxels {
    VoxelMask colored;  ///< in colour
    VoxelMask solid;    ///< and in extinction; that of others stays 0
};

/// Moves the voxels of a brick that are fitted and whose derivative is not 0, and clears all derivatives. Colour moves
/// in its square root, which is near to how displays encode it: steps there are alike to the eye, dark or bright.
void stepBrick(CompositeVoxel* voxels, CompositeVoxel* gradient, AdamMoments* moments, const FittedVoxels& fitted,
               const AdamStep& step);

/// Added to the loss for each voxel and each pair of neighbours.
struct SmoothWeights {
    float extinction = 0;  ///< times sqrt(difference^2 + extinctionScale^2), a total variation with a round tip
    float color = 0;       ///< the same of the square root of colours, colorScale
    float sparsity = 0;    ///< times log(1 + 2 extinction^2), extinction per voxel
    float extinctionScale = 0.05f, colorScale = 0.02f;
};

/// Adds to the derivatives of brick `b` what follows from SmoothWeights.
void smoothBrick(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t b,
                 const SmoothWeights& weights, CompositeVoxel* gradient);

/// What a step of Adam that lowers the total variation of colour, at weight 1, does to a loss: > 0 if it lowers that
/// too. Of brick `b`. @param gradient derivatives of the loss with respect to its voxels @param moments of its voxels
double smoothingHelps(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t b,
                      const CompositeVoxel* gradient, const AdamMoments* moments);

}  // namespace raysweep
