/// Colours by which a volume shows photographs in a light that is tried.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/core/parallel.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/photo_sheets.h"
#include "raysweep/reconstruct/photo_surfaces.h"
#include "raysweep/reconstruct/photo_views.h"

#include <array>
#include <cstddef>
#include <vector>

namespace raysweep {

/// Three numbers for each ray of a view.
using RayPixels = std::vector<std::array<float, 3>>;

/// The light of a search.
struct LightState {
    Vec3 light;  ///< direction of travel, as for the first picture, length 1
    double ambient = 0.3, diffuse = 0.7;
};

/// What is looked at.
struct LitSheets {
    const PhotoSurfaces* surfaces = nullptr;
    std::vector<SheetNormal> normals;
    std::vector<float> opacities;
};

/// @param surfaces kept by reference
LitSheets litSheets(const PhotoSurfaces& surfaces);

/// Finds colours by which sheets show pictures, in the light of each, as near as a few passes bring it.
class ColorSolver {
  public:
    /// Both are kept by reference.
    ColorSolver(const std::vector<Photograph>& pictures, const LitSheets& sheets);

    std::size_t views() const { return rays_.size(); }
    const PhotoRays& rays(std::size_t view) const { return rays_[view]; }
    const PhotoCamera& camera(std::size_t view) const { return pictures_[view].camera; }
    const LitSheets& sheets() const { return sheets_; }

    /// Black: colours that were made in another light would keep some of it.
    std::vector<CompositeVoxel> black() const;

    SheetLight light(const LightState& state, std::size_t view) const;

    /// From what `colors` are. They need not be positive.
    void solve(const std::vector<RayPixels>& targets, const LightState& state, int passes,
               std::vector<CompositeVoxel>& colors);

    /// What is seen of `colors` in a light.
    RayPixels seen(const std::vector<CompositeVoxel>& colors, const SheetLight& light, std::size_t view);

    /// As they are.
    RayPixels seen(const std::vector<CompositeVoxel>& colors, std::size_t view);

    /// Calls `body(i)` for all voxels of bricks.
    template <class Body>
    void forVoxels(const Body& body) const {
        parallelFor(sheets_.surfaces->layout.brickCount() - 1, [&](std::size_t n) {
            for (std::size_t i = (n + 1) * 512; i < (n + 2) * 512; ++i) body(i);
        });
    }

  private:
    void lightAll(const std::vector<CompositeVoxel>& colors, const SheetLight& light);
    void update(const RayPixels& target, const SheetLight& light, std::size_t view,
                std::vector<CompositeVoxel>& colors);

    const std::vector<Photograph>& pictures_;
    const LitSheets& sheets_;
    std::vector<PhotoRays> rays_;
    std::vector<CompositeVoxel> sums_, shown_;
    std::vector<RayColor> seen_;
    std::vector<std::size_t> order_;
    CompositeTape tape_;
};

}  // namespace raysweep
