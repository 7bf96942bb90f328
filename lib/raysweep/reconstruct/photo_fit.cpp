// Grid after grid (PhotoLevel), each from the one before; what is done in one is in photo_level_fit.cpp.
#include "raysweep/reconstruct/photo_fit.h"

#include "raysweep/camera/object_bounds.h"
#include "raysweep/camera/pose_motion.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/grid_lattice.h"
#include "raysweep/reconstruct/photo_directional.h"
#include "raysweep/reconstruct/photo_grids.h"
#include "raysweep/reconstruct/photo_level.h"
#include "raysweep/reconstruct/photo_level_fit.h"
#include "raysweep/reconstruct/photo_pixels.h"
#include "raysweep/reconstruct/photo_reference.h"
#include "raysweep/reconstruct/photo_views.h"
#include "raysweep/reconstruct/pose_refine.h"
#include "raysweep/reconstruct/reconstruction_grid.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

std::vector<Photograph> reducedTo(const std::vector<Photograph>& photographs, int size) {
    std::vector<Photograph> all(photographs.size());
    parallelFor(all.size(), [&](std::size_t n) {
        const int factor = std::max(photographs[n].matte.width, photographs[n].matte.height) / size;
        all[n] = factor > 1 ? reduced(photographs[n], factor) : photographs[n];
    });
    return all;
}

/// A finer grid is not kept if left-out pixels are met worse by this factor, 1 dB. They lie among pixels that are
/// fitted, so their word on views from elsewhere is weak: of the Middlebury temple they gain nothing from 64 to 128
/// voxels, and by COLMAP's poses lose .6 dB, while views that were held out gain 1.5 and .4.
constexpr double kWorse = 1.122;

/// How often the first grid is made, with the poses that it has refined: a wrong pose takes from the hull what the
/// object needs.
constexpr int kMostRounds = 3;

/// Weight of total variation in the grids that poses are refined by: with less, a volume takes up what wrong poses
/// show.
constexpr double kSmoothnessForPoses = 0.03;

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
    requireField(smoothness > 0 || !adaptSmoothness, "smoothness", smoothness, "above 0 where it is to adapt");
    requireField(sh == 0 || sh == 1, "sh", sh, "0 or 1");
    if (refinePoses && sh > 0)
        throw InvalidArgument("poses are refined by colours that are alike from all sides: `sh` 0");
    requireField(levels > 1 || !refinePoses, "levels", levels,
                 "at least 2 where poses are to be refined, by the coarse ones");
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
    std::vector<Photograph> pictures = reducedTo(photographs, options.pictureSize);
    const std::vector<PhotoCamera> given = camerasOf(pictures);
    const PhotoPixels pixels(pictures);
    const Box3 box = options.box ? *options.box : boundsOf(pictures);
    const double all = options.coarsePasses * (options.levels - 1) + options.passes;
    double done = 0;
    const float hull = float(options.hullThreshold);
    PhotoLevel level, coarser;
    Smoothness smoothness(options.smoothness), blurred(kSmoothnessForPoses);
    PhotoFitOptions steady = options;
    steady.adaptSmoothness = false;
    const int finest = options.levels - 1;
    bool again = false;
    for (int n = 0, rounds = 0; n < options.levels; n += !again) {
        const ReconstructionGrid grid = photoGrid(box, std::max(8, options.resolution >> (finest - n)));
        forgetSteps(level);
        coarser = std::move(level);
        std::optional<PhotoLevel> next = n == 0 ? firstLevel(pictures, grid, hull, finest, options.sh > 0)
                                                : finerLevel(coarser, pictures, grid, hull, float(options.prune));
        if (!next) {
            level = std::move(coarser);
            result.termination = PhotoTermination::noRoom;
            break;
        }
        level = std::move(*next);
        const double before = result.history.empty() ? 0 : result.history.back().leftOut;
        const double passes = n == finest ? options.passes : options.coarsePasses;
        const bool forPoses = options.refinePoses && n < finest;
        if (!LevelFit(level, pixels, forPoses ? steady : options, timer, result)
                 .run(passes, forPoses ? blurred : smoothness, progress, done / all, (done + passes) / all)) {
            result.termination = PhotoTermination::interrupted;
            break;
        }
        const bool moved = forPoses && refinePoses(level, given, options, pictures);
        again = moved && n == 0 && ++rounds < kMostRounds;
        if (again) continue;
        done += passes;
        if (n > 0 && !result.history.empty() && result.history.back().leftOut > kWorse * before) {
            level = std::move(coarser);
            startSteps(level);
            const bool whole = LevelFit(level, pixels, options, timer, result)
                                   .run(options.passes, smoothness, progress, done / all, 1);
            result.termination = whole ? PhotoTermination::overfitted : PhotoTermination::interrupted;
            break;
        }
    }
    if (options.refinePoses) result.poses = refinedFrom(photographs, pictures, level.grid.box());
    result.keptVoxels = level.layout.keptVoxels();
    result.resolution = level.grid.resolution();
    result.smoothness = smoothness.weight();
    coarser = {};
    forgetSteps(level);
    std::vector<CompositeVoxel> constants;
    if (!level.slopes.empty()) {
        constants = level.voxels;
        level.voxels = meanColors(pictures, level);
    }
    const VoxelAt matter = [&](std::size_t i) {
        return level.isSolid(i) ? std::optional(level.voxels[i]) : std::nullopt;
    };
    addGrids(level.layout, level.grid, matter, result);
    if (!constants.empty()) addDirectional(level, constants, result);
    if (reference && !result.history.empty() && shiftTo(*reference->density, level.grid))
        PhotoReference(*reference, level.grid, level.layout)
            .compare([&](std::size_t i) { return matterOf(level.voxels[i]); }, result.history.back());
    result.timings.total = timer.seconds();
    result.timings.prepared = result.timings.total - result.timings.updates;
    return result;
}

}  // namespace raysweep
