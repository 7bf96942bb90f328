#include "raysweep/reconstruct/total_variation.h"

#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace raysweep {
namespace {

constexpr int kHalo = kBlockEdge + 2;  // columns along the edge of a block with its neighbours

/// A block with one voxel more on all sides.
struct HaloBlock {
    int length;  ///< of a column
    std::vector<float> values;

    float* column(int x, int y) { return values.data() + std::size_t((x + 1) * kHalo + y + 1) * length + 1; }
};

void copyWithHalo(const ColumnVolume& volume, std::size_t block, HaloBlock& to) {
    const ColumnRange own = volume.ranges()[block];
    const ColumnLattice& lattice = volume.lattice();
    to.length = own.length() + 2;
    to.values.assign(std::size_t(kHalo) * kHalo * to.length, 0.0f);
    const int firstX = volume.firstX(block), firstY = volume.firstY(block);
    for (int x = -1; x <= kBlockEdge; ++x)
        for (int y = -1; y <= kBlockEdge; ++y) {
            const int i = firstX + x, j = firstY + y;
            if (i < 0 || j < 0 || i >= lattice.dims.x || j >= lattice.dims.y) continue;
            const std::size_t from = volume.blockOf(i, j);
            const ColumnRange range = volume.ranges()[from];
            const int low = std::max(own.low - 1, range.low), high = std::min(own.high + 1, range.high);
            if (low < high)
                std::copy_n(volume.column(from, i, j) + (low - range.low), high - low,
                            to.column(x, y) + (low - own.low));
        }
}

/// Differences below this part of the largest value do not matter: keeps the length of a gradient away from 0.
constexpr float kSmallest = 1e-4f;

/// What differences count.
struct DifferenceWeights {
    float x, y, z;  ///< of the square of one along each axis: 1 / edge² of a voxel, relative to the shortest edge
    float smooth;   ///< square of a difference that does not matter
};

DifferenceWeights differenceWeights(const ColumnLattice& lattice, float smooth) {
    double squares[3];  // of edges
    for (int axis = 0; axis < 3; ++axis) {
        const double* edge = lattice.worldFromVoxel[axis];
        squares[axis] = edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2];
    }
    const double shortest = std::min({squares[0], squares[1], squares[2]});
    return {float(shortest / squares[0]), float(shortest / squares[1]), float(shortest / squares[2]), smooth};
}

/// Derivative of the total variation (docs/ct.md, eq. 6) by each voxel of a block.
void gradientOf(HaloBlock& f, HaloBlock& lengths, int count, const DifferenceWeights& w, float* gradient) {
    const float all = w.x + w.y + w.z;
    lengths.length = f.length;
    lengths.values.resize(f.values.size());
    for (int x = 0; x <= kBlockEdge; ++x)
        for (int y = 0; y <= kBlockEdge; ++y) {
            const float *here = f.column(x, y), *left = f.column(x - 1, y), *before = f.column(x, y - 1);
            float* length = lengths.column(x, y);
            for (int z = 0; z <= count; ++z) {
                const float dx = here[z] - left[z], dy = here[z] - before[z], dz = here[z] - here[z - 1];
                length[z] = std::sqrt(w.x * dx * dx + w.y * dy * dy + w.z * dz * dz + w.smooth);
            }
        }
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y, gradient += count) {
            const float *here = f.column(x, y), *left = f.column(x - 1, y), *before = f.column(x, y - 1);
            const float *right = f.column(x + 1, y), *behind = f.column(x, y + 1);
            const float *length = lengths.column(x, y), *rightLength = lengths.column(x + 1, y),
                        *behindLength = lengths.column(x, y + 1);
            for (int z = 0; z < count; ++z)
                gradient[z] = (all * here[z] - w.x * left[z] - w.y * before[z] - w.z * here[z - 1]) / length[z] -
                              w.x * (right[z] - here[z]) / rightLength[z] -
                              w.y * (behind[z] - here[z]) / behindLength[z] -
                              w.z * (here[z + 1] - here[z]) / length[z + 1];
        }
}

float largestIn(const ColumnVolume& volume) {
    float largest = 0;
    for (std::size_t i = 0; i < volume.storedVoxels(); ++i) largest = std::max(largest, std::abs(volume.block(0)[i]));
    return largest;
}

template <class Term>
double sumOverVoxels(const ColumnVolume& volume, const Term& term) {
    return orderedSum<double>(
        volume.blockCount(),
        [&](std::size_t block) {
            double sum = 0;
            for (std::size_t i = 0; i < volume.voxelsOf(block); ++i) sum += term(block, i);
            return sum;
        },
        4);
}

/// x -= scale * gradient within bounds. Voxels beyond the lattice must stay 0.
void descend(ColumnVolume& volume, const ColumnVolume& gradients, float scale, const VariationSteps& how) {
    const Index3 dims = volume.lattice().dims;
    parallelFor(volume.blockCount(), [&](std::size_t block) {
        const ColumnRange range = volume.ranges()[block];
        const int firstX = volume.firstX(block), firstY = volume.firstY(block);
        for (int x = 0; x < std::min(kBlockEdge, dims.x - firstX); ++x)
            for (int y = 0; y < std::min(kBlockEdge, dims.y - firstY); ++y) {
                const std::size_t first = std::size_t(x * kBlockEdge + y) * range.length();
                float* voxels = volume.block(block) + first;
                const float* gradient = gradients.block(block) + first;
                for (int z = 0; z < std::min(range.high, dims.z) - range.low; ++z)
                    voxels[z] = std::clamp(voxels[z] - scale * gradient[z], how.lower, how.upper);
            }
    });
}

}  // namespace

double changeLength(const ColumnVolume& a, const ColumnVolume& b) {
    return std::sqrt(sumOverVoxels(a, [&](std::size_t block, std::size_t i) {
        const double difference = double(a.block(block)[i]) - b.block(block)[i];
        return difference * difference;
    }));
}

void lowerTotalVariation(ColumnVolume& volume, ColumnVolume& scratch, const VariationSteps& how) {
    const float least = kSmallest * largestIn(volume), smooth = least * least;
    if (!(smooth > 0)) return;
    const DifferenceWeights weights = differenceWeights(volume.lattice(), smooth);
    for (int step = 0; step < how.steps; ++step) {
        parallelFor(volume.blockCount(), [&](std::size_t block) {
            if (volume.voxelsOf(block) == 0) return;
            thread_local HaloBlock values, lengths;
            copyWithHalo(volume, block, values);
            gradientOf(values, lengths, volume.ranges()[block].length(), weights, scratch.block(block));
        });
        const double length = std::sqrt(sumOverVoxels(scratch, [&](std::size_t block, std::size_t i) {
            return double(scratch.block(block)[i]) * scratch.block(block)[i];
        }));
        if (!(length > 0)) return;
        descend(volume, scratch, float(how.change / how.steps / length), how);
    }
}

}  // namespace raysweep
