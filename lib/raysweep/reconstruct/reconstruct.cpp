#include "raysweep/reconstruct/reconstruct.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/projector/footprint.h"
#include "raysweep/reconstruct/backprojection.h"
#include "raysweep/reconstruct/direct_scan.h"
#include "raysweep/reconstruct/grid_lattice.h"
#include "raysweep/reconstruct/orbit_fit.h"
#include "raysweep/reconstruct/rays_beside.h"
#include "raysweep/reconstruct/truncation.h"
#include "raysweep/scan/line_integrals.h"
#include "raysweep/volume/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace raysweep {
namespace {

using Kind = ReconstructionWarning::Kind;

bool isDirect(const ReconstructOptions& options) {
    return options.method == ReconstructionMethod::fbp;
}

bool filters(const ReconstructOptions& options) {
    return isDirect(options) || options.startFiltered;
}

void requireVoxels(const openvdb::FloatGrid::ConstPtr& volume, const char* name) {
    if (volume && volume->evalActiveVoxelBoundingBox().empty())
        throw InvalidArgument(std::string("the ") + name + " volume has no active voxels");
}

/// The volume that says where things are, if any.
const openvdb::FloatGrid* frameOf(const ReconstructOptions& options) {
    return options.volumes.initial ? options.volumes.initial.get() : options.volumes.reference.get();
}

void requireRoom(const ReconstructionGrid& grid, const ReconstructOptions& options) {
    requireBytes(leastBytes(grid, options),
                 "a volume of " + std::to_string(grid.dims.x) + "x" + std::to_string(grid.dims.y) + "x" +
                     std::to_string(grid.dims.z) + " voxels needs at least",
                 "use larger voxels, or less of them");
}

/// A scan, the turn that its views are of, if they are, and how its object goes on beyond the detector, if it does.
struct Measured {
    const Scan& scan;
    std::optional<OrbitFit> orbit;
    std::optional<Truncation> truncation;
};

Measured measuredBy(const Scan& scan, const std::optional<OrbitFit>& orbit) {
    Measured measured{scan, orbit, {}};
    if (orbit) measured.truncation = findTruncation(scan.projections, scan.geometry, *orbit);
    return measured;
}

/// What direct methods should know of a scan that they can use.
void addDirectWarnings(const Scan& scan, const RayCounts& rays, const DirectScan& direct, Reconstruction& result) {
    if (const std::size_t bounded = rays.saturated + rays.overexposed)
        result.warnings.push_back({Kind::saturation, std::to_string(bounded) +
                                                         " values that are saturated, at least or at most what they "
                                                         "say, are taken as if they were measured; iterative methods "
                                                         "know better"});
    const std::string amiss = direct.warning(&scan.projections);
    if (!amiss.empty()) result.warnings.push_back({Kind::shortScan, amiss});
}

/// Filtered backprojection needs a value for every ray. What is amiss is that of the detector as it is, within the
/// field; what is filtered is the wide one.
openvdb::FloatGrid::Ptr filtered(const Measured& measured, const ReconstructOptions& options,
                                 const ProgressCallback& progress, Reconstruction& result) {
    const Scan& scan = measured.scan;
    const std::optional<Truncation>& truncation = measured.truncation;
    const Timer timer;
    DirectScan direct(scan.geometry, *measured.orbit);
    if (truncation) direct.field = truncation->radius;
    const RayCounts rays = countRays(scan.projections);
    addDirectWarnings(scan, rays, direct, result);
    Projections filled;
    if (rays.notMeasured > 0) fillUnmeasured(filled = scan.projections);
    const Projections& projections = rays.notMeasured > 0 ? filled : scan.projections;
    requireUsable(direct, projections);
    openvdb::FloatGrid::Ptr volume;
    if (truncation) {
        const WideDetector wide = wideDetector(*truncation, scan.geometry);
        const auto pixels = [&](std::size_t n, std::vector<float>& room) -> const float* {
            room = continuedView(*truncation, scan.geometry, wide, n, projections.view(int(n)));
            return room.data();
        };
        volume = backprojection(DirectScan(wide.geometry, truncation->orbit, wide.parts), pixels, result.grid,
                                options.fbp, progress);
        volume = fieldOf(*truncation, result.grid, *volume);
    } else {
        const auto pixels = [&](std::size_t n, std::vector<float>&) { return projections.view(int(n)); };
        volume = backprojection(direct, pixels, result.grid, options.fbp, progress);
    }
    result.seconds.filtered = timer.seconds();
    return volume;
}

/// Floats hold places on the detector, so voxels may not be anywhere, nor of any size.
void requirePlace(const ReconstructionGrid& grid, const ProjectionGeometry& geometry) {
    constexpr double kMost = 1e9;  // pixels; or their part
    const double pixel = geometry.views.front().column.length();
    const Vec3 size = grid.size(), &edges = grid.spacing;
    const double away = (grid.center - geometry.views.front().origin).length() + std::max({size.x, size.y, size.z});
    const double longest = std::max({edges.x, edges.y, edges.z});
    const bool isSmall = !(grid.shortestEdge() > pixel / kMost);
    if (!isSmall && longest < pixel * kMost && away < pixel * kMost * kMost) return;
    InvalidArgument error("spacing " + brief(isSmall ? grid.shortestEdge() : longest) +
                          ": must be more than a billionth, and less than a billion of the detector's pixels (" +
                          brief(pixel) + "), and the grid where these can see it");
    error.subject = "spacing";
    throw error;
}

int viewsTogether(const ReconstructOptions& options, int views) {
    switch (options.method) {
        case ReconstructionMethod::sirt:
            return 0;
        case ReconstructionMethod::osSart:
            return options.subset > 0 ? options.subset : std::max(1, views / 10);
        default:
            return 1;
    }
}

ReconstructionTermination terminationOf(SartTermination termination) {
    switch (termination) {
        case SartTermination::interrupted:
            return ReconstructionTermination::interrupted;
        case SartTermination::residual:
            return ReconstructionTermination::residual;
        default:
            return ReconstructionTermination::iterations;
    }
}

void iterate(const Measured& measured, const ReconstructOptions& options, const openvdb::FloatGrid::ConstPtr& given,
             const ProgressCallback& progress, Reconstruction& result) {
    const Scan& scan = measured.scan;
    SartOptions sartOptions = options.sart;
    sartOptions.viewsPerUpdate = viewsTogether(options, scan.projections.views);
    ReconstructionGrid grid = result.grid;
    openvdb::FloatGrid::ConstPtr initial = given;
    if (measured.truncation) {
        grid = widened(*measured.truncation, grid);
        requireRoom(grid, options);
        initial = continuedObject(*measured.truncation, scan.geometry, grid, {given.get(), result.grid});
    }
    if (const auto beside = findRaysBeside(scan.projections, scan.geometry, grid))
        result.warnings.push_back({Kind::raysBeside, beside->warning()});
    SartResult iterated =
        sart(scan.projections, scan.geometry, grid, sartOptions, {initial, options.volumes.reference}, progress);
    result.volume =
        measured.truncation ? fieldOf(*measured.truncation, result.grid, *iterated.volume) : iterated.volume;
    result.termination = terminationOf(iterated.termination);
    result.history = std::move(iterated.history);
    result.updates = iterated.updates;
    result.keptVoxels = iterated.keptVoxels;
    result.raysUsed = iterated.raysUsed;
    result.seconds.updates = iterated.seconds;
}

/// See Reconstruction::rms.
double rmsOf(const Reconstruction& result, const openvdb::FloatGrid* reference) {
    if (!reference) return std::numeric_limits<double>::quiet_NaN();
    const auto shift = shiftTo(*reference, result.grid);
    return shift ? rmsDifference(*result.volume, *reference, result.grid.dims, *shift)
                 : compareGrids(*result.volume, *reference).rmse;
}

/// @param edge the shortest of a voxel
std::optional<ReconstructionWarning> voxelSizeWarning(const ProjectionGeometry& geometry, double edge) {
    constexpr double kApart = 4;  // as a factor
    double pixel = 0;
    try {
        pixel = coveringGrid(geometry).edge();
    } catch (const InvalidArgument&) {
        return {};  // no axis to see them at
    }
    if (edge <= kApart * pixel && edge >= pixel / kApart) return {};
    return ReconstructionWarning{Kind::voxelSize,
                                 "voxels are " + brief(edge / pixel) +
                                     " times as large as the detector's pixels, seen at the axis; are voxels, pixels "
                                     "and the geometry in the same unit (mm, cm)?"};
}

std::optional<ReconstructionWarning> opaqueVoxelWarning(const openvdb::FloatGrid& volume, double edge) {
    constexpr double kOpaque = 4;  // optical depth of a voxel: no scan has one that stops 98 % of the rays
    const ValueRange range = valueRange(volume);
    if (range.max.empty() || !(range.max[0] * edge > kOpaque)) return {};
    return ReconstructionWarning{
        Kind::opaqueVoxel, "a single voxel would stop up to " + brief(100 * (1 - std::exp(-range.max[0] * edge)), 3) +
                               " % of the rays: densities as large as " + brief(range.max[0]) +
                               " per world unit suggest that lengths were given in the wrong unit (mm, cm), or that "
                               "the input does not hold line integrals"};
}

/// Where numbers left the range of floats, as with voxels of 1e38.
void requireFinite(const openvdb::FloatGrid& volume) {
    const auto isFinite = [](const auto& leaf) {
        for (auto value = leaf.cbeginValueOn(); value; ++value)
            if (!std::isfinite(*value)) return false;
        return true;
    };
    for (auto leaf = volume.tree().cbeginLeaf(); leaf; ++leaf)
        if (!isFinite(*leaf))
            throw InvalidArgument(
                "the densities that would be reconstructed are NaN or infinite: line integrals, or the lengths of "
                "geometry and grid, are too large or too small for floats");
}

void addWarnings(const ProjectionGeometry& geometry, Reconstruction& result) {
    for (const auto& warning : {voxelSizeWarning(geometry, result.grid.shortestEdge()),
                                opaqueVoxelWarning(*result.volume, result.grid.shortestEdge())})
        if (warning) result.warnings.push_back(*warning);
    if (2 * std::size_t(result.viewsSeeing) < geometry.views.size())
        result.warnings.push_back({Kind::fewViews, "the volume falls onto the detector in " +
                                                       std::to_string(result.viewsSeeing) + " of " +
                                                       std::to_string(geometry.views.size()) +
                                                       " views only; check where it lies, and the geometry"});
    if (result.volume->empty())
        result.warnings.push_back({Kind::emptyVolume,
                                   "the volume is empty: no line integral is above 0, or none of its rays meets the "
                                   "volume"});
}

}  // namespace

void ReconstructOptions::validate() const {
    requireField(subset >= 0, "subset", subset, "at least 0");
    sart.validate();
    fbp.validate();
    grid.validate();
    if (startFiltered && volumes.initial)
        throw InvalidArgument("startFiltered: must be false if there is an initial volume");
    requireVoxels(volumes.initial, "initial");
    requireVoxels(volumes.reference, "reference");
}

double leastBytes(const ReconstructionGrid& grid, const ReconstructOptions& options) {
    constexpr double kLeast = 1.0 / 16;  // the part of a grid that an object takes up at the least
    const bool whole = filters(options) || options.volumes.reference || options.sart.support == Support::none;
    return double(grid.dims.x) * grid.dims.y * grid.dims.z * sizeof(float) * (whole ? 1 : kLeast);
}

Reconstruction reconstruct(const Scan& scan, const ReconstructOptions& options, const ProgressCallback& progress) {
    options.validate();
    scan.geometry.validate();
    requireMatching(scan.geometry, scan.projections);
    const Timer timer;
    Reconstruction result;
    // Says why it cannot be, before anything else.
    const std::optional<OrbitFit> orbit = filters(options) ? fitOrbit(scan.geometry) : findOrbit(scan.geometry);
    result.grid = reconstructionGrid(scan.geometry, options.grid, frameOf(options));
    requirePlace(result.grid, scan.geometry);
    result.viewsSeeing = requireSeen(scan.geometry, latticeOf(result.grid, scan.geometry));
    requireRoom(result.grid, options);

    bool stopped = false;  // once asked to stop, whatever comes next stops as well
    const ProgressCallback stoppable = [&](const std::string& stage, double fraction) {
        stopped = stopped || !report(progress, stage, fraction);
        return !stopped;
    };
    const Measured measured = measuredBy(scan, orbit);
    if (measured.truncation) {
        result.fieldRadius = measured.truncation->radius;
        result.rowsCut = measured.truncation->share;
        result.warnings.push_back({Kind::truncation, measured.truncation->warning()});
    }
    openvdb::FloatGrid::ConstPtr initial = options.volumes.initial;
    if (filters(options)) {
        const openvdb::FloatGrid::Ptr volume = filtered(measured, options, stoppable, result);
        initial = result.volume = volume;
    }
    if (!isDirect(options))
        iterate(measured, options, initial, stoppable, result);
    else if (stopped)
        result.termination = ReconstructionTermination::interrupted;
    result.seconds.total = timer.seconds();
    requireFinite(*result.volume);

    result.rms = rmsOf(result, options.volumes.reference.get());
    addWarnings(scan.geometry, result);
    return result;
}

}  // namespace raysweep
