#include "cube4/replay_reconstruction.h"

#include "cube4/base_plane.h"

#include "raysweep/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raysweep::cube4 {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void requirePossible(const ReconstructionRecord& record) {
    const std::string& path = record.file.path;
    if (record.totalVariation > 0)
        throw InvalidArgument(path + ": total variation was lowered between passes, which the machine does not do");
    for (const RecordedUpdate& update : record.updates)
        if (update.views.size() != 1)
            throw InvalidArgument(path + ": updates of several views at once; the machine corrects by one at a time");
}

/// Views of a run: parallel ones, or cones.
struct Views {
    std::vector<MeasuredView> parallel;
    std::vector<MeasuredCone> cones;
};

Views measuredViews(const ReconstructionRecord& record) {
    DenseBox box;
    box.high = Index3(record.width, record.height, int(record.views.size()));
    const DenseField all = denseField(*fieldOf(record.file, "projections"), box);
    const std::size_t pixels = std::size_t(record.width) * std::size_t(record.height);
    Views views;
    for (std::size_t n = 0; n < record.views.size(); ++n) {
        const RecordedView& view = record.views[n];
        const auto from = all.begin() + std::ptrdiff_t(n * pixels);
        const std::vector<float> values(from, from + std::ptrdiff_t(pixels));
        if (record.cone)
            views.cones.push_back(
                {{view.source, view.origin, view.column, view.row, record.width, record.height}, values});
        else
            views.parallel.push_back(
                {{view.direction, view.origin, view.column, view.row}, record.width, record.height, values});
    }
    return views;
}

/// For views whose pixels, seen along the rays, are voxels of a slice.
bool isAligned(const MeasuredView& view, const ReconstructionRecord& record) {
    const ContentBox content{Index3(1), Index3(1) + record.box.size()};
    const BasePlane plane(view.rays, record.box, record.origin, 1, content);
    const Traversal traversal = traverse(record.box.size() + Index3(2), content, plane.direction(), Resampling::linear);
    const Imath::V2d first = plane.positionOf(traversal, 0, 0, 0), next = plane.positionOf(traversal, 1, 0, 0),
                     below = plane.positionOf(traversal, 0, 1, 0);
    constexpr double kSame = 1e-5;
    const auto isUnit = [&](const Imath::V2d& step) {
        const double a = std::abs(step.x), b = std::abs(step.y);
        return (std::abs(a - 1) < kSame && b < kSame) || (std::abs(b - 1) < kSame && a < kSame);
    };
    return isUnit(next - first) && isUnit(below - first);
}

/// The same for cones: one front, whose pixels are in a plane of slices, and no region's rays are merged.
bool isAligned(const MeasuredCone& view, const ReconstructionRecord& record, const RaySampling& sampling) {
    const MemoryBox memory{record.box, record.origin, 1};
    const std::vector<PerspectiveFront> fronts = frontsOf(view.rays, memory, sampling);
    if (fronts.size() != 1) return false;
    const PerspectiveFront& front = fronts[0];
    const PointPlane plane(view.rays, memory);
    const auto rayOf = [&](double column, double row) { return front.rayOf(plane.wayOf(column, row), 0); };
    const double right = view.rays.width - 1, below = view.rays.height - 1;
    const Imath::V2d first = rayOf(0, 0);
    const auto isGrid = [](const Imath::V2d& way, double pixels) {
        constexpr double kSame = 1e-4;
        const double a = std::abs(way.x), b = std::abs(way.y);
        return (std::abs(a - pixels) < kSame && b < kSame) || (std::abs(b - pixels) < kSame && a < kSame);
    };
    return isGrid(rayOf(right, 0) - first, right) && isGrid(rayOf(0, below) - first, below) &&
           std::all_of(front.regions.begin(), front.regions.end(),
                       [](const Region& region) { return region.level == 0; });
}

bool areAligned(const Views& views, const ReconstructionRecord& record, const RaySampling& sampling) {
    return std::all_of(views.parallel.begin(), views.parallel.end(),
                       [&](const MeasuredView& view) { return isAligned(view, record); }) &&
           std::all_of(views.cones.begin(), views.cones.end(),
                       [&](const MeasuredCone& view) { return isAligned(view, record, sampling); });
}

bool runUpdates(const ReconstructionRecord& record, const Views& views, Reconstruction& machine,
                const ReplaySetup& setup, const ProgressCallback& progress, std::vector<double>& residuals) {
    residuals.clear();
    for (std::size_t n = 0; n < record.updates.size(); ++n) {
        if (!report(progress, "replaying", double(n) / double(record.updates.size()))) return false;
        const RecordedUpdate& update = record.updates[n];
        const std::size_t view = std::size_t(update.views[0]);
        residuals.push_back(record.cone ? machine.update(views.cones[view], update.relaxation, setup.trace)
                                        : machine.update(views.parallel[view], update.relaxation, setup.trace));
    }
    return true;
}

}  // namespace

ReconstructionReplay replay(const ReconstructionRecord& record, const ReplaySetup& setup,
                            const ProgressCallback& progress) {
    requirePossible(record);
    const Views views = measuredViews(record);
    ReconstructionSetup machineSetup;
    machineSetup.pipelines = setup.pipelines;
    machineSetup.overlap = setup.overlap;
    machineSetup.sampling = setup.sampling;
    machineSetup.lower = record.lower.value_or(-kInfinity);
    machineSetup.upper = record.upper.value_or(kInfinity);
    machineSetup.saturation = record.saturation.value_or(kInfinity);
    DenseField initial, support;
    if (const auto grid = fieldOf(record.file, "initial", true)) initial = denseField(*grid, record.box);
    if (const auto grid = fieldOf(record.file, "support", true)) support = denseField(*grid, record.box);

    ReconstructionReplay result;
    const Timer timer;
    Reconstruction exact(record.box, record.origin, machineSetup, initial, support);
    result.complete = runUpdates(record, views, exact, setup, progress, result.residuals);
    const Reconstruction* judged = &exact;
    std::optional<Reconstruction> rounded;
    if (setup.format && result.complete) {
        machineSetup.format = setup.format;
        machineSetup.largestValue = exact.largestValue();
        machineSetup.largestCorrection = exact.largestCorrection();
        machineSetup.largestSums = exact.largestSums();
        rounded.emplace(record.box, record.origin, machineSetup, initial, support);
        result.complete = runUpdates(record, views, *rounded, setup, progress, result.residuals);
        result.volumeToFloat = compareFields(rounded->volume(), exact.volume(), record.box);
        judged = &*rounded;
    }
    result.seconds = timer.seconds();
    result.field = judged->volume();
    result.volume = compareFields(result.field, *fieldOf(record.file, "density"), record.box, 0);
    result.alignedRays = areAligned(views, record, setup.sampling);
    result.project = judged->projectCounters();
    result.backproject = judged->backprojectCounters();
    result.passes = result.residuals.size();
    result.voxels = record.box.voxels();
    result.bytesPerModule = judged->bytesPerModule();
    result.bufferBytes = judged->bufferBytes();
    return result;
}

}  // namespace raysweep::cube4
