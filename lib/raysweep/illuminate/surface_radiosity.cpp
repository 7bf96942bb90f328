#include "raysweep/illuminate/surface_radiosity.h"

#include "raysweep/bricks/padded_brick.h"
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/radiosity.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

constexpr double kVisible = 0.005;  ///< what is seen of a voxel behind solid ones of this transmittance does not matter
constexpr int kDeepest = 64;

/// Whether two surface voxels belong to the same piece of surface, by their normals.
bool agree(PackedNormal a, PackedNormal b) {
    return isSurface(b) && unpackNormal(a).dot(unpackNormal(b)) > 0.5;
}

/// A value found for a voxel of a brick.
struct Filled {
    int voxel;
    float value;
};

/// Means of the known neighbours of unknown voxels that can be seen `depth` voxels deep. @return true if there may be
/// more to do in this brick
bool fillBrick(const SolverState& state, const BrickField& radiosity, std::size_t b, int depth,
               std::vector<Filled>& filled) {
    const double thickest = -std::log(kVisible) / depth;
    const float* const tau = state.medium.tau.brick(b);
    const float* const own = radiosity.brick(b);
    const auto isUnknown = [&](int i) { return own[i] < 0 && tau[i] > 0; };
    const auto isSeen = [&](int i) { return double(tau[i]) < thickest; };
    bool unknown = false, seen = false;
    for (int i = 0; i < kBrickVoxels; ++i) {
        unknown = unknown || isUnknown(i);
        seen = seen || (isUnknown(i) && isSeen(i));
    }
    // The first layer is always seen: by interpolation.
    if (!(depth == 1 ? unknown : seen)) return false;
    const PaddedBrick<float> values(state.medium.volume.layout, state.medium.volume.map, state.medium.volume.periodic,
                                    b, [&](std::size_t n) { return radiosity.brick(n); });
    const PaddedBrick<float> depths(state.medium.volume.layout, state.medium.volume.map, state.medium.volume.periodic,
                                    b, [&](std::size_t n) { return state.medium.tau.brick(n); });
    for (int i = 0; i < kBrickVoxels; ++i) {
        if (!isUnknown(i) || !(depth == 1 || isSeen(i))) continue;
        double sum = 0;
        int count = 0;
        values.forEachAround(i, [&](int x, int y, int z) {
            if (values.at(x, y, z) < 0 || depths.at(x, y, z) == 0) return;
            sum += double(values.at(x, y, z));
            ++count;
        });
        if (count > 0) filled.push_back({i, float(sum / count)});
    }
    return seen;
}

}  // namespace

BrickField evenedOut(const SolverState& state, const BrickField& received, const BrickField& furnace) {
    const BrickLayout& layout = state.medium.volume.layout;
    const auto ofSurfaces = [&](const BrickField& field, std::size_t b) {
        return state.solid.surfaces.normals(b) ? field.brick(state.solid.surfaces.slots[b]) : nullptr;
    };
    BrickField even(received.brickCount());
    parallelFor(layout.brickCount(), [&](std::size_t b) {
        const PackedNormal* const own = state.solid.surfaces.normals(b);
        if (!own) return;
        const auto padded = [&](const BrickField& field) {
            return PaddedBrick<float>(layout, state.medium.volume.map, state.medium.volume.periodic, b,
                                      [&](std::size_t n) { return ofSurfaces(field, n); });
        };
        const PaddedBrick<float> values = padded(received), weights = padded(furnace);
        const PaddedBrick<PackedNormal> normals(layout, state.medium.volume.map, state.medium.volume.periodic, b,
                                                [&](std::size_t n) { return state.solid.surfaces.normals(n); });
        float* const to = even.brick(state.solid.surfaces.slots[b]);
        for (int i = 0; i < kBrickVoxels; ++i) {
            if (!isSurface(own[i])) continue;
            double sum = 0, weight = 0;
            normals.forEachAround(i, [&](int x, int y, int z) {
                if (!agree(own[i], normals.at(x, y, z))) return;
                sum += double(weights.at(x, y, z)) * double(values.at(x, y, z));
                weight += double(weights.at(x, y, z));
            });
            to[i] = weight > 0 ? float(sum / weight) : 0;
        }
    });
    return even;
}

void fillSolids(const SolverState& state, BrickField& radiosity) {
    if (state.solid.furnace.empty()) return;
    std::vector<std::size_t> bricks(state.medium.volume.layout.brickCount());
    for (std::size_t b = 0; b < bricks.size(); ++b) bricks[b] = b;
    for (int depth = 1; depth <= kDeepest && !bricks.empty(); ++depth) {
        std::vector<std::vector<Filled>> filled(bricks.size());
        std::vector<char> more(bricks.size());
        parallelFor(bricks.size(),
                    [&](std::size_t i) { more[i] = fillBrick(state, radiosity, bricks[i], depth, filled[i]); });
        std::vector<std::size_t> left;
        for (std::size_t i = 0; i < bricks.size(); ++i) {
            for (const Filled& f : filled[i]) radiosity.brick(bricks[i])[f.voxel] = f.value;
            if (more[i]) left.push_back(bricks[i]);
        }
        bricks = std::move(left);
    }
}

}  // namespace raysweep
