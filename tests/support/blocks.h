/// Comparing dense arrays by the averages of small blocks: what is left of an error when single voxels' noise is evened
/// out. Arrays are indexed (i * ny + j) * nz + k.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "raysweep/core/types.h"

namespace raysweep::test {

/// Averages of `values` over blocks of `edge`^3 voxels, each voxel weighted by `weights` (its extinction, as a renderer
/// would). Blocks at the high faces may be smaller; a block without weight is left out, so that all arrays averaged
/// with the same weights have the same length.
/// @throw std::invalid_argument if the arrays' lengths are not that of `size`.
inline std::vector<double> blockAverages(const std::vector<double>& values, const std::vector<double>& weights,
                                         const Index3& size, int edge = 4) {
    const std::size_t count = std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
    if (values.size() != count || weights.size() != count)
        throw std::invalid_argument("blockAverages: arrays do not have the grid's number of voxels");
    const Index3 blocks((size.x + edge - 1) / edge, (size.y + edge - 1) / edge, (size.z + edge - 1) / edge);
    const std::size_t blockCount = std::size_t(blocks.x) * std::size_t(blocks.y) * std::size_t(blocks.z);
    std::vector<double> sum(blockCount, 0.0), weight(blockCount, 0.0), averages;
    std::size_t voxel = 0;
    for (int i = 0; i < size.x; ++i) {
        for (int j = 0; j < size.y; ++j) {
            for (int k = 0; k < size.z; ++k, ++voxel) {
                const std::size_t block = (std::size_t(i / edge) * blocks.y + j / edge) * blocks.z + k / edge;
                sum[block] += weights[voxel] * values[voxel];
                weight[block] += weights[voxel];
            }
        }
    }
    for (std::size_t b = 0; b < blockCount; ++b)
        if (weight[b] > 0) averages.push_back(sum[b] / weight[b]);
    return averages;
}

/// Root mean square of `values - reference`, divided by the root mean square of `reference`.
inline double relativeRms(const std::vector<double>& values, const std::vector<double>& reference) {
    if (values.size() != reference.size() || values.empty())
        throw std::invalid_argument("relativeRms: arrays must be of the same length and not empty");
    double difference = 0, norm = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        difference += (values[i] - reference[i]) * (values[i] - reference[i]);
        norm += reference[i] * reference[i];
    }
    return std::sqrt(difference / norm);
}

/// Relative RMS of the block averages of `values` against those of `reference`, both weighted by `weights`.
inline double blockError(const std::vector<double>& values, const std::vector<double>& reference,
                         const std::vector<double>& weights, const Index3& size, int edge = 4) {
    return relativeRms(blockAverages(values, weights, size, edge), blockAverages(reference, weights, size, edge));
}

}  // namespace raysweep::test
