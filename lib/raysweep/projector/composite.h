/// Compositing front to back: the light that a ray brings from a volume that glows and dims, and the exact derivative
/// of it. A ray takes samples (σ_i, c_i) of extinction and colour at slices across its major axis, as Joseph's
/// projector (joseph.h) does, or at several places from slice to slice; between voxels both are interpolated linearly.
/// With l the length from sample to sample, τ_i = σ_i l and T_i = exp(−Σ_j<i τ_j) it sees
///
///     C = Σ_i T_i (1 − exp(−τ_i)) c_i,   T = T_N                                                            (1)
///
/// before a backdrop B: C + T B. N. Max, "Optical Models for Direct Volume Rendering", IEEE TVCG 1(2), 1995. Hence
///
///     ∂C/∂c_i = T_i (1 − exp(−τ_i)),   ∂C/∂τ_i = T_{i+1} c_i − Σ_j>i T_j (1 − exp(−τ_j)) c_j,   ∂T/∂τ_i = −T   (2)
#pragma once

#include "raysweep/camera/camera.h"
#include "raysweep/projector/composite_volume.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace raysweep {

/// A ray's samples: sample k is at slice `start` + k `step` of `axis`, and there at `place` + k `rate` along the other
/// axes (ascending); voxels, whole numbers are centres.
struct CompositeRay {
    int axis = 0;
    int count = 0;  ///< of samples that have voxels of the volume around them
    float start = 0, step = 0;
    float place[2] = {0, 0}, rate[2] = {0, 0};
    float length = 0;  ///< from sample to sample, voxels
};

/// @param ray origin and direction in voxels; nothing is seen behind the origin
/// @param perSlice samples from slice to slice, 1 to 16
CompositeRay compositeRay(const CompositeLayout& layout, const Ray& ray, int perSlice);

/// Whether one of its samples may see a voxel that is kept.
bool meetsBricks(const CompositeLayout& layout, const CompositeRay& ray);

/// What comes along a ray; also a derivative with respect to it.
struct alignas(16) RayColor {
    float transmittance = 1;             ///< what is seen of the backdrop
    float red = 0, green = 0, blue = 0;  ///< linear light, without the backdrop
};

/// Rays end when no more than this comes through.
constexpr float kLeastTransmittance = 1e-4f;

/// Eq. 1 for `count` rays; any order.
void composite(const CompositeLayout& layout, const CompositeVoxel* voxels, const CompositeRay* rays, std::size_t count,
               RayColor* colors);

/// Sets `derivatives` of what is to be lowered for the rays [first, first + count), given their colours. Called for
/// pieces of a batch, from several threads.
using RayLoss =
    std::function<void(std::size_t first, std::size_t count, const RayColor* colors, RayColor* derivatives)>;

/// What a sample is given: to extinction, and in parts of a colour that is the ray's.
struct SampleShare {
    float extinction = 0, color = 0;
};

/// Memory of a batch of rays, to be used again for the next.
struct CompositeTape {
    /// Samples of a ray that follow one another in one layer of bricks.
    struct Run {
        std::uint16_t first;  ///< number of the first on its ray
        std::uint16_t layer;
        std::uint8_t ray;  ///< in its piece
        std::uint8_t count;
    };
    /// Samples of some rays, layer after layer, in each ray after ray.
    struct Piece {
        std::vector<SampleShare> shares;
        std::vector<Run> runs;
        std::size_t used = 0;  ///< samples
    };
    /// What a piece has in a layer: where its shares and its runs begin, and where the latter end.
    struct Part {
        std::uint32_t share, run, end;
    };
    std::vector<Piece> pieces;
    std::vector<Part> parts;       ///< layer after layer all pieces
    std::vector<RayColor> colors;  ///< of each ray
    std::vector<RayColor> shared;  ///< what its samples are given parts of; the first lane means nothing
    std::size_t samples = 0;       ///< in the batch, that were not skipped
};

/// Adds to `gradient` the derivative of a loss with respect to the voxels, by eq. 2. The same bits for any number of
/// threads.
/// @param rays those of a major axis together: any that come before one of a smaller axis are refused
/// @throw InvalidArgument if they are not in that order
void compositeGradient(const CompositeLayout& layout, const CompositeVoxel* voxels,
                       const std::vector<CompositeRay>& rays, const RayLoss& loss, CompositeTape& tape,
                       CompositeVoxel* gradient);

/// The samples of a ray that were not skipped, front to back.
struct RaySamples {
    const CompositeRay& ray;
    const RayColor& color;
    const CompositeVoxel* samples;
    const float* transmittances;   ///< before each sample, and behind the last: `count` + 1
    const std::uint16_t* numbers;  ///< of each sample on the ray
    std::size_t count;
};

/// Is shown the samples of ray `ray`. Called from several threads.
using SampleVisitor = std::function<void(std::size_t ray, const RaySamples& samples)>;

/// Shows what rays meet; any order.
void compositeSamples(const CompositeLayout& layout, const CompositeVoxel* voxels,
                      const std::vector<CompositeRay>& rays, const SampleVisitor& visit);

/// Sets the shares of the samples of ray `ray`. Called from several threads.
/// @return red, green and blue that they have parts of
using SampleRule = std::function<std::array<float, 3>(std::size_t ray, const RaySamples& samples, SampleShare* shares)>;

/// Adds to `sums` what a rule gives samples, spread over the voxels by the weights with which they were interpolated:
/// the backprojection that belongs to `composite`. As compositeGradient, whose rule is eq. 2, in all else.
void compositeSpread(const CompositeLayout& layout, const CompositeVoxel* voxels, const std::vector<CompositeRay>& rays,
                     const SampleRule& rule, CompositeTape& tape, CompositeVoxel* sums);

}  // namespace raysweep
