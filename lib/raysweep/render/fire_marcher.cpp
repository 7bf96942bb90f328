#include "raysweep/render/fire_marcher.h"

#include "raysweep/volume/channels.h"

namespace raysweep {
namespace {

/// A step is at most so many voxels of the emission, which may change from voxel to voxel as it likes; no opacity evens
/// that out. Longer ones miss a silhouette's pixels by more than 1 %.
constexpr double kLongestStep = 0.125;

template <class EmissionGrid>
class FireFiller {
  public:
    static constexpr int kCount = kChannels<typename EmissionGrid::ValueType>;

    explicit FireFiller(const EmissionGrid& grid) : values_(grid) {}
    void operator()(const openvdb::Coord& origin, float* block) { values_.fill(origin, block, kCount); }

  private:
    BlockFiller<EmissionGrid> values_;
};

template <class EmissionGrid>
class GridFireMarcher : public FireMarcher {
  public:
    GridFireMarcher(const RenderVolume::Content& volume, const RenderOptions& options)
        : volume_(volume),
          step_(options.step),
          walk_(volume.fire, FireFiller<EmissionGrid>(static_cast<const EmissionGrid&>(*volume.emission))) {}

    Color follow(const Ray& ray, TransmittanceAlongRay& seen) override {
        double sum[kCount] = {};
        if (!walk_.start(ray, stepFor(ray))) return grey(0);
        walk_.walk([&](std::int64_t first, int count, const StepValue<kCount>* values) {
            for (int i = 0; i < count; ++i) {
                if (!isLit(values[i])) continue;
                const double weight = seen.integral(walk_.distanceOf(first + i), walk_.distanceOf(first + i + 1));
                for (int c = 0; c < kCount; ++c) sum[c] += weight * double(values[i][c]);
            }
            return true;
        });
        Color radiance;
        for (int c = 0; c < 3; ++c) radiance[c] = float(sum[kCount == 1 ? 0 : c] / (4 * kPi));
        return radiance;
    }

  private:
    static constexpr int kCount = FireFiller<EmissionGrid>::kCount;

    /// No longer than those through the smoke either, whose transmittance is to be followed.
    double stepFor(const Ray& ray) const {
        const double smoke = 1 / volume_.smoke.indexFromWorld.transform3x3(toVdb(ray.direction)).length();
        return std::min({step_, kLongestStep, step_ * smoke / walk_.worldPerIndex(ray)});
    }

    static bool isLit(const StepValue<kCount>& value) {
        return std::any_of(value, value + kCount, [](float v) { return v != 0; });
    }

    const RenderVolume::Content& volume_;
    const double step_;
    RayWalk<kCount, FireFiller<EmissionGrid>> walk_;
};

}  // namespace

std::unique_ptr<FireMarcher> fireMarcher(const RenderVolume::Content& volume, const RenderOptions& options) {
    if (!volume.emission) return nullptr;
    if (volume.emission->isType<openvdb::FloatGrid>())
        return std::make_unique<GridFireMarcher<openvdb::FloatGrid>>(volume, options);
    return std::make_unique<GridFireMarcher<openvdb::Vec3SGrid>>(volume, options);
}

}  // namespace raysweep
