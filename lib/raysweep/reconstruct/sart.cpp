#include "raysweep/reconstruct/sart.h"

#include "raysweep/core/parallel.h"
#include "raysweep/projector/backproject.h"
#include "raysweep/projector/shadow.h"
#include "raysweep/reconstruct/support.h"
#include "raysweep/reconstruct/total_variation.h"

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
struct RaySquares {
    double missed = 0, measured = 0, count = 0;
    RaySquares& operator+=(const RaySquares& other) {
        missed += other.missed;
        measured += other.measured;
        count += other.count;
        return *this;
    }
};

/// Turns A x and A 1 of a view into what each ray asks of its voxels, (p - A x) / A 1, and a weight of 1 or 0.
RaySquares ask(ViewRays& rays, const Projections& projections, int view, float leastLength) {
    const ViewFootprint& f = rays.footprint;
    const float* measured = projections.view(view);
    return orderedSum<RaySquares>(
        std::size_t(f.width),
        [&](std::size_t u) {
            RaySquares sum;
            float *values = rays.values.column(int(u)), *weights = rays.weights.column(int(u));
            for (int v = 0; v < f.height; ++v) {
                const int row = f.flipped ? f.height - 1 - v : v;
                const float p = measured[std::size_t(row) * f.width + u];
                float missing = p - values[v];
                // A saturated ray says "at least": content as soon as it is.
                const bool content = p >= projections.saturation && missing <= 0;
                const bool used = weights[v] > leastLength && !std::isnan(p);
                if (used && !content) {
                    sum += {double(missing) * missing, double(p) * p, 1};
                    values[v] = missing / weights[v];
                    weights[v] = 1;
                } else {
                    values[v] = weights[v] = 0;
                }
            }
            return sum;
        },
        16);
}

class Solver {
  public:
    Solver(const Projections& projections, const ProjectionGeometry& geometry, const SartOptions& options,
           ColumnVolume& volume)
        : projections_(projections), geometry_(geometry), options_(options), volume_(volume) {
        const Matrix3& m = volume.lattice().worldFromVoxel;
        leastLength_ = kLeastLength * float(std::cbrt(std::abs(m.determinant())));
    }

    /// One correction by `views`.
    RaySquares update(const std::vector<int>& views, double relaxation) {
        rays_.resize(views.size());  // a pass's last subset may be smaller
        RaySquares squares;
        for (std::size_t n = 0; n < views.size(); ++n) {
            aim(rays_[n], geometry_, views[n], volume_.lattice());
            projectView(volume_, rays_[n]);
            squares += ask(rays_[n], projections_, views[n], leastLength_);
            readyRays(rays_[n], volume_.lattice().dims.z);
        }
        const VoxelUpdate step{float(relaxation), float(options_.lower), float(options_.upper)};
        parallelFor(volume_.tileCount(), [&](std::size_t tile) {
            const std::size_t count = volume_.voxelsOf(tile);
            if (count == 0) return;
            thread_local std::vector<float> sums;
            sums.resize(2 * count);
            backprojectTile(volume_, tile, rays_, sums.data(), sums.data() + count);
            updateVoxels(volume_.tile(tile), sums.data(), sums.data() + count, count, step);
        });
        return squares;
    }

  private:
    const Projections& projections_;
    const ProjectionGeometry& geometry_;
    const SartOptions& options_;
    ColumnVolume& volume_;
    float leastLength_;
    std::vector<ViewRays> rays_;
};

void requireNoInfinity(const Projections& projections) {
    for (std::size_t n = 0; n < projections.values.size(); ++n)
        if (std::isinf(projections.values[n]))
            throw InvalidArgument("view " + std::to_string(n / projections.pixelsPerView()) + ", row " +
                                  std::to_string(n % projections.pixelsPerView() / std::size_t(projections.width)) +
                                  ", column " + std::to_string(n % std::size_t(projections.width)) +
                                  " is infinite; make it NaN if it was not measured");
}

float largest(const Projections& projections) {
    float most = 0;
    for (const float value : projections.values)
        if (value > most) most = value;  // NaN is not
    return most;
}

ColumnVolume emptyVolume(const Projections& projections, const ProjectionGeometry& geometry,
                         const ColumnLattice& lattice, const SartOptions& options) {
    if (options.support == Support::none) return ColumnVolume(lattice);
    const float threshold = float(options.supportThreshold) * largest(projections);
    return ColumnVolume(lattice, visualHull(projections, geometry, lattice, threshold));
}

/// Over all voxels of the lattice, kept or not.
double rmsDifference(const ColumnVolume& volume, const ColumnVolume& reference) {
    const Index3 dims = volume.lattice().dims;
    const double sum = orderedSum<double>(
        std::size_t(dims.x),
        [&](std::size_t x) {
            double squares = 0;
            for (int y = 0; y < dims.y; ++y)
                for (int z = 0; z < dims.z; ++z) {
                    const double difference = double(volume.value(int(x), y, z)) - reference.value(int(x), y, z);
                    squares += difference * difference;
                }
            return squares;
        },
        4);
    return std::sqrt(sum / (double(dims.x) * dims.y * dims.z));
}

/// The index of `grid`'s voxel that is where the reconstruction's voxel (0,0,0) is.
openvdb::Coord shiftTo(const openvdb::FloatGrid& grid, const ReconstructionGrid& wanted, const char* what) {
    const auto transform = wanted.transform();
    const auto place = [&](const openvdb::Coord& voxel) {
        return grid.transform().worldToIndex(transform->indexToWorld(voxel));
    };
    const openvdb::Coord shift = openvdb::Coord::round(place(openvdb::Coord(0, 0, 0)));
    const Index3& dims = wanted.dims;
    for (const openvdb::Coord& corner : {openvdb::Coord(0, 0, 0), openvdb::Coord(dims.x, 0, 0),
                                         openvdb::Coord(0, dims.y, 0), openvdb::Coord(0, 0, dims.z)})
        if (!((place(corner) - (corner + shift).asVec3d()).length() < 1e-3))
            throw InvalidArgument(std::string("the voxels of the ") + what +
                                  " volume are not where those of the reconstruction are: choose spacing and centre "
                                  "such that they are, or resample it");
    return shift;
}

/// What progress says of it.
std::string howItGoes(const std::vector<SartPoint>& history) {
    if (history.empty()) return "";
    std::ostringstream text;
    text << std::setprecision(3) << ": residual " << history.back().residual;
    if (!std::isnan(history.back().rms)) text << ", RMS " << history.back().rms;
    return text.str();
}

/// How often total variation is lowered after a pass.
constexpr int kVariationSteps = 10;

}  // namespace

void SartOptions::validate() const {
    const auto require = [](bool good, const char* field, double value, const char* bound) {
        if (good) return;
        std::ostringstream message;
        message << field << " " << value << ": must be " << bound;
        throw InvalidArgument(message.str());
    };
    require(iterations > 0, "iterations", iterations, "at least 1");
    require(viewsPerUpdate >= 0, "viewsPerUpdate", viewsPerUpdate, "at least 0");
    require(relaxation > 0 && relaxation < 2, "relaxation", relaxation, "between 0 and 2");
    require(relaxationDecay >= 0 && std::isfinite(relaxationDecay), "relaxationDecay", relaxationDecay,
            "0 or more, and finite");
    require(lower <= upper, "lower", lower, "at most upper");
    require(!(lower > 0) && !(upper < 0), "bounds around", 0, "such that voxels can be 0");
    require(totalVariation >= 0 && totalVariation < 1, "totalVariation", totalVariation, "in [0,1)");
    require(stopResidual >= 0, "stopResidual", stopResidual, "0 or more");
    require(supportThreshold >= 0 && supportThreshold < 1, "supportThreshold", supportThreshold, "in [0,1)");
    require(historyEvery >= 0, "historyEvery", historyEvery, "at least 0");
    require(tolerance >= 0 && std::isfinite(tolerance), "tolerance", tolerance, "0 or more, and finite");
}

SartResult sart(const Projections& projections, const ProjectionGeometry& geometry, const ReconstructionGrid& grid,
                const SartOptions& options, const SartVolumes& volumes, const ProgressCallback& progress) {
    options.validate();
    geometry.validate();
    grid.validate();
    requireMatching(geometry, projections);
    requireNoInfinity(projections);

    const auto transform = grid.transform();
    const openvdb::CoordBBox box(openvdb::Coord(0, 0, 0),
                                 openvdb::Coord(grid.dims.x - 1, grid.dims.y - 1, grid.dims.z - 1));
    const ColumnLattice lattice = columnLattice(box, *transform, columnAxisFor(geometry, *transform));
    SartResult result;
    result.viewsSeeing = requireSeen(geometry, lattice);
    ColumnVolume volume = emptyVolume(projections, geometry, lattice, options);
    if (volumes.initial) {
        fillColumns(volume, *volumes.initial, shiftTo(*volumes.initial, grid, "initial"));
        volume.clampAll(float(options.lower), float(options.upper));
    }
    std::optional<ColumnVolume> reference, before;
    if (volumes.reference) {
        reference.emplace(lattice);
        fillColumns(*reference, *volumes.reference, shiftTo(*volumes.reference, grid, "reference"));
    }
    if (options.totalVariation > 0) before.emplace(lattice, volume.ranges());

    result.keptVoxels = volume.storedVoxels();
    Solver solver(projections, geometry, options, volume);
    const int views = int(geometry.views.size());
    const int together = options.viewsPerUpdate == 0 ? views : std::min(options.viewsPerUpdate, views);
    RaySquares squares;  // since the last point of the history
    const auto addPoint = [&] {
        const double residual = squares.measured > 0 ? std::sqrt(squares.missed / squares.measured) : 0;
        const double rms = reference ? rmsDifference(volume, *reference) : std::nan("");
        result.history.push_back({result.updates, residual, rms});
        squares = RaySquares();
        if (residual < options.stopResidual) result.termination = SartTermination::residual;
    };
    for (int pass = 0; pass < options.iterations; ++pass) {
        const std::vector<int> order = viewOrder(geometry, options.order, options.seed, pass);
        const double relaxation = options.relaxation / (1 + options.relaxationDecay * pass);
        if (before) before->copyFrom(volume);
        for (int first = 0; first < views && result.termination == SartTermination::iterations; first += together) {
            if (!report(progress, "reconstructing" + howItGoes(result.history),
                        (pass + double(first) / views) / options.iterations)) {
                result.termination = SartTermination::interrupted;
                break;
            }
            const Timer timer;
            const auto from = order.begin() + first;
            const RaySquares update = solver.update({from, from + std::min(together, views - first)}, relaxation);
            result.seconds += timer.seconds();
            squares += update;
            if (pass == 0) result.raysUsed += std::size_t(update.count);
            ++result.updates;
            if (options.historyEvery > 0 && result.updates % options.historyEvery == 0) addPoint();
        }
        if (result.termination != SartTermination::iterations) break;
        if (before)
            lowerTotalVariation(volume, *before, options.totalVariation * changeLength(volume, *before),
                                kVariationSteps, float(options.lower), float(options.upper));
        if (options.historyEvery == 0) addPoint();
        if (result.termination != SartTermination::iterations) break;
    }
    result.volume = gridOf(volume, *transform, float(options.tolerance));
    return result;
}

}  // namespace raysweep
