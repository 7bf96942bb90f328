/// The forward path: rendering as Cube-4 does it (Pfister and Kaufman 1996; paper, section 4), one voxel for each
/// pipeline in a cycle.
///
///     sequencer -> voxels read -> sample_slices -> offer_across -> offer_along -> [gradient] -> shade
///                                                                                                 |
///                                                  rays written <- router <- composite <- rays read
#pragma once

#include "cube4/backprojector.h"
#include "cube4/shade.h"

namespace raysweep::cube4 {

template <class Arithmetic>
struct RenderInput {
    /// Of a memory with `reach` empty voxels around its content: 1, with shading 2.
    const Traversal& traversal;
    /// renderSlices
    const std::vector<SliceSetup<typename Arithmetic::Weight>>& slices;
    const ShadeSetup<typename Arithmetic::Word>& setup;
    Between<typename Arithmetic::Weight> between;  ///< of a slice and the next, for samples that lie between them
    bool inSlices = true;                          ///< samples lie in slices
    /// What rays carry when they enter, C and T; null: 0 and 1.
    const RayPlane<typename Arithmetic::Word>* entering = nullptr;
};

/// Slices by which samples that are composited are behind the voxels that are read.
inline int renderDelay(bool inSlices, bool lambert) {
    return (inSlices ? 0 : 1) + (lambert ? 1 : 0);
}

/// The slices of a rendering; rays leave in the last one that has samples.
template <class Arithmetic>
std::vector<SliceSetup<typename Arithmetic::Weight>> renderSlices(const Traversal& traversal,
                                                                  const Arithmetic& arithmetic, int delay) {
    auto slices = slicesOf(traversal, arithmetic, 0);
    slices.back().last = false;
    slices[slices.size() - 1 - std::size_t(delay)].last = true;
    return slices;
}

/// Voxels hold extinction as `scalar` and source radiance as `source`. The rays that leave are the base plane: C and T.
/// @throw Error if a memory module was used twice in a cycle
template <class Arithmetic>
PassResult<typename Arithmetic::Word> runRender(const Arithmetic& arithmetic,
                                                VoxelMemory<typename Arithmetic::Word>& memory,
                                                const RenderInput<Arithmetic>& input, int pipelines,
                                                Trace* trace = nullptr);

}  // namespace raysweep::cube4
