#include "cube4/turntable.h"

#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace raysweep::cube4 {
namespace {

/// View `number`, of all of the box, with the voxel `box.low` at 0. Nothing measured yet.
MeasuredView turnedView(const DenseBox& box, int number, int views) {
    const double angle = kPi * number / views, edge = std::cbrt(box.voxelVolume());
    const Index3 size = box.size();
    const Vec3 half = Vec3(size.x - 1, size.y - 1, size.z - 1) * 0.5 * box.worldFromIndex;
    MeasuredView view;
    view.rays.direction = Vec3(std::cos(angle), std::sin(angle), 0);
    view.rays.column = Vec3(-std::sin(angle), std::cos(angle), 0) * edge;
    view.rays.row = Vec3(0, 0, edge);
    const double reach = half.length() / edge + 1;
    view.width = view.height = 2 * int(std::ceil(reach)) + 1;
    view.rays.origin = half - view.rays.column * (0.5 * (view.width - 1)) - view.rays.row * (0.5 * (view.height - 1));
    return view;
}

/// Order in which views follow each other by about a golden section of all.
std::vector<int> goldenOrder(int views) {
    std::vector<double> place;
    for (int n = 0; n < views; ++n) place.push_back(std::fmod(n * 0.6180339887498949, 1.0));
    std::vector<int> byPlace(place.size()), order(place.size());
    std::iota(byPlace.begin(), byPlace.end(), 0);
    std::sort(byPlace.begin(), byPlace.end(),
              [&](int a, int b) { return place[std::size_t(a)] < place[std::size_t(b)]; });
    for (std::size_t rank = 0; rank < byPlace.size(); ++rank) order[std::size_t(byPlace[rank])] = int(rank);
    return order;
}

/// All passes. @return false if it was stopped
bool runPasses(const std::vector<MeasuredView>& views, const TurntableSetup& turntable, Reconstruction& machine,
               const ReplaySetup& setup, const ProgressCallback& progress) {
    const std::vector<int> order = goldenOrder(turntable.views);
    for (int pass = 0; pass < turntable.passes; ++pass)
        for (std::size_t n = 0; n < order.size(); ++n) {
            const double done = (pass + double(n) / double(order.size())) / turntable.passes;
            if (!report(progress, "reconstructing", done)) return false;
            machine.update(views[std::size_t(order[n])], turntable.relaxation, setup.trace);
        }
    return true;
}

}  // namespace

void TurntableSetup::validate() const {
    requireField(views >= 1, "views", views, "at least 1");
    requireField(passes >= 1, "iterations", passes, "at least 1");
    requireField(relaxation > 0 && relaxation < 2, "relaxation", relaxation, "between 0 and 2");
}

TurntableResult reconstructTurning(const DenseField& volume, const DenseBox& box, const TurntableSetup& turntable,
                                   const ReplaySetup& setup, const ProgressCallback& progress) {
    turntable.validate();
    ReconstructionSetup machineSetup;
    machineSetup.pipelines = setup.pipelines;
    machineSetup.overlap = setup.overlap;
    machineSetup.upper = machineSetup.saturation = std::numeric_limits<double>::infinity();
    std::vector<MeasuredView> views;
    Reconstruction original(box, Vec3(0), machineSetup, volume);
    for (int n = 0; n < turntable.views; ++n) {
        views.push_back(turnedView(box, n, turntable.views));
        views.back().values = original.project(views.back());
    }

    TurntableResult result;
    Reconstruction exact(box, Vec3(0), machineSetup);
    const Reconstruction* judged = &exact;
    result.complete = runPasses(views, turntable, exact, setup, progress);
    std::optional<Reconstruction> rounded;
    if (setup.format && result.complete) {
        machineSetup.format = setup.format;
        machineSetup.largestValue = exact.largestValue();
        machineSetup.largestCorrection = exact.largestCorrection();
        machineSetup.largestSums = exact.largestSums();
        rounded.emplace(box, Vec3(0), machineSetup);
        result.complete = runPasses(views, turntable, *rounded, setup, progress);
        result.volumeToFloat = compareFields(rounded->volume(), exact.volume(), box);
        judged = &*rounded;
    }
    result.field = judged->volume();
    result.volume = compareFields(result.field, volume, box);
    result.updates = std::size_t(turntable.views) * std::size_t(turntable.passes);
    result.project = judged->projectCounters();
    result.backproject = judged->backprojectCounters();
    result.bytesPerModule = judged->bytesPerModule();
    result.bufferBytes = judged->bufferBytes();
    return result;
}

}  // namespace raysweep::cube4
