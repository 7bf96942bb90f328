// View after view, ray after ray: a voxel's parts of a ray's samples are added up, and the sum is compared with the
// most so far. A most does not depend on the order, so rays may come from several threads.
#include "raysweep/reconstruct/photo_confidence.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/photo_grids.h"
#include "raysweep/reconstruct/photo_views.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/voxels_of.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;

/// Parts of a ray below this are not followed up: less than the rounding of 8 bits.
constexpr float kLeastPart = 1e-4f;

/// The volume in bricks.
struct Matter {
    Coord origin;  ///< index of voxel (0,0,0) of `grid`
    ReconstructionGrid grid;
    CompositeLayout layout;
    std::vector<CompositeVoxel> voxels;  ///< extinction, 1 / edge of a voxel
};

/// Whole bricks around the active voxels.
void setGrid(const FloatGrid& density, Matter& matter) {
    const openvdb::CoordBBox box = density.evalActiveVoxelBoundingBox();
    matter.origin = box.min() & ~7;
    for (int axis = 0; axis < 3; ++axis) matter.grid.dims[axis] = ((box.max()[axis] - matter.origin[axis]) / 8 + 1) * 8;
    matter.grid.spacing = Vec3(density.voxelSize().x());
    const openvdb::Vec3d last(matter.grid.dims.x - 1, matter.grid.dims.y - 1, matter.grid.dims.z - 1);
    const openvdb::Vec3d center = density.indexToWorld(matter.origin.asVec3d() + 0.5 * last);
    matter.grid.center = Vec3(center.x(), center.y(), center.z());
}

/// @param density without tiles
Matter matterIn(const FloatGrid& density) {
    Matter matter;
    setGrid(density, matter);
    matter.layout = compositeLayout(matter.grid.dims, bricksOf(density, matter.origin));
    matter.voxels.resize(matter.layout.voxelCount());
    for (auto value = density.cbeginValueOn(); value; ++value) {
        const Coord at = value.getCoord() - matter.origin;
        matter.voxels[matter.layout.voxel(Index3(at.x(), at.y(), at.z()))].extinction =
            float(*value * matter.grid.edge());
    }
    return matter;
}

/// The largest part of each voxel in a picture's rays.
class LargestParts {
  public:
    explicit LargestParts(std::size_t voxels) : bits_(voxels) {}

    void offer(std::size_t voxel, float part) {
        // Floats that are not negative are ordered as their bits are.
        std::uint32_t bits;
        std::memcpy(&bits, &part, sizeof bits);
        std::uint32_t most = bits_[voxel].load(std::memory_order_relaxed);
        while (most < bits && !bits_[voxel].compare_exchange_weak(most, bits, std::memory_order_relaxed)) {
        }
    }

    /// The part, which is 0 from now on.
    float take(std::size_t voxel) {
        const std::uint32_t bits = bits_[voxel].exchange(0, std::memory_order_relaxed);
        float part;
        std::memcpy(&part, &bits, sizeof part);
        return part;
    }

  private:
    std::vector<std::atomic<std::uint32_t>> bits_;
};

/// Voxels of one slice, and their parts of a ray. A ray goes on by at most one voxel along each other axis from slice
/// to slice, and a slice takes part in samples from the one before to the one behind.
class SliceParts {
  public:
    void add(std::size_t voxel, float part) {
        for (int i = 0; i < count_; ++i)
            if (voxels_[i] == voxel) {
                parts_[i] += part;
                return;
            }
        voxels_[count_] = voxel;
        parts_[count_++] = part;
    }

    void finish(LargestParts& largest) {
        for (int i = 0; i < count_; ++i)
            if (voxels_[i] >= 512) largest.offer(voxels_[i], parts_[i]);
        count_ = 0;
    }

  private:
    static constexpr int kMost = 4 * 4;
    std::size_t voxels_[kMost];
    float parts_[kMost];
    int count_ = 0;
};

/// A sample between two slices, among four voxels of each.
struct SamplePlace {
    Index3 voxel;       ///< below along all axes
    float fraction[3];  ///< from there to the next: along the major axis, the first and the second other axis
};

SamplePlace placeOf(const CompositeRay& ray, int number) {
    const int axes[3] = {ray.axis, ray.axis == 0 ? 1 : 0, ray.axis == 2 ? 1 : 2};
    const float start[3] = {ray.start, ray.place[0], ray.place[1]}, rate[3] = {ray.step, ray.rate[0], ray.rate[1]};
    SamplePlace at;
    for (int i = 0; i < 3; ++i) {
        const float place = start[i] + float(number) * rate[i], below = std::floor(place);
        at.voxel[axes[i]] = int(below);
        at.fraction[i] = place - below;
    }
    return at;
}

/// Eq. 1 for the voxels along one ray.
void offerParts(const CompositeLayout& layout, const RaySamples& samples, LargestParts& largest) {
    const CompositeRay& ray = samples.ray;
    const int first = ray.axis == 0 ? 1 : 0, second = ray.axis == 2 ? 1 : 2;
    SliceParts slices[2];  // by whether the slice's number is odd
    int now = 0;
    bool any = false;
    for (std::size_t i = 0; i < samples.count; ++i) {
        const float part = samples.transmittances[i] - samples.transmittances[i + 1];
        if (part < kLeastPart) continue;
        const SamplePlace at = placeOf(ray, samples.numbers[i]);
        const int below = at.voxel[ray.axis];
        if (any && below != now) {
            // On the way up, slice `now` is behind; on the way down, the one above it; after a gap, both are.
            slices[(ray.step > 0 ? now : now + 1) & 1].finish(largest);
            if (std::abs(below - now) > 1) slices[(ray.step > 0 ? now + 1 : now) & 1].finish(largest);
        }
        now = below, any = true;
        for (int corner = 0; corner < 8; ++corner) {
            const int upper[3] = {corner >> 2, corner >> 1 & 1, corner & 1};
            float weight = part;
            for (int axis = 0; axis < 3; ++axis) weight *= upper[axis] ? at.fraction[axis] : 1 - at.fraction[axis];
            if (!(weight > 0)) continue;
            Index3 voxel = at.voxel;
            voxel[ray.axis] += upper[0], voxel[first] += upper[1], voxel[second] += upper[2];
            slices[(below + upper[0]) & 1].add(layout.voxel(voxel), weight);
        }
    }
    for (SliceParts& slice : slices) slice.finish(largest);
}

/// Of each voxel.
struct Seen {
    float most = 0, views = 0;
};

/// Takes a picture into account.
void lookFrom(const Photograph& picture, const Matter& matter, const PhotoConfidenceOptions& options,
              LargestParts& largest, std::vector<Seen>& seen) {
    PhotoRays rays;
    setRays(rays, picture, matter.grid, matter.layout, options.samplesPerSlice, 0);
    compositeSamples(matter.layout, matter.voxels.data(), rays.rays,
                     [&](std::size_t, const RaySamples& samples) { offerParts(matter.layout, samples, largest); });
    parallelFor(
        matter.layout.brickCount(),
        [&](std::size_t brick) {
            for (std::size_t i = brick * 512; i < (brick + 1) * 512; ++i) {
                const float part = largest.take(i);
                seen[i].most = std::max(seen[i].most, std::min(part, 1.0f));  // 1 but for rounding
                seen[i].views += part >= float(options.seen) ? 1.0f : 0.0f;
            }
        },
        64);
}

void setValues(FloatGrid& grid, const Matter& matter, const std::vector<Seen>& seen, float Seen::*value) {
    setActive(grid, [&] {
        return [&](const Coord& index) {
            const Coord at = index - matter.origin;
            return seen[matter.layout.voxel(Index3(at.x(), at.y(), at.z()))].*value;
        };
    });
}

}  // namespace

void PhotoConfidenceOptions::validate() const {
    requireField(seen > 0 && seen <= 1, "seen", seen, "in (0,1]");
    requireField(samplesPerSlice >= 1 && samplesPerSlice <= 16, "samplesPerSlice", samplesPerSlice, "from 1 to 16");
}

PhotoConfidence photoConfidence(const FloatGrid& density, const std::vector<Photograph>& photographs,
                                const PhotoConfidenceOptions& options, const ProgressCallback& progress) {
    options.validate();
    requireUsable(photographs);
    if (!edgeOfCubes(density.transform()))
        throw InvalidArgument("the volume's voxels are no cubes along the world's axes; resample it");
    PhotoConfidence result{withVoxelsOf<FloatGrid>(density), withVoxelsOf<FloatGrid>(density)};
    result.confidence->setName("confidence");
    result.views->setName("views");
    if (density.activeVoxelCount() == 0) return result;
    const FloatGrid::Ptr voxels = density.deepCopy();
    voxels->tree().voxelizeActiveTiles();
    const Matter matter = matterIn(*voxels);
    const std::vector<Photograph> pictures = picturesFor(photographs, matter.grid);
    LargestParts largest(matter.layout.voxelCount());
    std::vector<Seen> seen(matter.layout.voxelCount());
    for (std::size_t n = 0; n < pictures.size(); ++n) {
        if (!report(progress, "looking at what was seen", double(n) / double(pictures.size()))) return {};
        lookFrom(pictures[n], matter, options, largest, seen);
    }
    setValues(*result.confidence, matter, seen, &Seen::most);
    setValues(*result.views, matter, seen, &Seen::views);
    return result;
}

}  // namespace raysweep
