// One update (eq. 2 of sart.h): forward projection (setView, projectView), residual, backprojection, updateVoxels; a
// pass goes over all views.
#include "raysweep/reconstruct/sart.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/projector/backproject.h"
#include "raysweep/projector/footprint.h"
#include "raysweep/reconstruct/grid_lattice.h"
#include "raysweep/reconstruct/sart_record.h"
#include "raysweep/reconstruct/support.h"
#include "raysweep/reconstruct/total_variation.h"
#include "raysweep/reconstruct/voxel_update.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>

namespace raysweep {
namespace {

/// Rays that meet less of the volume than this part of a voxel have no say: their mean would be noise.
constexpr float kLeastLength = 1e-3f;

/// Sums over rays.
struct ResidualSums {
    double residual = 0, measured = 0;  ///< of squares
    double count = 0;                   ///< of rays that were used
    ResidualSums& operator+=(const ResidualSums& other) {
        residual += other.residual;
        measured += other.measured;
        count += other.count;
        return *this;
    }
};

/// A bound that the volume keeps. @param difference of what was measured and what the volume gives, p - A x
bool isKept(RayBound bound, float difference) {
    return (bound == RayBound::atLeast && difference <= 0) || (bound == RayBound::atMost && difference >= 0);
}

/// Turns A x and A 1 of a view into each ray's residual over its length, (p - A x) / A 1, and a weight of 1; both are 0
/// for rays that are not used: not measured, outside the volume, or of a bound that is kept.
ResidualSums residual(ViewRays& rays, const Projections& projections, int number, float leastLength) {
    const JosephView& view = rays.view;
    const float* measured = projections.view(number);
    const std::size_t first = std::size_t(number) * projections.pixelsPerView();
    return orderedSum<ResidualSums>(
        std::size_t(view.width),
        [&](std::size_t u) {
            ResidualSums sum;
            float *values = rays.values.column(int(u)), *weights = rays.weights.column(int(u));
            for (int v = 0; v < view.height; ++v) {
                const std::size_t pixel = view.pixel(int(u), v);
                const float p = measured[pixel];
                const float difference = p - values[v];
                const bool used = weights[v] > leastLength && !std::isnan(p);
                if (used && !isKept(projections.boundOf(first + pixel), difference)) {
                    sum += {double(difference) * difference, double(p) * p, 1};
                    values[v] = difference / weights[v];
                    weights[v] = 1;
                } else {
                    values[v] = weights[v] = 0;
                }
            }
            return sum;
        },
        16);
}

void requireNoInfinity(const Projections& projections) {
    const ValuesFound infinite = findValues(projections, [](float value) { return std::isinf(value); });
    if (infinite.count > 0)
        throw InvalidArgument(placeOf(projections, infinite.first) +
                              " is infinite; make it NaN if it was not measured");
}

/// The voxels that are kept, all 0.
ColumnVolume emptyVolume(const Projections& projections, const ProjectionGeometry& geometry,
                         const ColumnLattice& lattice, const SartOptions& options) {
    if (options.support == Support::none) return ColumnVolume(lattice);
    const float threshold = float(options.supportThreshold) * usualLargest(projections);
    return ColumnVolume(lattice, visualHull(projections, geometry, lattice, threshold));
}

/// The voxels that are kept, as a grid in which they are 1.
openvdb::FloatGrid::Ptr supportOf(const ColumnVolume& volume, const openvdb::math::Transform& transform) {
    const ColumnLattice& lattice = volume.lattice();
    const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(transform.copy());
    for (std::size_t t = 0; t < volume.blockCount(); ++t) {
        const ColumnRange range = volume.ranges()[t];
        if (range.length() == 0) continue;
        const int x = volume.firstX(t), y = volume.firstY(t);
        const Index3& dims = lattice.dims;
        grid->tree().denseFill(
            {lattice.gridIndex(x, y, range.low),
             lattice.gridIndex(std::min(x + kBlockEdge, dims.x) - 1, std::min(y + kBlockEdge, dims.y) - 1,
                               std::min(range.high, dims.z) - 1)},
            1.0f);
    }
    return grid;
}

/// What is known before the first update. @param begun `volume` is not 0
SartRecord recordStart(const ReconstructionGrid& grid, const SartOptions& options, const ColumnVolume& volume,
                       bool begun) {
    SartRecord record;
    record.grid = grid;
    record.options = options;
    record.options.record = nullptr;
    if (begun) record.initial = gridOf(volume, *grid.transform(), 0);
    if (options.support == Support::automatic) record.support = supportOf(volume, *grid.transform());
    return record;
}

/// What progress says of it.
std::string howItGoes(const std::vector<SartPoint>& history) {
    if (history.empty()) return "";
    std::ostringstream text;
    text << std::setprecision(3) << ": ";
    if (std::isnan(history.back().residual))
        text << "nothing measured";
    else
        text << "residual " << history.back().residual;
    if (!std::isnan(history.back().rms)) text << ", RMS " << history.back().rms;
    return text.str();
}

/// How often total variation is lowered after a pass.
constexpr int kVariationSteps = 10;

/// What is to be matched, and how.
struct Problem {
    const Projections& projections;
    const ProjectionGeometry& geometry;
    const SartOptions& options;
};

/// The iteration on one volume, and its record.
class Solver {
  public:
    /// @param reference may be null
    Solver(const Problem& problem, ColumnVolume& volume, const ColumnVolume* reference, SartResult& result)
        : projections_(problem.projections),
          geometry_(problem.geometry),
          options_(problem.options),
          volume_(volume),
          reference_(reference),
          result_(result) {
        const Matrix3& m = volume.lattice().worldFromVoxel;
        leastLength_ = kLeastLength * float(std::cbrt(std::abs(m.determinant())));
        if (options_.totalVariation > 0) before_.emplace(volume.lattice(), volume.ranges());
    }

    /// All passes, unless something ends them before.
    void run(const ProgressCallback& progress) {
        for (int pass = 0; pass < options_.iterations && running(); ++pass) {
            if (before_) before_->copyFrom(volume_);
            updateByAllViews(pass, progress);
            if (!running()) return;
            if (before_)
                lowerTotalVariation(volume_, *before_,
                                    {options_.totalVariation * changeLength(volume_, *before_), kVariationSteps,
                                     float(options_.lower), float(options_.upper)});
            if (options_.historyEvery == 0) addPoint();
        }
    }

  private:
    bool running() const { return result_.termination == SartTermination::iterations; }

    void updateByAllViews(int pass, const ProgressCallback& progress) {
        const std::vector<int> order = viewOrder(geometry_, options_.order, options_.seed, pass);
        const int views = int(order.size());
        const int together = options_.viewsPerUpdate == 0 ? views : std::min(options_.viewsPerUpdate, views);
        const double relaxation = options_.relaxation / (1 + options_.relaxationDecay * pass);
        for (int first = 0; first < views && running(); first += together) {
            if (!report(progress, "reconstructing" + howItGoes(result_.history),
                        (pass + double(first) / views) / options_.iterations)) {
                result_.termination = SartTermination::interrupted;
                return;
            }
            const Timer timer;
            const auto from = order.begin() + first;
            const std::vector<int> subset(from, from + std::min(together, views - first));
            const ResidualSums sums = update(subset, relaxation);
            result_.seconds += timer.seconds();
            sums_ += sums;
            if (pass == 0) result_.raysUsed += std::size_t(sums.count);
            ++result_.updates;
            if (options_.record) options_.record->updates.push_back({subset, relaxation});
            if (options_.historyEvery > 0 && result_.updates % options_.historyEvery == 0) addPoint();
        }
    }

    /// Eq. 2 for the rays of `views`.
    ResidualSums update(const std::vector<int>& views, double relaxation) {
        rays_.resize(views.size());  // a pass's last subset may be smaller
        ResidualSums sums;
        for (std::size_t n = 0; n < views.size(); ++n) {
            setView(rays_[n], geometry_, views[n], volume_.lattice());
            projectView(volume_, rays_[n]);
            sums += residual(rays_[n], projections_, views[n], leastLength_);
            prepareBackprojection(rays_[n], volume_.lattice().dims.z);
        }
        const VoxelUpdate update{float(relaxation), float(options_.lower), float(options_.upper)};
        parallelFor(volume_.blockCount(), [&](std::size_t block) {
            const std::size_t count = volume_.voxelsOf(block);
            if (count == 0) return;
            thread_local std::vector<float> room;
            room.resize(2 * count);
            backprojectBlock(volume_, block, rays_, room.data(), room.data() + count);
            updateVoxels(volume_.block(block), room.data(), room.data() + count, count, update);
        });
        return sums;
    }

    /// To the history; may end the iteration, but not where nothing was measured: no residual is no small one.
    void addPoint() {
        const double residual = sums_.measured > 0 ? std::sqrt(sums_.residual / sums_.measured) : std::nan("");
        const double rms = reference_ ? rmsDifference(volume_, *reference_) : std::nan("");
        result_.history.push_back({result_.updates, residual, rms});
        sums_ = ResidualSums();
        if (residual < options_.stopResidual) result_.termination = SartTermination::residual;
    }

    const Projections& projections_;
    const ProjectionGeometry& geometry_;
    const SartOptions& options_;
    ColumnVolume& volume_;
    const ColumnVolume* reference_;
    SartResult& result_;
    float leastLength_;
    std::optional<ColumnVolume> before_;  ///< the volume as the pass began, for total variation
    std::vector<ViewRays> rays_;
    ResidualSums sums_;  ///< since the last point of the history
};

}  // namespace

void SartOptions::validate() const {
    requireField(iterations > 0, "iterations", iterations, "at least 1");
    requireField(viewsPerUpdate >= 0, "viewsPerUpdate", viewsPerUpdate, "at least 0");
    requireField(relaxation > 0 && relaxation < 2, "relaxation", relaxation, "between 0 and 2");
    requireField(relaxationDecay >= 0 && std::isfinite(relaxationDecay), "relaxationDecay", relaxationDecay,
                 "0 or more, and finite");
    requireField(lower <= upper, "lower", lower, "at most `upper`");
    requireField(!(lower > 0) && !(upper < 0), "bounds around", 0, "such that voxels can be 0");
    requireField(totalVariation >= 0 && totalVariation < 1, "totalVariation", totalVariation, "in [0,1)");
    requireField(stopResidual >= 0, "stopResidual", stopResidual, "0 or more");
    requireField(supportThreshold >= 0 && supportThreshold < 1, "supportThreshold", supportThreshold, "in [0,1)");
    requireField(historyEvery >= 0, "historyEvery", historyEvery, "at least 0");
    requireField(tolerance >= 0 && std::isfinite(tolerance), "tolerance", tolerance, "0 or more, and finite");
}

SartResult sart(const Projections& projections, const ProjectionGeometry& geometry, const ReconstructionGrid& grid,
                const SartOptions& options, const SartVolumes& volumes, const ProgressCallback& progress) {
    options.validate();
    geometry.validate();
    grid.validate();
    requireMatching(geometry, projections);
    requireNoInfinity(projections);

    SartResult result;
    const ColumnLattice lattice = latticeOf(grid, geometry);
    requireSeen(geometry, lattice);
    ColumnVolume volume = emptyVolume(projections, geometry, lattice, options);
    result.keptVoxels = volume.storedVoxels();
    if (volumes.initial) {
        fillColumns(volume, *volumes.initial, requireShift(*volumes.initial, grid, "initial"));
        volume.clampAll(float(options.lower), float(options.upper));
    }
    std::optional<ColumnVolume> reference;
    if (volumes.reference) {
        reference.emplace(lattice);
        fillColumns(*reference, *volumes.reference, requireShift(*volumes.reference, grid, "reference"));
    }
    if (options.record) *options.record = recordStart(grid, options, volume, volumes.initial != nullptr);
    Solver({projections, geometry, options}, volume, reference ? &*reference : nullptr, result).run(progress);
    result.volume = gridOf(volume, *grid.transform(), float(options.tolerance));
    if (options.record) options.record->density = gridOf(volume, *grid.transform(), 0);
    return result;
}

}  // namespace raysweep
