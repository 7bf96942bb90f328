// Grid after grid (PhotoLevel), each from the one before; in each, update after update: rays of some random pixels, the
// derivative of their loss (compositeGradient), now and then smoothness, a step of all bricks.
#include "raysweep/reconstruct/photo_fit.h"

#include "raysweep/camera/object_bounds.h"
#include "raysweep/camera/pose_motion.h"
#include "raysweep/core/brief.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/grid_lattice.h"
#include "raysweep/reconstruct/photo_level.h"
#include "raysweep/reconstruct/photo_loss.h"
#include "raysweep/reconstruct/photo_pixels.h"
#include "raysweep/reconstruct/photo_reference.h"
#include "raysweep/reconstruct/photo_views.h"
#include "raysweep/reconstruct/pose_refine.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/reconstruct/voxel_fit.h"
#include "raysweep/volume/color_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace raysweep {
namespace {

double rms(double sumOfSquares, double pixels) {
    return pixels > 0 ? std::sqrt(sumOfSquares / (3 * pixels)) : std::numeric_limits<double>::quiet_NaN();
}

std::vector<Photograph> reducedTo(const std::vector<Photograph>& photographs, int size) {
    std::vector<Photograph> all(photographs.size());
    parallelFor(all.size(), [&](std::size_t n) {
        const int factor = std::max(photographs[n].matte.width, photographs[n].matte.height) / size;
        all[n] = factor > 1 ? reduced(photographs[n], factor) : photographs[n];
    });
    return all;
}

/// A finer grid is not kept if left-out pixels are met worse by this factor, 1 dB. They lie among pixels that are
/// fitted, so their word on views from elsewhere is weak: of the Middlebury temple they lose .5 dB from 64 to 128
/// voxels, while views that were held out gain .9.
constexpr double kWorse = 1.122;

std::vector<std::uint32_t> shuffled(std::vector<std::uint32_t> pixels, std::mt19937& random) {
    for (std::size_t i = pixels.size(); i > 1; --i) std::swap(pixels[i - 1], pixels[random() % i]);
    return pixels;
}

/// How smooth the volume is kept follows from pixels that are left out. Every now and then their loss is differentiated
/// along what a step of smoothing does: if less variation would meet them better it weighs more (J. Luketina and
/// others, "Scalable Gradient-Based Tuning of Continuous Regularization Hyperparameters", ICML 2016). Colour is asked,
/// extinction goes along: while surfaces are still getting sharper, smoothing them looks worse than it proves to be.
class Smoothness {
  public:
    explicit Smoothness(double weight) : weight_(weight) {}

    double weight() const { return weight_; }

    /// Adam on the logarithm of the weight. @param helps as smoothingHelps, of the whole volume
    void follow(double helps) {
        constexpr double kRate = 0.15, kKeep = 0.7, kKeepSquare = 0.9;
        mean_ = kKeep * mean_ + (1 - kKeep) * helps;
        square_ = kKeepSquare * square_ + (1 - kKeepSquare) * helps * helps;
        if (square_ > 0) weight_ *= std::exp(kRate * mean_ / std::sqrt(square_));
    }

  private:
    double weight_, mean_ = 0, square_ = 0;
};

/// The updates of one level.
class LevelFit {
  public:
    LevelFit(PhotoLevel& level, const PhotoPixels& pixels, const PhotoFitOptions& options, Smoothness& smoothness,
             const Timer& timer, PhotoReconstruction& result)
        : level_(level),
          pixels_(pixels),
          options_(options),
          smoothness_(smoothness),
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
        differentiate(order_.data() + first, count);
        result_.samples += double(tape_.samples);
        error_ += batch_.error();
        seen_ += double(count);
        if (number % kSmoothEvery == 0) smooth(double(count) / double(kept_));
        step(number, done);
        ++result_.updates;
        if (options_.adaptSmoothness && number % kTuneEvery == kTuneEvery - 1) tuneSmoothness();
    }

    /// By some of the pixels that are left out, the next each time.
    void tuneSmoothness() {
        if (sets_.leftOut.empty()) return;
        const std::size_t count = std::min(sets_.leftOut.size(), std::size_t(options_.raysPerUpdate) / 4);
        if (nextLeftOut_ + count > sets_.leftOut.size()) nextLeftOut_ = 0;
        if (nextLeftOut_ == 0) sets_.leftOut = shuffled(sets_.leftOut, random_);
        differentiate(sets_.leftOut.data() + nextLeftOut_, count);
        nextLeftOut_ += count;
        const std::size_t bricks = level_.layout.brickCount() - 1;
        std::vector<double> helps(bricks);
        parallelFor(bricks, [&](std::size_t n) {
            const std::size_t first = (n + 1) * 512;
            CompositeVoxel* gradient = level_.gradient.data() + first;
            helps[n] = smoothingHelps(level_.layout, level_.voxels.data(), n + 1, gradient, &level_.moments[first]);
            std::fill_n(gradient, 512, CompositeVoxel());
        });
        smoothness_.follow(std::accumulate(helps.begin(), helps.end(), 0.0));
    }

    /// Adds the derivative of some pixels' loss to the level's.
    void differentiate(const std::uint32_t* chosen, std::size_t count) {
        batch_.set(pixels_, chosen, count, level_, options_.samplesPerSlice);
        const Backdrops backdrops{float(options_.backdrop), float(options_.backdropSpread)};
        compositeGradient(
            level_.layout, level_.voxels.data(), batch_.rays,
            [&](std::size_t at, std::size_t some, const RayColor* colors, RayColor* derivatives) {
                for (std::size_t i = 0; i < some; ++i)
                    batch_.errors[at + i] = pixelLoss(batch_.targets[at + i], colors[i], backdrops, derivatives[i]);
            },
            tape_, level_.gradient.data());
    }

    void smooth(double raysPerVoxel) {
        const float weight = float(raysPerVoxel * kSmoothEvery);
        SmoothWeights weights;
        weights.extinction = weights.color = weight * float(smoothness_.weight());
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
        return "fitting: " + std::to_string(level_.grid.resolution()) + " voxels along the longest edge, " +
               brief(-20 * std::log10(std::max(rms(error_, seen_), 1e-6)), 3) + " dB";
    }

    double leftOutError() {
        if (sets_.leftOut.empty()) return std::numeric_limits<double>::quiet_NaN();
        batch_.set(pixels_, sets_.leftOut.data(), sets_.leftOut.size(), level_, options_.samplesPerSlice);
        std::vector<RayColor> colors(batch_.rays.size());
        composite(level_.layout, level_.voxels.data(), batch_.rays.data(), batch_.rays.size(), colors.data());
        for (std::size_t i = 0; i < colors.size(); ++i) {
            RayColor unused;
            batch_.errors[i] = pixelLoss(batch_.targets[i], colors[i], {}, unused);
        }
        return rms(batch_.error(), double(colors.size()));
    }

    void addPoint() {
        PhotoPoint point;
        point.updates = result_.updates;
        point.seconds = timer_.seconds();
        point.resolution = level_.grid.resolution();
        point.imageError = rms(error_, seen_);
        point.leftOut = leftOutError();
        result_.history.push_back(point);
        error_ = seen_ = 0;
    }

    static constexpr int kSmoothEvery = 4;  ///< updates; weighted accordingly
    static constexpr int kTuneEvery = 8;    ///< updates

    PhotoLevel& level_;
    const PhotoPixels& pixels_;
    const PhotoFitOptions& options_;
    Smoothness& smoothness_;
    const Timer& timer_;
    PhotoReconstruction& result_;
    PixelSets sets_;
    std::vector<std::uint32_t> order_;  ///< of the fitted pixels in this pass
    std::mt19937 random_;
    std::size_t kept_;
    std::size_t nextLeftOut_ = 0;
    PhotoBatch batch_;
    CompositeTape tape_;
    double error_ = 0, seen_ = 0;  ///< since the last point of the history
};

/// How often the first grid is made anew with the poses that it has refined: a wrong pose takes from the hull what the
/// object needs.
constexpr int kMostRounds = 3;

std::vector<PhotoCamera> camerasOf(const std::vector<Photograph>& photographs) {
    std::vector<PhotoCamera> cameras;
    for (const Photograph& photograph : photographs) cameras.push_back(photograph.camera);
    return cameras;
}

/// @return whether a camera has moved
bool refinePoses(const PhotoLevel& level, const std::vector<PhotoCamera>& given, const PhotoFitOptions& options,
                 std::vector<Photograph>& pictures) {
    const Backdrops backdrops{float(options.backdrop), float(options.backdropSpread)};
    const std::optional<std::vector<PhotoCamera>> cameras =
        refinedPoses(level, pictures, given, backdrops, options.samplesPerSlice);
    for (std::size_t n = 0; cameras && n < pictures.size(); ++n) pictures[n].camera = (*cameras)[n];
    return cameras.has_value();
}

/// The photographs' cameras, moved as those of the smaller pictures were.
std::vector<RefinedPose> refinedFrom(const std::vector<Photograph>& photographs,
                                     const std::vector<Photograph>& pictures, const Box3& box) {
    std::vector<RefinedPose> poses;
    for (std::size_t n = 0; n < photographs.size(); ++n) {
        const PhotoCamera& given = photographs[n].camera;
        const PhotoCamera camera = withPose(given, pictures[n].camera);
        poses.push_back({camera, angleBetween(given, camera), motionInPicture(given, camera, box)});
    }
    return poses;
}

void addGrids(const PhotoLevel& level, PhotoReconstruction& result) {
    const auto transform = level.grid.transform();
    result.density = openvdb::FloatGrid::create(0);
    result.density->setName("density");
    result.density->setGridClass(openvdb::GRID_FOG_VOLUME);
    result.density->setTransform(transform);
    const auto color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
    color->setTransform(transform);
    auto toDensity = result.density->getAccessor();
    auto toColor = color->getAccessor();
    for (std::size_t b = 1; b < level.layout.brickCount(); ++b)
        for (int i = 0; i < 512; ++i) {
            const Index3 within(i >> 6, i >> 3 & 7, i & 7), at = level.layout.origins[b] + within;
            if (!isSet(level.layout.masks[b], within.x, within.y, within.z)) continue;
            const std::size_t n = b * 512 + std::size_t(i);
            const CompositeVoxel& voxel = level.voxels[n];
            const openvdb::Coord place(at.x, at.y, at.z);
            if (level.isSolid(n)) toDensity.setValue(place, float(voxel.extinction / level.grid.spacing));
            toColor.setValue(place, openvdb::Vec3s(voxel.red, voxel.green, voxel.blue));
        }
    result.opacity = opacityGrid(*result.density);
    result.color = extendedColor(*color, *result.density);
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
    requireField(smoothness >= 0 && std::isfinite(smoothness), "smoothness", smoothness, "0 or more, and finite");
    requireField(sparsity >= 0 && std::isfinite(sparsity), "sparsity", sparsity, "0 or more, and finite");
    requireField(backdrop >= 0 && backdrop <= 1, "backdrop", backdrop, "in [0,1]");
    requireField(backdropSpread > 0 && backdropSpread <= 1, "backdropSpread", backdropSpread, "in (0,1]");
    requireField(hullThreshold >= 0 && hullThreshold < 1, "hullThreshold", hullThreshold, "in [0,1)");
    requireField(prune >= 0 && std::isfinite(prune), "prune", prune, "0 or more, and finite");
    requireField(leftOut >= 0 && leftOut < 0.5, "leftOut", leftOut, "in [0,0.5)");
}

PhotoReconstruction fitPhotographs(const std::vector<Photograph>& photographs, const PhotoFitOptions& options,
                                   const ColorVolume* reference, const ProgressCallback& progress) {
    options.validate();
    requireUsable(photographs);
    const Timer timer;
    PhotoReconstruction result;
    std::vector<Photograph> pictures = reducedTo(photographs, options.pictureSize);
    const std::vector<PhotoCamera> given = camerasOf(pictures);
    const PhotoPixels pixels(pictures);
    const Box3 box = options.box ? *options.box : boundsOf(pictures);
    const double all = options.coarsePasses * (options.levels - 1) + options.passes;
    double done = 0;
    const float hull = float(options.hullThreshold);
    PhotoLevel level, coarser;
    Smoothness smoothness(options.smoothness);
    const int finest = options.levels - 1;
    bool again = false;
    for (int n = 0, rounds = 0; n < options.levels; n += !again) {
        const ReconstructionGrid grid = photoGrid(box, std::max(8, options.resolution >> (finest - n)));
        level.gradient = std::vector<CompositeVoxel>();
        level.moments = std::vector<AdamMoments>();
        coarser = std::move(level);
        level =
            n == 0 ? firstLevel(pictures, grid, hull) : finerLevel(coarser, pictures, grid, hull, float(options.prune));
        const double before = result.history.empty() ? 0 : result.history.back().leftOut;
        const double passes = n == finest ? options.passes : options.coarsePasses;
        if (!LevelFit(level, pixels, options, smoothness, timer, result)
                 .run(passes, progress, done / all, (done + passes) / all)) {
            result.termination = PhotoTermination::interrupted;
            break;
        }
        const bool moved = options.refinePoses && n < finest && refinePoses(level, given, options, pictures);
        again = moved && n == 0 && ++rounds < kMostRounds;
        if (again) continue;
        done += passes;
        if (n > 0 && result.history.back().leftOut > kWorse * before) {
            level = std::move(coarser);
            result.termination = PhotoTermination::overfitted;
            break;
        }
    }
    if (options.refinePoses) result.poses = refinedFrom(photographs, pictures, level.grid.box());
    result.keptVoxels = level.layout.keptVoxels();
    result.resolution = level.grid.resolution();
    result.smoothness = smoothness.weight();
    addGrids(level, result);
    if (reference && !result.history.empty() && shiftTo(*reference->density, level.grid))
        PhotoReference(*reference, level.grid, level.layout)
            .compare([&](std::size_t i) { return matterOf(level.voxels[i]); }, result.history.back());
    result.timings.total = timer.seconds();
    result.timings.prepared = result.timings.total - result.timings.updates;
    return result;
}

}  // namespace raysweep
