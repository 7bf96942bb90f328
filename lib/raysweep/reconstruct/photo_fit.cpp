// Grid after grid (Level), each from the one before; in each, update after update: rays of some random pixels, the
// derivative of their loss (compositeGradient), now and then smoothness, a step of all bricks.
#include "raysweep/reconstruct/photo_fit.h"

#include "raysweep/camera/object_bounds.h"
#include "raysweep/core/brief.h"
#include "raysweep/core/denormals.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/photo_hull.h"
#include "raysweep/reconstruct/photo_loss.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/reconstruct/voxel_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace raysweep {
namespace {

double psnr(double sumOfSquares, double pixels) {
    return pixels > 0 ? -10 * std::log10(std::max(sumOfSquares / (3 * pixels), 1e-12))
                      : std::numeric_limits<double>::quiet_NaN();
}

/// Means of `factor` x `factor` pixels.
Photograph reduced(const Photograph& photograph, int factor) {
    const Image& from = photograph.matte;
    Photograph to{photograph.name, resized(photograph.camera, from.width / factor, from.height / factor), {}};
    to.matte = Image(from.width / factor, from.height / factor, 4);
    const float part = 1.0f / float(factor * factor);
    for (int y = 0; y < to.matte.height; ++y)
        for (int x = 0; x < to.matte.width; ++x)
            for (int i = 0; i < factor * factor; ++i)
                for (int c = 0; c < 4; ++c)
                    to.matte.at(x, y)[c] += part * from.at(x * factor + i % factor, y * factor + i / factor)[c];
    return to;
}

std::vector<Photograph> reducedTo(const std::vector<Photograph>& photographs, int size) {
    std::vector<Photograph> all(photographs.size());
    parallelFor(all.size(), [&](std::size_t n) {
        const int factor = std::max(photographs[n].matte.width, photographs[n].matte.height) / size;
        all[n] = factor > 1 ? reduced(photographs[n], factor) : photographs[n];
    });
    return all;
}

/// A volume in the making: bricks with parameters, derivatives and moments, 64 bytes a voxel.
struct Level {
    ReconstructionGrid grid;
    CompositeLayout layout;
    std::vector<CompositeVoxel> voxels, gradient;
    std::vector<AdamMoments> moments;
    std::vector<VoxelMask> solid;  ///< voxels that may have extinction; those around them are kept for their colour,
                                   ///< which samples between both take their part of
};

/// All pixels of all pictures, numbered picture after picture, row after row.
class Pixels {
  public:
    explicit Pixels(const std::vector<Photograph>& photographs) : photographs_(photographs) {
        std::uint64_t total = 0;
        for (const Photograph& photograph : photographs) {
            firsts_.push_back(std::uint32_t(total));
            total += std::uint64_t(photograph.matte.width) * std::uint64_t(photograph.matte.height);
        }
        requireField(total < (std::uint64_t(1) << 32), "pixels", total, "fewer than 2^32 in all pictures; reduce them");
        count_ = std::uint32_t(total);
    }

    std::uint32_t count() const { return count_; }

    struct Place {
        const Photograph* photograph;
        int view, x, y;
    };
    Place place(std::uint32_t pixel) const {
        const auto view = std::upper_bound(firsts_.begin(), firsts_.end(), pixel) - firsts_.begin() - 1;
        const Photograph& photograph = photographs_[std::size_t(view)];
        const int number = int(pixel - firsts_[std::size_t(view)]), width = photograph.matte.width;
        return {&photograph, int(view), number % width, number / width};
    }

    CompositeRay ray(std::uint32_t pixel, const Level& level, int perSlice) const {
        const Place at = place(pixel);
        Ray ray = pixelRay(at.photograph->camera, at.x + 0.5, at.y + 0.5);
        ray.origin = (ray.origin - level.grid.voxel(0, 0, 0)) / level.grid.spacing;
        return compositeRay(level.layout, ray, perSlice);
    }

    PixelTarget target(std::uint32_t pixel) const {
        const Place at = place(pixel);
        return pixelTarget(at.photograph->matte.at(at.x, at.y));
    }

  private:
    const std::vector<Photograph>& photographs_;
    std::vector<std::uint32_t> firsts_;
    std::uint32_t count_ = 0;
};

/// Whether a pixel is one of those that are compared with but not fitted: in blocks, because neighbours know each
/// other.
bool isLeftOut(const Pixels::Place& at, const PhotoFitOptions& options) {
    std::uint32_t h = options.seed * 0x9e3779b9u;
    for (const int c : {at.view, at.x / 8, at.y / 8}) {
        h = (h ^ std::uint32_t(c)) * 0x85ebca6bu;
        h ^= h >> 15;
    }
    return (h >> 8) * (1.0 / (1 << 24)) < options.leftOut;
}

/// Pixels whose rays meet something.
struct PixelSets {
    std::vector<std::uint32_t> fitted, leftOut;
};

PixelSets pixelsMeeting(const Pixels& pixels, const Level& level, const PhotoFitOptions& options) {
    constexpr std::uint32_t kTogether = 4096;
    std::vector<PixelSets> parts((pixels.count() + kTogether - 1) / kTogether);
    parallelFor(parts.size(), [&](std::size_t n) {
        const std::uint32_t first = std::uint32_t(n) * kTogether;
        for (std::uint32_t p = first; p < std::min(pixels.count(), first + kTogether); ++p) {
            if (!meetsBricks(level.layout, pixels.ray(p, level, options.samplesPerSlice))) continue;
            (isLeftOut(pixels.place(p), options) ? parts[n].leftOut : parts[n].fitted).push_back(p);
        }
    });
    PixelSets all;
    for (const PixelSets& part : parts) {
        all.fitted.insert(all.fitted.end(), part.fitted.begin(), part.fitted.end());
        all.leftOut.insert(all.leftOut.end(), part.leftOut.begin(), part.leftOut.end());
    }
    return all;
}

std::vector<std::uint32_t> shuffled(std::vector<std::uint32_t> pixels, std::mt19937& random) {
    for (std::size_t i = pixels.size(); i > 1; --i) std::swap(pixels[i - 1], pixels[random() % i]);
    return pixels;
}

/// Rays of some pixels, in the order of their axes, and what they should see.
struct Batch {
    std::vector<std::uint32_t> pixels;
    std::vector<CompositeRay> rays;
    std::vector<PixelTarget> targets;
    std::vector<float> errors;  ///< before white

    void set(const Pixels& all, const std::uint32_t* chosen, std::size_t count, const Level& level, int perSlice) {
        pixels.assign(chosen, chosen + count);
        std::sort(pixels.begin(), pixels.end());  // neighbours meet the same bricks
        unsorted_.resize(count);
        parallelFor(
            count, [&](std::size_t i) { unsorted_[i] = all.ray(pixels[i], level, perSlice); }, 256);
        order_.clear();
        for (int axis = 0; axis < 3; ++axis)
            for (std::size_t i = 0; i < count; ++i)
                if (unsorted_[i].axis == axis) order_.push_back(i);
        rays.resize(count);
        targets.resize(count);
        parallelFor(
            count,
            [&](std::size_t i) {
                rays[i] = unsorted_[order_[i]];
                targets[i] = all.target(pixels[order_[i]]);
            },
            256);
        errors.assign(count, 0);
    }

    double error() const {
        return orderedSum(
            errors.size(), [&](std::size_t i) { return double(errors[i]); }, 1024);
    }

  private:
    std::vector<CompositeRay> unsorted_;
    std::vector<std::size_t> order_;
};

/// A finer grid is not kept if left-out pixels are met worse by this, dB. They lie among pixels that are fitted, so
/// their word on views from elsewhere is weak: of the Middlebury temple they lose .5 dB from 64 to 128 voxels, while
/// views that were held out gain .9.
constexpr double kWorse = 1;

ReconstructionGrid gridOf(const Box3& box, int resolution) {
    ReconstructionGrid grid;
    const Vec3 size = box.size();
    grid.spacing = std::max({size.x, size.y, size.z}) / resolution;
    grid.center = box.center();
    for (int axis = 0; axis < 3; ++axis)
        grid.dims[axis] = std::clamp(int(std::ceil(size[axis] / grid.spacing / 8 - 1e-6)) * 8, 8, resolution);
    return grid;
}

/// What a level's voxels are at a place between them.
class Interpolated {
  public:
    explicit Interpolated(const Level& level) : level_(level) {}

    /// @return colour of what is kept; extinction; and in `most` the largest extinction of the voxels around
    CompositeVoxel at(const Vec3& world, float& most) const {
        const Vec3 place = (world - level_.grid.voxel(0, 0, 0)) / level_.grid.spacing;
        CompositeVoxel sum;
        float colors = 0;
        most = 0;
        for (int corner = 0; corner < 8; ++corner) {
            float weight = 1;
            Index3 voxel;
            for (int axis = 0; axis < 3; ++axis) {
                const double below = std::floor(place[axis]);
                const bool upper = (corner >> axis & 1) != 0;
                weight *= float(upper ? place[axis] - below : 1 - (place[axis] - below));
                voxel[axis] = int(below) + upper;
            }
            bool inside = true;
            for (int axis = 0; axis < 3; ++axis) inside &= voxel[axis] >= 0 && voxel[axis] < level_.grid.dims[axis];
            if (!inside) continue;
            const std::size_t i = level_.layout.voxel(voxel);
            if (!isSet(level_.layout.masks[i >> 9], int(i >> 6 & 7), int(i >> 3 & 7), int(i & 7))) continue;
            const CompositeVoxel& v = level_.voxels[i];
            sum.extinction += weight * v.extinction;
            sum.red += weight * v.red;
            sum.green += weight * v.green;
            sum.blue += weight * v.blue;
            colors += weight;
            most = std::max(most, v.extinction);
        }
        if (colors > 0) {
            sum.red /= colors;
            sum.green /= colors;
            sum.blue /= colors;
        }
        return sum;
    }

  private:
    const Level& level_;
};

bool isSolid(const Level& level, std::size_t voxel) {
    return isSet(level.solid[voxel >> 9], int(voxel >> 6 & 7), int(voxel >> 3 & 7), int(voxel & 7));
}

/// Calls `body(voxel's index, its place)` for all voxels that are kept, several bricks at a time.
template <class Body>
void forKept(const Level& level, const Body& body) {
    parallelFor(level.layout.brickCount() - 1, [&](std::size_t n) {
        const std::size_t b = n + 1;
        for (int i = 0; i < 512; ++i) {
            const Index3 within(i >> 6, i >> 3 & 7, i & 7);
            if (isSet(level.layout.masks[b], within.x, within.y, within.z))
                body(b * 512 + std::size_t(i), level.layout.origins[b] + within);
        }
    });
}

/// A level with these voxels, all 0.
Level emptyLevel(const ReconstructionGrid& grid, const std::vector<MaskedBrick>& solid) {
    Level level;
    level.grid = grid;
    level.layout = compositeLayout(grid.dims, withNeighbours(solid, grid.dims), solid);
    level.solid.assign(level.layout.brickCount(), {});
    for (const MaskedBrick& brick : solid)
        if (brick.mask != VoxelMask{}) level.solid[level.layout.voxel(brick.origin) / 512] = brick.mask;

    level.voxels.assign(level.layout.voxelCount(), {});
    level.gradient.assign(level.layout.voxelCount(), {});
    level.moments.assign(level.layout.voxelCount(), {});
    return level;
}

/// The first grid: all of the hull in the same grey haze.
Level firstLevel(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                 const PhotoFitOptions& options) {
    Level level = emptyLevel(grid, photoHull(photographs, grid, float(options.hullThreshold)));
    if (level.layout.brickCount() == 1)
        throw InvalidArgument("the photographs show nothing that all of them could see; check mattes and poses");
    constexpr float kHaze = 0.05f, kGrey = 0.25f;
    forKept(level, [&](std::size_t i, const Index3&) {
        level.voxels[i] = {isSolid(level, i) ? kHaze : 0, kGrey, kGrey, kGrey};
    });
    return level;
}

/// The next grid: what the coarse one has there, without what that has emptied.
Level finerLevel(const Level& coarse, const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                 const PhotoFitOptions& options) {
    const Interpolated from(coarse);
    std::vector<MaskedBrick> bricks = photoHull(photographs, grid, float(options.hullThreshold));
    parallelFor(bricks.size(), [&](std::size_t b) {
        MaskedBrick& brick = bricks[b];
        for (int i = 0; i < 512; ++i) {
            const Index3 at = brick.origin + Index3(i >> 6, i >> 3 & 7, i & 7);
            float most = 0;
            from.at(grid.voxel(at.x, at.y, at.z), most);
            if (most < options.prune) brick.mask[std::size_t(i >> 6)] &= ~(std::uint64_t(1) << (i & 63));
        }
    });
    Level level = emptyLevel(grid, bricks);
    const float finer = float(grid.spacing / coarse.grid.spacing);
    forKept(level, [&](std::size_t i, const Index3& at) {
        float most;
        level.voxels[i] = from.at(grid.voxel(at.x, at.y, at.z), most);
        level.voxels[i].extinction *= isSolid(level, i) ? finer : 0;
    });
    return level;
}

/// The updates of one level.
class LevelFit {
  public:
    LevelFit(Level& level, const Pixels& pixels, const PhotoFitOptions& options, const Timer& timer,
             PhotoFitResult& result)
        : level_(level),
          pixels_(pixels),
          options_(options),
          timer_(timer),
          result_(result),
          sets_(pixelsMeeting(pixels, level, options)),
          random_(options.seed),
          kept_(level.layout.keptVoxels()) {}

    /// @return false if the callback said stop
    bool run(double passes, const ProgressCallback& progress, double from, double to) {
        const Timer timer;
        const std::size_t perPass = std::max<std::size_t>(
            1, (sets_.fitted.size() + options_.raysPerUpdate - 1) / std::size_t(options_.raysPerUpdate));
        const int updates = std::max(1, int(std::lround(passes * double(perPass))));
        bool goesOn = true;
        for (int n = 0; n < updates && goesOn; ++n) {
            if (std::size_t(n) % perPass == 0) order_ = shuffled(sets_.fitted, random_);
            update(n, double(n) / updates, std::size_t(n) % perPass);
            goesOn = report(progress, howItGoes(), from + (to - from) * (n + 1) / updates);
            if (std::size_t(n) % perPass == perPass - 1 || n == updates - 1) addPoint();
        }
        result_.timings.updates += timer.seconds();
        return goesOn;
    }

  private:
    void update(int number, double done, std::size_t piece) {
        const std::size_t together = std::size_t(options_.raysPerUpdate), first = piece * together;
        const std::size_t count = std::min(together, sets_.fitted.size() - first);
        batch_.set(pixels_, order_.data() + first, count, level_, options_.samplesPerSlice);
        const Backdrops backdrops{float(options_.backdrop), float(options_.backdropSpread)};
        compositeGradient(
            level_.layout, level_.voxels.data(), batch_.rays,
            [&](std::size_t at, std::size_t some, const RayColor* colors, RayColor* derivatives) {
                for (std::size_t i = 0; i < some; ++i)
                    batch_.errors[at + i] = pixelLoss(batch_.targets[at + i], colors[i], backdrops, derivatives[i]);
            },
            tape_, level_.gradient.data());
        result_.samples += double(tape_.samples);
        error_ += batch_.error();
        seen_ += double(count);
        if (number % kSmoothEvery == 0) smooth(double(count) / double(kept_));
        step(number, done);
        ++updates_;
    }

    void smooth(double raysPerVoxel) {
        const float weight = float(raysPerVoxel * kSmoothEvery);
        SmoothWeights weights;
        weights.extinction = weight * float(options_.smoothExtinction);
        weights.color = weight * float(options_.smoothColor);
        weights.sparsity = weight * float(options_.sparsity);
        parallelFor(level_.layout.brickCount() - 1, [&](std::size_t n) {
            smoothBrick(level_.layout, level_.voxels.data(), n + 1, weights, level_.gradient.data() + (n + 1) * 512);
        });
    }

    void step(int number, double done) {
        AdamStep step;
        const double rate = std::pow(options_.lastRate, done);
        step.extinctionRate = float(options_.extinctionRate * rate);
        step.colorRate = float(options_.colorRate * rate);
        step.correction1 = 1 / (1 - std::pow(step.decay1, float(number + 1)));
        step.correction2 = 1 / (1 - std::pow(step.decay2, float(number + 1)));
        parallelFor(level_.layout.brickCount() - 1, [&](std::size_t n) {
            const std::size_t first = (n + 1) * 512;
            stepBrick(level_.voxels.data() + first, level_.gradient.data() + first, level_.moments.data() + first,
                      {level_.layout.masks[n + 1], level_.solid[n + 1]}, step);
        });
    }

    std::string howItGoes() const {
        return "fitting: " + std::to_string(level_.grid.dims.x) + " voxels along x, " + brief(psnr(error_, seen_), 3) +
               " dB";
    }

    double leftOutPsnr() {
        if (sets_.leftOut.empty()) return std::numeric_limits<double>::quiet_NaN();
        batch_.set(pixels_, sets_.leftOut.data(), sets_.leftOut.size(), level_, options_.samplesPerSlice);
        std::vector<RayColor> colors(batch_.rays.size());
        composite(level_.layout, level_.voxels.data(), batch_.rays.data(), batch_.rays.size(), colors.data());
        for (std::size_t i = 0; i < colors.size(); ++i) {
            RayColor unused;
            batch_.errors[i] = pixelLoss(batch_.targets[i], colors[i], {}, unused);
        }
        return psnr(batch_.error(), double(colors.size()));
    }

    void addPoint() {
        const int before = result_.history.empty() ? 0 : result_.history.back().updates;
        result_.history.push_back(
            {before + updates_, timer_.seconds(), level_.grid.dims.x, psnr(error_, seen_), leftOutPsnr()});
        error_ = seen_ = 0;
        updates_ = 0;
    }

    static constexpr int kSmoothEvery = 4;  ///< updates; weighted accordingly

    Level& level_;
    const Pixels& pixels_;
    const PhotoFitOptions& options_;
    const Timer& timer_;
    PhotoFitResult& result_;
    PixelSets sets_;
    std::vector<std::uint32_t> order_;  ///< of the fitted pixels in this pass
    std::mt19937 random_;
    std::size_t kept_;
    Batch batch_;
    CompositeTape tape_;
    double error_ = 0, seen_ = 0;  ///< since the last point of the history
    int updates_ = 0;
};

void addGrids(const Level& level, PhotoFitResult& result) {
    const auto transform = level.grid.transform();
    result.density = openvdb::FloatGrid::create(0);
    result.opacity = openvdb::FloatGrid::create(0);
    result.color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
    result.density->setName("density");
    result.opacity->setName("opacity");
    result.color->setName("Cd");
    for (const openvdb::GridBase::Ptr& grid :
         {openvdb::GridBase::Ptr(result.density), openvdb::GridBase::Ptr(result.opacity),
          openvdb::GridBase::Ptr(result.color)})
        grid->setTransform(transform->copy());
    result.density->setGridClass(openvdb::GRID_FOG_VOLUME);
    auto density = result.density->getAccessor(), opacity = result.opacity->getAccessor();
    auto color = result.color->getAccessor();
    for (std::size_t b = 1; b < level.layout.brickCount(); ++b)
        for (int i = 0; i < 512; ++i) {
            const Index3 within(i >> 6, i >> 3 & 7, i & 7), at = level.layout.origins[b] + within;
            if (!isSet(level.layout.masks[b], within.x, within.y, within.z)) continue;
            const CompositeVoxel& voxel = level.voxels[b * 512 + std::size_t(i)];
            const openvdb::Coord place(at.x, at.y, at.z);
            if (isSolid(level, b * 512 + std::size_t(i))) {
                density.setValue(place, float(voxel.extinction / level.grid.spacing));
                opacity.setValue(place, 1 - std::exp(-voxel.extinction));
            }
            color.setValue(place, openvdb::Vec3s(voxel.red, voxel.green, voxel.blue));
        }
}

void requireUsable(const std::vector<Photograph>& photographs) {
    if (photographs.empty()) throw InvalidArgument("no photographs");
    for (const Photograph& photograph : photographs) {
        photograph.camera.validate();
        if (photograph.matte.channels != 4)
            throw InvalidArgument(photograph.name + " has no alpha; free it of its backdrop first");
        if (photograph.camera.width != photograph.matte.width || photograph.camera.height != photograph.matte.height)
            throw InvalidArgument(photograph.name + " is not of the size that its camera has");
    }
}

}  // namespace

void PhotoFitOptions::validate() const {
    requireField(resolution >= 16 && resolution <= 1024 && resolution % 8 == 0, "resolution", resolution,
                 "a multiple of 8, from 16 to 1024");
    requireField(levels >= 1 && levels <= 8, "levels", levels, "from 1 to 8");
    requireField(coarsePasses > 0 && std::isfinite(coarsePasses), "coarsePasses", coarsePasses, "above 0");
    requireField(passes > 0 && std::isfinite(passes), "passes", passes, "above 0");
    requireField(pictureSize > 0, "pictureSize", pictureSize, "at least 1");
    requireField(samplesPerSlice > 0 && samplesPerSlice <= 16, "samplesPerSlice", samplesPerSlice, "from 1 to 16");
    requireField(raysPerUpdate > 0, "raysPerUpdate", raysPerUpdate, "at least 1");
    requireField(extinctionRate > 0 && std::isfinite(extinctionRate), "extinctionRate", extinctionRate, "above 0");
    requireField(colorRate > 0 && std::isfinite(colorRate), "colorRate", colorRate, "above 0");
    requireField(lastRate > 0 && lastRate <= 1, "lastRate", lastRate, "in (0,1]");
    requireField(smoothExtinction >= 0 && std::isfinite(smoothExtinction), "smoothExtinction", smoothExtinction,
                 "0 or more, and finite");
    requireField(smoothColor >= 0 && std::isfinite(smoothColor), "smoothColor", smoothColor, "0 or more, and finite");
    requireField(sparsity >= 0 && std::isfinite(sparsity), "sparsity", sparsity, "0 or more, and finite");
    requireField(backdrop >= 0 && backdrop <= 1, "backdrop", backdrop, "in [0,1]");
    requireField(backdropSpread > 0 && backdropSpread <= 1, "backdropSpread", backdropSpread, "in (0,1]");
    requireField(hullThreshold >= 0 && hullThreshold < 1, "hullThreshold", hullThreshold, "in [0,1)");
    requireField(prune >= 0 && std::isfinite(prune), "prune", prune, "0 or more, and finite");
    requireField(leftOut >= 0 && leftOut < 0.5, "leftOut", leftOut, "in [0,0.5)");
}

PhotoFitResult fitPhotographs(const std::vector<Photograph>& photographs, const PhotoFitOptions& options,
                              const ProgressCallback& progress) {
    options.validate();
    requireUsable(photographs);
    const Timer timer;
    PhotoFitResult result;
    const std::vector<Photograph> pictures = reducedTo(photographs, options.pictureSize);
    const Pixels pixels(pictures);
    const Box3 box = options.box ? *options.box : boundsOf(pictures);
    const double all = options.coarsePasses * (options.levels - 1) + options.passes;
    double done = 0;
    Level level, coarser;
    for (int n = 0; n < options.levels; ++n) {
        const int finest = options.levels - 1;
        const ReconstructionGrid grid = gridOf(box, std::max(8, options.resolution >> (finest - n)));
        level.gradient = std::vector<CompositeVoxel>();
        level.moments = std::vector<AdamMoments>();
        coarser = std::move(level);
        level = n == 0 ? firstLevel(pictures, grid, options) : finerLevel(coarser, pictures, grid, options);
        const double before = result.history.empty() ? 0 : result.history.back().leftOut;
        const double passes = n == finest ? options.passes : options.coarsePasses;
        if (!LevelFit(level, pixels, options, timer, result).run(passes, progress, done / all, (done + passes) / all)) {
            result.termination = PhotoFitTermination::interrupted;
            break;
        }
        done += passes;
        if (n > 0 && result.history.back().leftOut < before - kWorse) {
            level = std::move(coarser);
            result.termination = PhotoFitTermination::overfitted;
            break;
        }
    }
    result.keptVoxels = level.layout.keptVoxels();
    result.dims = level.grid.dims;
    addGrids(level, result);
    result.timings.total = timer.seconds();
    result.timings.prepared = result.timings.total - result.timings.updates;
    return result;
}

}  // namespace raysweep
