#include "raysweep/mesh/mesh_distance.h"

#include "raysweep/mesh/mesh_winding.h"
#include "raysweep/volume/active_values.h"

#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <atomic>
#include <thread>

namespace raysweep {
namespace {

/// OpenVDB asks from any of its threads; `progress` is called from the one that called.
class Asking final : public openvdb::util::NullInterrupter {
  public:
    explicit Asking(const ProgressCallback& progress) : progress_(progress) {}

    bool wasInterrupted(int percent) override {
        if (std::this_thread::get_id() != caller_ || stopped_) return stopped_;
        if (percent > percent_) percent_ = percent;
        if (!report(progress_, "distances", percent_ / 100.0)) stopped_ = true;
        return stopped_;
    }

    bool stopped() const { return stopped_; }

  private:
    const ProgressCallback& progress_;
    const std::thread::id caller_ = std::this_thread::get_id();
    int percent_ = 0;  ///< of the caller's alone
    std::atomic<bool> stopped_{false};
};

}  // namespace

using openvdb::Vec3I;
using openvdb::Vec3s;

openvdb::math::Transform::Ptr MeshLattice::transform() const {
    const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
    const Vec3 center = origin + Vec3(voxel / 2);
    transform->postTranslate(openvdb::Vec3d(center.x, center.y, center.z));
    return transform;
}

std::vector<Vec3s> latticePoints(const TriangleMesh& mesh, const MeshLattice& lattice) {
    const Vec3 aside(0.0003, 0.0005, 0.0007);
    std::vector<Vec3s> points;
    points.reserve(mesh.positions.size());
    for (const Vec3& p : mesh.positions) {
        const Vec3 at = (p - lattice.origin) / lattice.voxel - Vec3(0.5) + aside;
        points.emplace_back(float(at.x), float(at.y), float(at.z));
    }
    return points;
}

MeshDistance unsignedDistance(const MeshPart& part, const MeshLattice& lattice, double band,
                              const ProgressCallback& progress) {
    const std::vector<Vec3s> points = latticePoints(part.mesh, lattice);
    std::vector<Vec3I> triangles;
    triangles.reserve(part.triangles.size());
    for (const std::uint32_t i : part.triangles) {
        const TriangleMesh::Triangle& t = part.mesh.triangles[i];
        triangles.emplace_back(t[0], t[1], t[2]);
    }
    const openvdb::tools::QuadAndTriangleDataAdapter<Vec3s, Vec3I> adapter(points, triangles);
    MeshDistance made{nullptr, openvdb::Int32Grid::create(-1)};
    Asking asking(progress);
    openvdb::util::NullInterrupter& interrupter = asking;
    made.distance = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        interrupter, adapter, *lattice.transform(), float(band), float(band), openvdb::tools::UNSIGNED_DISTANCE_FIELD,
        made.nearest.get());
    if (asking.stopped()) return {};
    return made;
}

MeshDistance signedDistance(const MeshPart& part, const MeshLattice& lattice, double band,
                            const ProgressCallback& progress) {
    MeshDistance made = unsignedDistance(part, lattice, band, progress);
    if (!made.distance || !report(progress, "insides", 0)) return {};
    // OpenVDB's own signs are wrong for a row of voxels along every concave edge, and where solids overlap.
    const MeshWinding winding(part, lattice);
    if (!report(progress, "insides", 0.5)) return {};
    const auto blocks = activeBlocks(*made.distance);
    parallelFor(blocks.size(), [&](std::size_t i) {
        forEachActive(blocks[i], [&](float& distance, const openvdb::CoordBBox& box) {
            if (winding.numberAt(box.min()) != 0) distance = -distance;
        });
    });
    openvdb::tools::signedFloodFill(made.distance->tree());
    return made;
}

}  // namespace raysweep
