/// What shines by itself, along a ray: the second term of the sum in the head of render.h.
#pragma once

#include "raysweep/render/ray_marcher.h"

#include <memory>

namespace raysweep {

/// Follows rays one after another through the emission, on its own voxels.
class FireMarcher {
  public:
    virtual ~FireMarcher() = default;

    /// Radiance that the emission along `ray` brings to the eye. @param seen the smoke's transmittance along it
    virtual Color follow(const Ray& ray, TransmittanceAlongRay& seen) = 0;
};

/// One for each thread. Null if nothing of `volume` shines by itself.
std::unique_ptr<FireMarcher> fireMarcher(const RenderVolume::Content& volume, const RenderOptions& options);

}  // namespace raysweep
