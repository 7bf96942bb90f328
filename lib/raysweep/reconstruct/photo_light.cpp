#include "raysweep/reconstruct/photo_light.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/photo_sart.h"
#include "raysweep/reconstruct/photo_sightings.h"
#include "raysweep/reconstruct/photo_surfaces.h"
#include "raysweep/reconstruct/photo_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

namespace raysweep {
namespace {

/// Evenly, `most` of them; the first always.
std::vector<Photograph> someOf(const std::vector<Photograph>& photographs, int most) {
    const std::size_t count = std::min(photographs.size(), std::size_t(most));
    std::vector<Photograph> some;
    for (std::size_t i = 0; i < count; ++i) some.push_back(photographs[i * photographs.size() / count]);
    return some;
}

ReconstructionGrid coarser(ReconstructionGrid grid, int resolution) {
    const Vec3 size = Vec3(grid.dims.x, grid.dims.y, grid.dims.z) * grid.spacing;
    grid.spacing = std::max(grid.spacing, std::max({size.x, size.y, size.z}) / resolution);
    for (int axis = 0; axis < 3; ++axis)
        grid.dims[axis] = std::max(1, int(std::ceil(size[axis] / grid.spacing - 1e-6)));
    return grid;
}

/// Red, green and blue of the rays of a view.
using RayPixels = std::vector<std::array<float, 3>>;

/// Finds colours by which surfaces show pictures, in the light of each, as near as a few passes bring it.
class ColorSolver {
  public:
    ColorSolver(const std::vector<Photograph>& pictures, const PhotoSurfaces& surfaces)
        : pictures_(pictures), surfaces_(surfaces), rays_(pictures.size()), sums_(surfaces.layout.voxelCount()) {
        for (std::size_t n = 0; n < pictures.size(); ++n)
            setRays(rays_[n], pictures[n], surfaces.grid, surfaces.layout, 1, 0);
        order_.resize(pictures.size());
        std::iota(order_.begin(), order_.end(), std::size_t(0));
        std::mt19937 random(1);
        for (std::size_t i = order_.size(); i > 1; --i) std::swap(order_[i - 1], order_[random() % i]);
    }

    std::size_t views() const { return rays_.size(); }
    const PhotoRays& rays(std::size_t view) const { return rays_[view]; }
    const PhotoCamera& camera(std::size_t view) const { return pictures_[view].camera; }
    const PhotoSurfaces& surfaces() const { return surfaces_; }

    ViewLight light(const Shading& shading, std::size_t view) const {
        return lightOf(shading, pictures_[view].camera, pictures_.front().camera);
    }

    /// From what `colors` are. They need not be positive.
    void solve(const std::vector<RayPixels>& targets, const Shading& shading, int passes,
               std::vector<CompositeVoxel>& colors) {
        for (int pass = 0; pass < passes; ++pass)
            for (const std::size_t n : order_) update(targets[n], light(shading, n), n, colors);
    }

    /// What is seen of `colors` in the light of a view.
    RayPixels seen(const std::vector<CompositeVoxel>& colors, const ViewLight& light, std::size_t view) {
        lightAll(surfaces_, colors, light, shown_);
        seen_.resize(rays_[view].rays.size());
        composite(surfaces_.layout, shown_.data(), rays_[view].rays.data(), seen_.size(), seen_.data());
        RayPixels to;
        for (const RayColor& color : seen_) to.push_back({color.red, color.green, color.blue});
        return to;
    }

  private:
    void update(const RayPixels& target, const ViewLight& light, std::size_t view,
                std::vector<CompositeVoxel>& colors) {
        lightAll(surfaces_, colors, light, shown_);
        const auto rule = [&](std::size_t r, const RaySamples& samples, SampleShare* shares) {
            shareColors(rays_[view].shares[r], samples, shares);
            return std::array<float, 3>{target[r][0] - samples.color.red, target[r][1] - samples.color.green,
                                        target[r][2] - samples.color.blue};
        };
        compositeSpread(surfaces_.layout, shown_.data(), rays_[view].rays, rule, tape_, sums_.data());
        parallelFor(surfaces_.layout.brickCount() - 1, [&](std::size_t n) {
            for (std::size_t i = (n + 1) * 512; i < (n + 2) * 512; ++i) {
                const float f = brightness(light, surfaces_.normals[i]);
                colors[i].red += f * sums_[i].red;
                colors[i].green += f * sums_[i].green;
                colors[i].blue += f * sums_[i].blue;
                sums_[i] = {};
            }
        });
    }

    const std::vector<Photograph>& pictures_;
    const PhotoSurfaces& surfaces_;
    std::vector<PhotoRays> rays_;
    std::vector<CompositeVoxel> sums_, shown_;
    std::vector<RayColor> seen_;
    std::vector<std::size_t> order_;
    CompositeTape tape_;
};

float sumOf(const std::array<float, 3>& color) {
    return color[0] + color[1] + color[2];
}

/// What a small change of each component of diffuse light does to the brightness of a view; in place of colours.
std::vector<CompositeVoxel> slopesOf(const ColorSolver& solver, const std::vector<CompositeVoxel>& colors,
                                     const ViewLight& light, std::size_t view) {
    std::vector<CompositeVoxel> slopes(colors.size());
    const PhotoSurfaces& surfaces = solver.surfaces();
    parallelFor(surfaces.layout.brickCount() - 1, [&](std::size_t n) {
        for (std::size_t i = (n + 1) * 512; i < (n + 2) * 512; ++i) {
            slopes[i].extinction = colors[i].extinction;
            const Vec3 normal = unpacked(surfaces.normals[i]);
            if (normal.dot(Vec3(light.toLight[0], light.toLight[1], light.toLight[2])) <= 0) continue;
            const Vec3 slope = carriedAlong(normal, solver.camera(view), solver.camera(0)) *
                               -double(colors[i].red + colors[i].green + colors[i].blue);
            slopes[i].red = float(slope.x);
            slopes[i].green = float(slope.y);
            slopes[i].blue = float(slope.z);
        }
    });
    return slopes;
}

/// Squares of brightnesses and what light changes of them, sums over all pixels.
struct NormalEquations {
    Matrix3 matrix = Matrix3(0, 0, 0, 0, 0, 0, 0, 0, 0);  ///< of slopes, without what colours could do
    Vec3 right{0};                                        ///< the same times what is left
    double left = 0, power = 0;
};

/// @param colors those for `shading` afterwards
NormalEquations equationsFor(ColorSolver& solver, const Shading& shading, int passes,
                             std::vector<CompositeVoxel>& colors) {
    std::vector<RayPixels> targets(solver.views()), slopes(solver.views()), seen(solver.views());
    for (std::size_t n = 0; n < solver.views(); ++n)
        for (const auto& pixel : solver.rays(n).pixels) targets[n].push_back({pixel[0], pixel[1], pixel[2]});
    solver.solve(targets, shading, passes, colors);
    for (std::size_t n = 0; n < solver.views(); ++n) {
        const ViewLight light = solver.light(shading, n);
        seen[n] = solver.seen(colors, light, n);
        slopes[n] = solver.seen(slopesOf(solver, colors, light, n), ViewLight(), n);
    }
    std::vector<CompositeVoxel> absorbed(colors.size());
    for (std::size_t i = 0; i < colors.size(); ++i) absorbed[i].extinction = colors[i].extinction;
    solver.solve(slopes, shading, passes, absorbed);
    NormalEquations sums;
    for (std::size_t n = 0; n < solver.views(); ++n) {
        const RayPixels gone = solver.seen(absorbed, solver.light(shading, n), n);
        for (std::size_t r = 0; r < gone.size(); ++r) {
            const double all = sumOf(targets[n][r]), left = all - sumOf(seen[n][r]);
            Vec3 slope;
            for (int i = 0; i < 3; ++i) slope[i] = slopes[n][r][std::size_t(i)] - gone[r][std::size_t(i)];
            sums.power += all * all;
            sums.left += left * left;
            sums.right += slope * left;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) sums.matrix[i][j] += slope[i] * slope[j];
        }
    }
    return sums;
}

/// Changes the light by what the equations say, and colours such that ambient and diffuse light together are 1.
void step(const NormalEquations& equations, Shading& shading, std::vector<CompositeVoxel>& colors) {
    Matrix3 matrix = equations.matrix;
    // Where nothing depends on a component it is left as it is.
    const double trace = matrix[0][0] + matrix[1][1] + matrix[2][2];
    for (int i = 0; i < 3; ++i) matrix[i][i] += 1e-6 * trace + 1e-30;
    const Vec3 lit = shading.light * shading.diffuse + equations.right * matrix.inverse();
    constexpr double kLeastAmbient = 1e-3;  // of all: without it there is no scale to colours that see no light
    const double ambient = std::max(shading.ambient, kLeastAmbient), all = ambient + lit.length();
    if (!(lit.length() > 0) || !std::isfinite(all)) return;
    shading.diffuse = lit.length() / all;
    shading.ambient = 1 - shading.diffuse;
    shading.light = lit.normalized();
    for (CompositeVoxel& color : colors) {
        color.red *= float(all);
        color.green *= float(all);
        color.blue *= float(all);
    }
}

/// What else is to be said of a light, from how its neighbours fare.
PhotoLight judged(const NormalEquations& equations, const Shading& shading) {
    const auto more = [&](const Vec3& change) { return change.dot(change * equations.matrix); };
    const Vec3 beside = std::abs(shading.light.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 u = shading.light.cross(beside).normalized(), v = shading.light.cross(u);
    constexpr int kAround = 36;
    const double far = 2 * std::sin(15 * kPi / 180) * shading.diffuse;  // 30 degrees away
    double least = more(u * far);
    for (int i = 0; i < kAround; ++i) {
        const double angle = i * kPi / kAround;
        least = std::min(least, more((u * std::cos(angle) + v * std::sin(angle)) * far));
    }
    const double all = more(shading.light * shading.diffuse), power = std::max(equations.power, 1e-30);
    PhotoLight light;
    light.shading = shading;
    light.residual = std::sqrt(equations.left / power);
    light.aside = std::sqrt((equations.left + least) / power);
    light.ambient = std::sqrt((equations.left + all) / power);
    const double part = far * far / std::max(shading.diffuse * shading.diffuse, 1e-30);
    light.confidence = std::clamp(least / part / std::max(equations.left + least / part, 1e-30), 0.0, 1.0);
    return light;
}

}  // namespace

void PhotoLightOptions::validate() const {
    requireField(resolution >= 8 && resolution <= 256, "resolution of the light's volume", resolution, "from 8 to 256");
    requireField(views > 1, "views for the light", views, "at least 2");
    requireField(passes > 0, "passes for the light", passes, "at least 1");
    requireField(places > 0, "places for the light", places, "at least 1");
    requireField(directions > 1, "directions of the light", directions, "at least 2");
    requireField(steps >= 0, "steps for the light", steps, "at least 0");
    requireField(colorPasses > 0, "passes for colours in the light", colorPasses, "at least 1");
}

std::optional<PhotoLight> findLight(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                                    const PhotoLightOptions& options, const ProgressCallback& progress) {
    options.validate();
    const auto part = [&](double from, double to) {
        return [&progress, from, to](const std::string&, double fraction) {
            return report(progress, "looking for the light", from + (to - from) * fraction);
        };
    };
    const ReconstructionGrid coarse = coarser(grid, options.resolution);
    const std::vector<Photograph> pictures = picturesFor(someOf(photographs, options.views), coarse);
    PhotoSartOptions first;
    first.iterations = options.passes;
    const PhotoReconstruction volume = photoSart(pictures, coarse, first, {}, part(0, 0.3));
    if (volume.termination == PhotoTermination::interrupted) return {};
    const PhotoSurfaces surfaces = surfacesOf(volume, coarse);
    Shading shading = guessLight(pictures, surfaces, std::size_t(options.places), options.directions);
    ColorSolver solver(pictures, surfaces);
    std::vector<CompositeVoxel> colors = surfaces.voxels;
    for (int n = 0; n < options.steps; ++n) {
        if (!report(progress, "looking for the light", 0.4 + 0.6 * n / (options.steps + 1))) return {};
        step(equationsFor(solver, shading, options.colorPasses, colors), shading, colors);
    }
    return judged(equationsFor(solver, shading, options.colorPasses, colors), shading);
}

}  // namespace raysweep
