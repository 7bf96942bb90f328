// Grid after grid (PhotoLevel), each from the one before; in each, update after update: rays of some random pixels, the
// derivative of their loss (compositeGradient), now and then smoothness, a step of all bricks.
#include "raysweep/reconstruct/photo_fit.h"

#include "raysweep/camera/object_bounds.h"
#include "raysweep/core/brief.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/grid_lattice.h"
#include "raysweep/reconstruct/photo_directional.h"
#include "raysweep/reconstruct/photo_level.h"
#include "raysweep/reconstruct/photo_loss.h"
#include "raysweep/reconstruct/photo_pixels.h"
#include "raysweep/reconstruct/photo_reference.h"
#include "raysweep/reconstruct/photo_views.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/reconstruct/voxel_fit.h"
#include "raysweep/volume/color_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
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

template <class Item>
std::vector<Item> shuffled(std::vector<Item> items, std::mt19937& random) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random() % i]);
    return items;
}

/// Pixels of one update, in the order of a pass.
struct Piece {
    std::size_t first, count;
};

std::vector<Piece> piecesOf(std::size_t first, std::size_t count, std::size_t most) {
    std::vector<Piece> pieces;
    for (std::size_t at = 0; at < count; at += most) pieces.push_back({first + at, std::min(most, count - at)});
    return pieces;
}

/// Of one view each: sorts the pixels by views. In each view they keep their order.
std::vector<Piece> piecesByView(const PhotoPixels& pixels, std::vector<std::uint32_t>& order, std::size_t most) {
    std::vector<Piece> pieces;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return pixels.view(a) < pixels.view(b); });
    for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
        const int view = pixels.view(order[first]);
        while (last < order.size() && pixels.view(order[last]) == view) ++last;
        const std::size_t count = last - first, parts = (count + most - 1) / most;  // of equal size: steps are
        const std::vector<Piece> some = piecesOf(first, count, (count + parts - 1) / parts);
        pieces.insert(pieces.end(), some.begin(), some.end());
    }
    return pieces;
}

/// The updates of one level.
class LevelFit {
  public:
    LevelFit(PhotoLevel& level, const PhotoPixels& pixels, const PhotoFitOptions& options, const Timer& timer,
             PhotoReconstruction& result)
        : level_(level),
          pixels_(pixels),
          options_(options),
          timer_(timer),
          result_(result),
          sets_(pixelsMeeting(pixels, level, options)),
          random_(options.seed),
          kept_(level.layout.keptVoxels()) {
        startPass();
    }

    /// @return false if the callback said stop
    bool run(double passes, const ProgressCallback& progress, double from, double to) {
        const Timer timer;
        const std::size_t perPass = pieces_.size();
        const int updates = std::max(1, int(std::lround(passes * double(perPass))));
        bool goesOn = true;
        for (int n = 0; n < updates && goesOn; ++n) {
            if (n > 0 && std::size_t(n) % perPass == 0) startPass();
            update(n, double(n) / updates, pieces_[std::size_t(n) % perPass]);
            goesOn = report(progress, howItGoes(), from + (to - from) * (n + 1) / updates);
            if (std::size_t(n) % perPass == perPass - 1 || n == updates - 1) addPoint();
        }
        result_.timings.updates += timer.seconds();
        return goesOn;
    }

  private:
    void startPass() {
        order_ = shuffled(sets_.fitted, random_);
        const std::size_t most = std::size_t(options_.raysPerUpdate);
        pieces_ = directional() ? piecesByView(pixels_, order_, most) : piecesOf(0, order_.size(), most);
        if (directional()) pieces_ = shuffled(std::move(pieces_), random_);
        if (pieces_.empty()) pieces_.push_back({0, 0});
    }

    bool directional() const { return !level_.slopes.empty(); }

    /// The volume as a pixel's view sees it.
    const CompositeVoxel* shownTo(std::uint32_t pixel) {
        if (!directional()) return level_.voxels.data();
        from_ = viewPoint(pixels_.place(pixel).photograph->camera, level_.grid);
        showVoxels(level_, from_, shown_);
        return shown_.data();
    }

    void update(int number, double done, const Piece& piece) {
        const std::size_t count = piece.count;
        batch_.set(pixels_, order_.data() + piece.first, count, level_, options_.samplesPerSlice);
        const CompositeVoxel* voxels = count > 0 ? shownTo(order_[piece.first]) : level_.voxels.data();
        const Backdrops backdrops{float(options_.backdrop), float(options_.backdropSpread)};
        compositeGradient(
            level_.layout, voxels, batch_.rays,
            [&](std::size_t at, std::size_t some, const RayColor* colors, RayColor* derivatives) {
                for (std::size_t i = 0; i < some; ++i)
                    batch_.errors[at + i] = pixelLoss(batch_.targets[at + i], colors[i], backdrops, derivatives[i]);
            },
            tape_, level_.gradient.data());
        if (directional()) chainColors(from_, shown_, level_);
        result_.samples += double(tape_.samples);
        error_ += batch_.error();
        seen_ += double(count);
        if (number % kSmoothEvery == 0) smooth(double(count) / double(kept_));
        step(number, done);
        ++result_.updates;
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
        if (directional())
            smoothSlopes({weight * float(options_.smoothSlopes), weight * float(options_.pullSlopes)}, level_);
    }

    void step(int number, double done) {
        AdamStep step;
        const double rate = std::pow(options_.lastRate, done);
        step.extinctionRate = float(options_.extinctionRate * rate);
        step.colorRate = float(options_.colorRate * rate);
        step.correction1 = 1 / (1 - std::pow(step.decay1, float(number + 1)));
        step.correction2 = 1 / (1 - std::pow(step.decay2, float(number + 1)));
        if (directional()) {
            AdamStep slopes = step;
            slopes.colorRate = float(options_.slopeRate * rate);
            stepSlopes(slopes, level_);
        }
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
        std::vector<std::uint32_t> pixels = sets_.leftOut;
        const std::size_t all = pixels.size();
        double squares = 0;
        for (const Piece& piece : directional() ? piecesByView(pixels_, pixels, all) : piecesOf(0, all, all)) {
            batch_.set(pixels_, pixels.data() + piece.first, piece.count, level_, options_.samplesPerSlice);
            std::vector<RayColor> colors(piece.count);
            composite(level_.layout, shownTo(pixels[piece.first]), batch_.rays.data(), piece.count, colors.data());
            for (std::size_t i = 0; i < colors.size(); ++i) {
                RayColor unused;
                batch_.errors[i] = pixelLoss(batch_.targets[i], colors[i], {}, unused);
            }
            squares += batch_.error();
        }
        return rms(squares, double(all));
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

    PhotoLevel& level_;
    const PhotoPixels& pixels_;
    const PhotoFitOptions& options_;
    const Timer& timer_;
    PhotoReconstruction& result_;
    PixelSets sets_;
    std::vector<std::uint32_t> order_;  ///< of the fitted pixels in this pass
    std::vector<Piece> pieces_;         ///< of them
    std::mt19937 random_;
    ViewPoint from_;
    std::vector<CompositeVoxel> shown_;  ///< to the rays from there, where colours depend on the direction
    std::size_t kept_;
    PhotoBatch batch_;
    CompositeTape tape_;
    double error_ = 0, seen_ = 0;  ///< since the last point of the history
};

/// @param colors of the level's voxels
void addGrids(const PhotoLevel& level, const std::vector<CompositeVoxel>& colors, PhotoReconstruction& result) {
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
            const CompositeVoxel& voxel = colors[n];
            const openvdb::Coord place(at.x, at.y, at.z);
            if (level.isSolid(n)) toDensity.setValue(place, float(voxel.extinction / level.grid.spacing));
            toColor.setValue(place, openvdb::Vec3s(voxel.red, voxel.green, voxel.blue));
        }
    result.opacity = opacityGrid(*result.density);
    result.color = extendedColor(*color, *result.density);
}

/// The coefficients of colours that depend on the direction.
void addDirectional(const PhotoLevel& level, PhotoReconstruction& result) {
    const auto gridOf = [&](const char* name, const auto& colorAt) {
        const auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
        grid->setTransform(level.grid.transform());
        auto to = grid->getAccessor();
        for (auto voxel = result.density->cbeginValueOn(); voxel; ++voxel) {
            const openvdb::Coord at = voxel.getCoord();
            to.setValue(at, openvdb::Vec3s(colorAt(level.layout.voxel(Index3(at.x(), at.y(), at.z())))));
        }
        const auto extended = extendedColor(*grid, *result.density);
        extended->setName(name);
        return extended;
    };
    result.directional.constant = gridOf("Cd_0", [&](std::size_t i) { return &level.voxels[i].red; });
    const char* const names[] = {"Cd_x", "Cd_y", "Cd_z"};
    openvdb::Vec3SGrid::Ptr* const grids[] = {&result.directional.x, &result.directional.y, &result.directional.z};
    for (int axis = 0; axis < 3; ++axis)
        *grids[axis] = gridOf(names[axis], [&](std::size_t i) { return level.slopes[i].of[axis]; });
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
    requireField(sh == 0 || sh == 1, "sh", sh, "0 or 1");
    requireField(slopeRate > 0 && std::isfinite(slopeRate), "slopeRate", slopeRate, "above 0");
    requireField(smoothSlopes >= 0 && std::isfinite(smoothSlopes), "smoothSlopes", smoothSlopes,
                 "0 or more, and finite");
    requireField(pullSlopes >= 0 && std::isfinite(pullSlopes), "pullSlopes", pullSlopes, "0 or more, and finite");
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
    const std::vector<Photograph> pictures = reducedTo(photographs, options.pictureSize);
    const PhotoPixels pixels(pictures);
    const Box3 box = options.box ? *options.box : boundsOf(pictures);
    const double all = options.coarsePasses * (options.levels - 1) + options.passes;
    double done = 0;
    const float hull = float(options.hullThreshold);
    PhotoLevel level, coarser;
    for (int n = 0; n < options.levels; ++n) {
        const int finest = options.levels - 1;
        const ReconstructionGrid grid = photoGrid(box, std::max(8, options.resolution >> (finest - n)));
        level.gradient = std::vector<CompositeVoxel>();
        level.moments = std::vector<AdamMoments>();
        level.slopeGradient = std::vector<ColorSlopes>();
        level.slopeMoments = std::vector<SlopeMoments>();
        coarser = std::move(level);
        level = n == 0 ? firstLevel(pictures, grid, hull, finest, options.sh > 0)
                       : finerLevel(coarser, pictures, grid, hull, float(options.prune));
        const double before = result.history.empty() ? 0 : result.history.back().leftOut;
        const double passes = n == finest ? options.passes : options.coarsePasses;
        if (!LevelFit(level, pixels, options, timer, result).run(passes, progress, done / all, (done + passes) / all)) {
            result.termination = PhotoTermination::interrupted;
            break;
        }
        done += passes;
        if (n > 0 && result.history.back().leftOut > kWorse * before) {
            level = std::move(coarser);
            result.termination = PhotoTermination::overfitted;
            break;
        }
    }
    result.keptVoxels = level.layout.keptVoxels();
    result.resolution = level.grid.resolution();
    addGrids(level, level.slopes.empty() ? level.voxels : meanColors(pictures, level), result);
    if (!level.slopes.empty()) addDirectional(level, result);
    if (reference && !result.history.empty() && shiftTo(*reference->density, level.grid))
        PhotoReference(*reference, level.grid, level.layout)
            .compare([&](std::size_t i) { return matterOf(level.voxels[i]); }, result.history.back());
    result.timings.total = timer.seconds();
    result.timings.prepared = result.timings.total - result.timings.updates;
    return result;
}

}  // namespace raysweep
