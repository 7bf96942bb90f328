// One update: the rays of a picture (setRays), what they see now and what their samples are to change by
// (compositeSpread with one of the rules), and then brick by brick the change and how it looks in the next view's
// light.
#include "raysweep/reconstruct/photo_sart.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/core/shuffle.h"
#include "raysweep/reconstruct/photo_grids.h"
#include "raysweep/reconstruct/photo_hull.h"
#include "raysweep/reconstruct/photo_reference.h"
#include "raysweep/reconstruct/photo_room.h"
#include "raysweep/reconstruct/photo_rules.h"
#include "raysweep/reconstruct/photo_step.h"
#include "raysweep/reconstruct/photo_views.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <optional>
#include <random>
#include <sstream>
#include <string>

namespace raysweep {
namespace {

/// Voxels more opaque than this cannot be told from each other.
constexpr float kMostExtinction = 10;
/// Updates for which normals are kept: they change more slowly than what they belong to.
constexpr int kNormalsEvery = 8;

/// All voxels of a grid.
std::vector<MaskedBrick> allBricks(const ReconstructionGrid& grid) {
    std::vector<MaskedBrick> bricks;
    Index3 at;
    for (at.x = 0; at.x < grid.dims.x; at.x += 8)
        for (at.y = 0; at.y < grid.dims.y; at.y += 8)
            for (at.z = 0; at.z < grid.dims.z; at.z += 8) {
                MaskedBrick brick{at, {}};
                for (int i = 0; i < 512; ++i) {
                    const Index3 voxel = at + Index3(i >> 6, i >> 3 & 7, i & 7);
                    if (voxel.x < grid.dims.x && voxel.y < grid.dims.y && voxel.z < grid.dims.z)
                        brick.mask[std::size_t(i >> 6)] |= std::uint64_t(1) << (i & 63);
                }
                bricks.push_back(brick);
            }
    return bricks;
}

std::string howItGoes(const std::vector<PhotoPoint>& history) {
    if (history.empty()) return "correcting";
    const PhotoPoint& point = history.back();
    std::ostringstream text;
    text << std::setprecision(3) << "correcting: image error " << point.imageError;
    if (!std::isnan(point.opacity)) text << ", RMS " << point.opacity << " of opacity, " << point.color << " of colour";
    return text.str();
}

/// What is to be met, and how.
struct Problem {
    const std::vector<Photograph>& pictures;
    const ReconstructionGrid& grid;
    const PhotoSartOptions& options;
};

/// The volume and its corrections.
class PhotoSolver {
  public:
    PhotoSolver(const Problem& problem, const CompositeLayout& layout, PhotoReconstruction& result)
        : pictures_(problem.pictures),
          grid_(problem.grid),
          options_(problem.options),
          layout_(layout),
          result_(result),
          additive_(options_.form == PhotoForm::paper),
          lit_(options_.light.shading.diffuse > 0 || options_.light.shading.ambient != 1),
          volume_(layout.voxelCount()),
          sums_(layout.voxelCount()),
          shown_(additive_ || lit_ ? layout.voxelCount() : 0),
          normals_(options_.light.shading.diffuse > 0 ? layout.voxelCount() : 0) {
        step_ = {float(options_.relaxation), kLeastOpacity, kMostExtinction};
    }

    /// Memory, by the longest of the vectors below.
    static std::size_t bytesPerVoxel(const PhotoSartOptions& options) {
        const Shading& shading = options.light.shading;
        const bool shows = options.form == PhotoForm::paper || shading.diffuse > 0 || shading.ambient != 1;
        return (shows ? 4 : 3) * sizeof(CompositeVoxel) + (shading.diffuse > 0 ? sizeof(PackedNormal) : 0);
    }

    /// Those voxels that are kept.
    void startFrom(const ColorVolume& initial) {
        forVoxelsIn(grid_, initial, "initial", [&](const Index3& at, const CompositeVoxel& voxel) {
            const std::size_t i = layout_.voxel(at);
            if (!layout_.keeps(i)) return;
            volume_[i] = additive_ ? matterOf(voxel) : voxel;
        });
    }

    void run(const PhotoReference* reference, const ProgressCallback& progress) {
        const std::size_t views = pictures_.size();
        std::vector<std::size_t> order(views);
        for (std::size_t i = 0; i < views; ++i) order[i] = i;
        std::mt19937 random(options_.seed);
        const int all = options_.iterations * int(views);
        const int updates = options_.updates > 0 ? std::min(options_.updates, all) : all;
        for (int n = 0; n < updates; ++n) {
            if (!report(progress, howItGoes(result_.history), double(n) / updates)) {
                result_.termination = PhotoTermination::interrupted;
                break;
            }
            const std::size_t place = std::size_t(n) % views;
            if (place == 0) shuffle(order, random);
            update(pictures_[order[place]], n / int(views));
            if (place == views - 1) endPass();
            const int every = options_.historyEvery > 0 ? options_.historyEvery : int(views);
            if (result_.updates % every == 0 || n == updates - 1) addPoint(reference);
        }
        if (strayed()) volume_.swap(best_);
    }

    /// Extinction, 1 / edge of a voxel, and colour.
    CompositeVoxel voxel(std::size_t i) const {
        const CompositeVoxel& v = volume_[i];
        if (!additive_) return v;
        const float part = v.extinction > 0 ? 1 / v.extinction : 0;
        return {-std::log(std::max(1 - v.extinction, std::exp(-kMostExtinction))), std::min(1.0f, v.red * part),
                std::min(1.0f, v.green * part), std::min(1.0f, v.blue * part)};
    }

  private:
    /// Differences to pictures, and of how many values.
    struct ImageSum {
        double squares = 0, rays = 0;
        double rms() const { return std::sqrt(squares / std::max(4 * rays, 1.0)); }
    };

    void update(const Photograph& picture, int time) {
        const Timer timer;
        const ViewLight light = lightFor(picture.camera);
        setRays(rays_, picture, grid_, layout_, options_.samplesPerSlice, time);
        prepare(light);
        const float mostDepth = float(-std::log1p(-options_.saturation));
        compositeSpread(
            layout_, shown_.empty() ? volume_.data() : shown_.data(), rays_.rays,
            [&](std::size_t r, const RaySamples& samples, SampleShare* shares) {
                return additive_ ? paperRule(rays_, r, samples, shares)
                                 : consistentRule(rays_, r, mostDepth, samples, shares);
            },
            tape_, sums_.data());
        forBricks([&](std::size_t b) {
            CompositeVoxel *volume = volume_.data() + b * 512, *sums = sums_.data() + b * 512;
            if (additive_)
                addToBrick(volume, sums, layout_.masks[b], step_);
            else
                multiplyBrick(volume, sums, layout_.masks[b], normalsOf(b), light, step_);
        });
        sumErrors();
        ++result_.updates;
        result_.samples += double(tape_.samples);
        result_.timings.updates += timer.seconds();
    }

    ViewLight lightFor(const PhotoCamera& camera) const {
        const Shading& shading = options_.light.shading;
        Vec3 light = shading.light;
        if (options_.light.turns) light = carriedAlong(light, pictures_.front().camera, camera);
        light.normalize();
        return {float(shading.ambient), float(shading.diffuse), {float(-light.x), float(-light.y), float(-light.z)}};
    }

    /// What is to be looked at.
    void prepare(const ViewLight& light) {
        if (shown_.empty()) return;
        const CompositeVoxel* straight = additive_ ? shown_.data() : volume_.data();
        const bool turnNormals = !normals_.empty() && result_.updates % kNormalsEvery == 0;
        if (additive_) forBricks([&](std::size_t b) { straightenBrick(&volume_[b * 512], &shown_[b * 512], step_); });
        if (turnNormals) forBricks([&](std::size_t b) { brickNormals(layout_, straight, b, &normals_[b * 512]); });
        if (lit_)
            forBricks([&](std::size_t b) { lightBrick(straight + b * 512, normalsOf(b), light, &shown_[b * 512]); });
    }

    const PackedNormal* normalsOf(std::size_t b) const { return normals_.empty() ? nullptr : &normals_[b * 512]; }

    template <class Body>
    void forBricks(const Body& body) {
        parallelFor(
            layout_.brickCount() - 1, [&](std::size_t n) { body(n + 1); }, 16);
    }

    void sumErrors() {
        const double squares = rays_.missed + orderedSum(
                                                  rays_.rays.size(),
                                                  [&](std::size_t r) {
                                                      const RayColor& seen = tape_.colors[r];
                                                      const auto colors = missing(rays_.pixels[r], seen);
                                                      const float a = rays_.pixels[r][3] - (1 - seen.transmittance);
                                                      return double(a) * a + double(colors[0]) * colors[0] +
                                                             double(colors[1]) * colors[1] +
                                                             double(colors[2]) * colors[2];
                                                  },
                                                  1024);
        for (ImageSum* sum : {&inPass_, &sincePoint_}) {
            sum->squares += squares;
            sum->rays += rays_.pictureRays;
        }
    }

    /// Whether the pass is worse than the best one, by more than passes differ that go nowhere.
    bool strayed() const {
        constexpr double kNoise = 1.05;
        return !best_.empty() && (inPass_.rays > 0 ? inPass_.rms() : lastError_) > kNoise * leastError_;
    }

    void endPass() {
        if (best_.empty() || inPass_.rms() < leastError_) {
            best_ = volume_;
            leastError_ = inPass_.rms();
        }
        lastError_ = inPass_.rms();
        inPass_ = {};
    }

    void addPoint(const PhotoReference* reference) {
        PhotoPoint point;
        point.updates = result_.updates;
        point.seconds = result_.timings.updates;
        point.resolution = grid_.resolution();
        point.imageError = sincePoint_.rms();
        if (reference)
            reference->compare([&](std::size_t i) { return additive_ ? volume_[i] : matterOf(volume_[i]); }, point);
        result_.history.push_back(point);
        sincePoint_ = {};
    }

    const std::vector<Photograph>& pictures_;
    const ReconstructionGrid& grid_;
    const PhotoSartOptions& options_;
    const CompositeLayout& layout_;
    PhotoReconstruction& result_;
    const bool additive_, lit_;
    PhotoStep step_;
    std::vector<CompositeVoxel> volume_;  ///< extinction and colour; additive: opacity, and colour times it
    std::vector<CompositeVoxel> sums_;
    std::vector<CompositeVoxel> shown_;  ///< what rays see, unless that is `volume_`
    std::vector<PackedNormal> normals_;
    std::vector<CompositeVoxel> best_;  ///< as the best pass left it
    double leastError_ = 0;             ///< in that pass
    double lastError_ = 0;              ///< in the last whole pass
    PhotoRays rays_;
    CompositeTape tape_;
    ImageSum inPass_, sincePoint_;
};

}  // namespace

void PhotoSartOptions::validate() const {
    requireField(iterations > 0, "iterations", iterations, "at least 1");
    requireField(updates >= 0, "updates", updates, "at least 0");
    requireField(relaxation > 0 && relaxation <= 2, "relaxation", relaxation, "in (0,2]");
    requireField(samplesPerSlice >= 1 && samplesPerSlice <= 16, "samplesPerSlice", samplesPerSlice, "from 1 to 16");
    requireField(saturation > 0 && saturation < 1, "saturation", saturation, "in (0,1)");
    requireField(hullThreshold >= 0 && hullThreshold < 1, "hullThreshold", hullThreshold, "in [0,1)");
    requireField(historyEvery >= 0, "historyEvery", historyEvery, "at least 0");
    light.shading.validate();
}

PhotoReconstruction photoSart(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                              const PhotoSartOptions& options, const PhotoVolumes& volumes,
                              const ProgressCallback& progress) {
    options.validate();
    grid.validate();
    grid.requireCubes();
    const Timer timer;
    PhotoReconstruction result;
    const std::vector<Photograph> pictures = picturesFor(photographs, grid);
    const CompositeLayout layout = compositeLayout(
        grid.dims,
        options.form == PhotoForm::paper ? allBricks(grid) : photoHull(pictures, grid, float(options.hullThreshold)));
    if (layout.brickCount() == 1)
        throw InvalidArgument("the photographs show nothing of the grid; check its place, mattes and poses");
    result.keptVoxels = layout.keptVoxels();
    requireRoom(double(layout.voxelCount()), PhotoSolver::bytesPerVoxel(options));
    std::optional<PhotoReference> known;
    if (volumes.reference) known.emplace(*volumes.reference, grid, layout);
    PhotoSolver solver({pictures, grid, options}, layout, result);
    if (volumes.initial) solver.startFrom(*volumes.initial);
    solver.run(known ? &*known : nullptr, progress);
    const VoxelAt matter = [&](std::size_t i) {
        const CompositeVoxel voxel = solver.voxel(i);
        return voxel.extinction > 0 ? std::optional(voxel) : std::nullopt;
    };
    addGrids(layout, grid, matter, result);
    result.timings.total = timer.seconds();
    result.timings.prepared = result.timings.total - result.timings.updates;
    return result;
}

}  // namespace raysweep
