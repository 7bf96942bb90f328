/// A ray through a lit volume, front to back: the sum in the head of render.h.
#pragma once

#include "raysweep/render/ray_walk.h"
#include "raysweep/render/render.h"
#include "raysweep/render/transmittance.h"

namespace raysweep {

inline void add(Color& sum, float weight, float s) {
    sum += grey(weight * s);
}
inline void add(Color& sum, float weight, const openvdb::Vec3s& s) {
    sum += Color(s.x(), s.y(), s.z()) * weight;
}

struct RenderVolume::Content {
    openvdb::FloatGrid::ConstPtr density;  // 0 where inactive
    openvdb::GridBase::ConstPtr radiosity;
    openvdb::GridBase::ConstPtr emission;  // 0 where inactive; null: nothing shines by itself
    double extinctionScale = 1;
    RayGrid smoke;  // its blocks are of density and radiosity if they share their voxels, else of density
    RayGrid fire;
    openvdb::Mat4d radiosityFromWorld;
};

/// What a ray has gathered so far.
struct RayState {
    Color radiance = grey(0);
    double transmittance = 1;
};

/// Fills blocks of density, and of radiosity beside it.
template <class RadiosityGrid, int kChannels>
class SmokeFiller {
  public:
    explicit SmokeFiller(const RenderVolume::Content& volume)
        : densities_(*volume.density), radiosities_(static_cast<const RadiosityGrid&>(*volume.radiosity)) {}

    void operator()(const openvdb::Coord& origin, float* block) {
        densities_.fill(origin, block, kChannels);
        if constexpr (kChannels > 1) radiosities_.fill(origin, block + 1, kChannels);
    }

  private:
    BlockFiller<openvdb::FloatGrid> densities_;
    BlockFiller<RadiosityGrid> radiosities_;
};

/// Follows rays one after another through the smoke and what is scattered in it. Blocks have `kChannels` values at a
/// corner: one is density alone, more are density and radiosity.
template <class RadiosityGrid, int kChannels>
class RayMarcher {
  public:
    RayMarcher(const RenderVolume::Content& volume, const RenderOptions& options)
        : volume_(volume),
          options_(options),
          density_(*volume.density),
          around_(*volume.density),
          radiosity_(static_cast<const RadiosityGrid&>(*volume.radiosity)),
          walk_(volume.smoke, SmokeFiller<RadiosityGrid, kChannels>(volume)),
          step_(volume.emission ? std::min(options.step, kLongestBeforeFire) : options.step),
          darkest_(options.minTransmittance * (volume.emission ? kFireBehind : 1)) {}

    /// @param seen receives the transmittance along the ray, for what shines by itself; null: nothing does
    RayState follow(const Ray& ray, TransmittanceAlongRay* seen) {
        RayState state;
        if (!walk_.start(ray, step_)) return state;
        seen_ = seen;
        radiosityLine_ =
            IndexLine(volume_.radiosityFromWorld, toVdb(ray.origin), toVdb(ray.direction) * walk_.worldPerIndex());
        radiosityLine_.origin = radiosityLine_.at(walk_.skipped());
        stepDepth_ = float(volume_.extinctionScale * step_ * walk_.worldPerIndex());
        walk_.walk([&](std::int64_t first, int count, const StepValue<kChannels>* values) {
            return takeSteps(first, count, values, state);
        });
        return state;
    }

  private:
    /// A fire may be so much brighter than what hides it, and shows how exactly that is known.
    static constexpr double kFireBehind = 1e-4, kLongestBeforeFire = 0.25;

    /// @return false when the ray is as good as dark
    bool takeSteps(std::int64_t first, int count, const StepValue<kChannels>* values, RayState& state) {
        float opacities[kMostSteps];
        findOpacities<kChannels>(values, count, stepDepth_, opacities);
        RayState now = state;  // in registers
        bool on = true;
        for (int i = 0; i < count && on; ++i)
            if (opacities[i] > 0) on = takeStep(first + i, opacities[i], radiosityOf(values[i], first + i), now);
        state = now;
        return on;
    }

    typename RadiosityGrid::ValueType radiosityOf(const float (&value)[kChannels], std::int64_t k) {
        if constexpr (kChannels == 1) return radiosity_(radiosityLine_.at(walk_.timeOf(k)));
        if constexpr (kChannels == 2) return value[1];
        if constexpr (kChannels == 4) return openvdb::Vec3s(value[1], value[2], value[3]);
    }

    bool takeStep(std::int64_t k, float opacity, const typename RadiosityGrid::ValueType& s, RayState& state) {
        const float weight = float(state.transmittance) * opacity;
        add(state.radiance, options_.lambert ? weight * cosine(walk_.line().at(walk_.timeOf(k))) : weight, s);
        if (seen_) seen_->add(walk_.distanceOf(k), walk_.distanceOf(k + 1), state.transmittance, double(opacity));
        state.transmittance *= 1 - double(opacity);
        if (state.transmittance > darkest_) return true;
        state.radiance *= float(1 / (1 - state.transmittance));
        state.transmittance = 0;
        if (seen_) seen_->endInTheDark();
        return false;
    }

    /// max(0, -d.n) with n = -grad sigma / |grad sigma|, in world space.
    float cosine(const openvdb::Vec3d& p) {
        openvdb::Vec3d slope;  // along the axes of index space, per voxel
        for (int axis = 0; axis < 3; ++axis) {
            openvdb::Vec3d ahead = p, behind = p;
            ahead[axis] += 1, behind[axis] -= 1;
            slope[axis] = 0.5 * (double(around_(ahead)) - around_(behind));
        }
        // grad_world_j = sum_i d index_i / d world_j slope_i; OpenVDB's matrices stand to the right of row vectors.
        const openvdb::Mat4d& m = volume_.smoke.indexFromWorld;
        openvdb::Vec3d gradient;
        for (int j = 0; j < 3; ++j) gradient[j] = m[j][0] * slope[0] + m[j][1] * slope[1] + m[j][2] * slope[2];
        const double length = gradient.length();
        if (!(slope.length() > 1e-6 * density_(p)) || !(length > 0)) return 1;
        const double alongRay = slope.dot(walk_.line().direction) / walk_.worldPerIndex();  // d . grad sigma
        return float(std::max(0.0, alongRay / length));
    }

    const RenderVolume::Content& volume_;
    const RenderOptions& options_;
    LinearSampler<openvdb::FloatGrid> density_, around_;
    LinearSampler<RadiosityGrid> radiosity_;
    RayWalk<kChannels, SmokeFiller<RadiosityGrid, kChannels>> walk_;
    IndexLine radiosityLine_;
    TransmittanceAlongRay* seen_ = nullptr;
    const double step_;  // voxels
    const double darkest_;
    float stepDepth_ = 0;  // optical depth of a step through density 1
};

}  // namespace raysweep
