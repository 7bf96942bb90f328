#include "raysweep/reconstruct/pose_refine.h"

#include "raysweep/camera/pose_motion.h"
#include "raysweep/core/normal_equations.h"
#include "raysweep/core/parallel.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/photo_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace raysweep {
namespace {

constexpr int kSteps = 8;                ///< of a view
constexpr std::size_t kPixels = 4096;    ///< of a picture that has more that show something, about so many are taken
constexpr double kProbe = 0.5;           ///< half of a difference, voxels: so it is no single voxel's slope
constexpr double kOutlier = 0.1;         ///< residual from which on its size counts, not its square; display-encoded
constexpr double kEnough = 0.02;         ///< a step that moves the picture by less is the last, voxels
constexpr double kRounding = 1.0 / 512;  ///< residuals that 8 bits do not tell from 0
constexpr double kMoved = 0.1;           ///< whose picture has moved by more, pixels, goes on if it gains anything
constexpr double kLeast = 0.05;          ///< a camera that moves the picture by less stays, voxels
constexpr double kGain = 0.85;  ///< of the residuals' sum at most so much is left where a pose was wrong: of right ones
                                ///< the lego bulldozer has .91, the Middlebury temple .90, in grids of 32 and 64 voxels

using Equations = NormalEquations<6>;
using Residual = std::array<float, 4>;

/// In [0,1), different for neighbours.
double spread(int x, int y) {
    std::uint32_t h = 0x9e3779b9u;
    for (const int c : {x, y}) {
        h = (h ^ std::uint32_t(c)) * 0x85ebca6bu;
        h ^= h >> 15;
    }
    return (h >> 8) * (1.0 / (1 << 24));
}

double sizeOf(const Residual& r) {
    double sum = 0;
    for (const float value : r) sum += double(value) * value;
    return std::sqrt(sum);
}

/// One view on its way.
class PoseFit {
  public:
    PoseFit(const PhotoLevel& level, const Photograph& picture, const Backdrops& backdrops, int perSlice)
        : level_(level), picture_(picture), backdrops_(backdrops), perSlice_(perSlice), camera_(picture.camera) {
        const Index3 dims = level.grid.dims;
        length_ = 0.5 * level.grid.edge() * Vec3(dims.x, dims.y, dims.z).length();
        choosePixels();
    }

    /// @param gain see kGain
    /// @return whether the camera has moved
    bool run(double gain) {
        const double first = costOf(residualsFrom(camera_));
        if (first <= kRounding * kRounding * double(pixels_.size())) return false;
        double cost = first, damping = 1e-3;
        bool goesOn = true;
        for (int step = 0; step < kSteps && goesOn; ++step) goesOn = makeStep(cost, damping);
        return cost < gain * first && inVoxels(picture_.camera, camera_) > kLeast;
    }

    const PhotoCamera& camera() const { return camera_; }

  private:
    struct Pixel {
        int x, y;
        PixelTarget target;
    };

    CompositeRay rayOf(const PhotoCamera& camera, const Pixel& pixel) const {
        Ray ray = pixelRay(camera, pixel.x + 0.5, pixel.y + 0.5);
        ray.origin = (ray.origin - level_.grid.voxel(0, 0, 0)) / level_.grid.edge();
        return compositeRay(level_.layout, ray, perSlice_);
    }

    /// Those that show something, or would if the pose was right.
    void choosePixels() {
        const Image& matte = picture_.matte;
        for (int y = 0; y < matte.height; ++y)
            for (int x = 0; x < matte.width; ++x) {
                const Pixel pixel{x, y, pixelTarget(matte.at(x, y))};
                if (pixel.target.alpha > 0 || meetsBricks(level_.layout, rayOf(camera_, pixel)))
                    pixels_.push_back(pixel);
            }
        const double part = double(kPixels) / double(std::max(kPixels, pixels_.size()));
        const auto isLeftOut = [&](const Pixel& p) { return spread(p.x, p.y) >= part; };
        pixels_.erase(std::remove_if(pixels_.begin(), pixels_.end(), isLeftOut), pixels_.end());
    }

    std::vector<Residual> residualsFrom(const PhotoCamera& camera) const {
        std::vector<CompositeRay> rays;
        rays.reserve(pixels_.size());
        for (const Pixel& pixel : pixels_) rays.push_back(rayOf(camera, pixel));
        std::vector<RayColor> colors(rays.size());
        composite(level_.layout, level_.voxels.data(), rays.data(), rays.size(), colors.data());
        std::vector<Residual> residuals(rays.size());
        for (std::size_t i = 0; i < rays.size(); ++i)
            residuals[i] = pixelResidual(pixels_[i].target, colors[i], backdrops_);
        return residuals;
    }

    static double costOf(const std::vector<Residual>& residuals) {
        double sum = 0;
        for (const Residual& r : residuals) {
            const double size = sizeOf(r);
            sum += size > kOutlier ? kOutlier * (2 * size - kOutlier) : size * size;
        }
        return sum;
    }

    /// What the residuals say about the unknowns, each slope from renders to both sides.
    Equations equations() const {
        const double probe = kProbe * level_.grid.edge() / length_;
        std::array<std::vector<Residual>, 6> more, less;
        for (std::size_t n = 0; n < 6; ++n) {
            Equations::Vector x{};
            x[n] = probe;
            more[n] = residualsFrom(after(x));
            x[n] = -probe;
            less[n] = residualsFrom(after(x));
        }
        const std::vector<Residual> now = residualsFrom(camera_);
        Equations equations;
        for (std::size_t i = 0; i < now.size(); ++i) {
            const double weight = std::min(1.0, kOutlier / std::max(kOutlier, sizeOf(now[i])));
            for (std::size_t c = 0; c < now[i].size(); ++c) {
                Equations::Vector slopes;
                for (std::size_t n = 0; n < 6; ++n) slopes[n] = (more[n][i][c] - less[n][i][c]) / (2 * probe);
                equations.add(slopes, -now[i][c], weight);
            }
        }
        return equations;
    }

    /// @return whether another step may be worth it
    bool makeStep(double& cost, double& damping) {
        constexpr double kMostDamping = 1e3, kMore = 5, kLess = 0.2;
        const Equations at = equations();
        for (; damping < kMostDamping; damping *= kMore) {
            const PhotoCamera next = after(at.solved(damping));
            const double nextCost = costOf(residualsFrom(next));
            if (nextCost >= cost) continue;
            const bool isSmall = inVoxels(camera_, next) < kEnough;
            cost = nextCost;
            camera_ = next;
            damping *= kLess;
            return !isSmall;
        }
        return false;
    }

    /// Unknowns: turn, and shift over a length, so that each moves the corners of the grid by about as much.
    PhotoCamera after(const Equations::Vector& x) const {
        return moved(camera_, {Vec3(x[0], x[1], x[2]), Vec3(x[3], x[4], x[5]) * length_, 0}, level_.grid.center);
    }

    /// How far a step goes.
    double inVoxels(const PhotoCamera& from, const PhotoCamera& to) const {
        return motionInPicture(from, to, level_.grid.box()) * pixelEdge(from, level_.grid);
    }

    const PhotoLevel& level_;
    const Photograph& picture_;
    Backdrops backdrops_;
    int perSlice_;
    PhotoCamera camera_;
    double length_;  ///< from the middle of the grid to its corners, world units
    std::vector<Pixel> pixels_;
};

}  // namespace

std::optional<std::vector<PhotoCamera>> refinedPoses(const PhotoLevel& level,
                                                     const std::vector<Photograph>& photographs,
                                                     const std::vector<PhotoCamera>& given, const Backdrops& backdrops,
                                                     int perSlice) {
    const std::vector<Photograph> pictures = picturesFor(photographs, level.grid);
    std::vector<PhotoCamera> cameras(pictures.size());
    std::vector<char> hasMoved(pictures.size());
    parallelFor(pictures.size(), [&](std::size_t n) {
        cameras[n] = photographs[n].camera;
        const PhotoCamera& camera = photographs[n].camera;
        if (!std::isfinite(motionInPicture(camera, camera, level.grid.box()))) return;  // it sees no corner
        PoseFit fit(level, pictures[n], backdrops, perSlice);
        const bool wasWrong = motionInPicture(given[n], photographs[n].camera, level.grid.box()) > kMoved;
        hasMoved[n] = fit.run(wasWrong ? 1 : kGain);
        if (hasMoved[n]) cameras[n] = withPose(camera, fit.camera());
    });
    if (std::none_of(hasMoved.begin(), hasMoved.end(), [](char has) { return has; })) return std::nullopt;
    removeCommonMotion(given, level.grid.box(), cameras);
    return cameras;
}

}  // namespace raysweep
