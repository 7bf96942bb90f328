#include "raysweep/mesh/mesh_volume.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/require.h"
#include "raysweep/mesh/mesh_distance.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/solid.h"

#include <openvdb/math/Proximity.h>
#include <openvdb/tools/Activate.h>
#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Prune.h>

#include <ImathBox.h>

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

using openvdb::FloatGrid;

constexpr float kRounding = 5e-3f;    ///< of a voxel's edge: faces between voxels touch neither
constexpr double kBand = 3;           ///< voxels on either side of a surface
constexpr int kMostVoxels = 1 << 16;  ///< along a side: single floats still place a corner to 1/100 voxel

using Triangles = std::vector<std::uint32_t>;

MeshLattice latticeFor(const TriangleMesh& mesh, const MeshVolumeOptions& options) {
    Imath::Box3d box;
    for (const TriangleMesh::Triangle& t : mesh.triangles)
        for (const std::uint32_t corner : t) box.extendBy(mesh.positions[corner]);
    const double longest = box.isEmpty() ? 0 : std::max({box.size().x, box.size().y, box.size().z});
    if (!(longest > 0) || !std::isfinite(longest)) throw InvalidArgument("the mesh has no extent");
    MeshLattice lattice{box.min, options.voxelSize.value_or(longest / options.size)};
    if (!(longest / lattice.voxel <= kMostVoxels))
        throw InvalidArgument("voxelSize " + brief(lattice.voxel, 4) + ": the mesh is " + brief(longest, 4) +
                              " long, which is more than 65536 voxels; give a larger one");
    for (int axis = 0; axis < 3 && options.voxelSize; ++axis)
        lattice.origin[axis] = std::floor(box.min[axis] / lattice.voxel) * lattice.voxel;
    return lattice;
}

/// Distances, nearest triangles, densities and colours all lie along the surface.
void requireRoom(const MeshShells& shells, const MeshVolumeOptions& options, double voxel) {
    double area = 0;
    for (const MeshShell& shell : shells.shells) area += shell.area;
    const double blocksAcross = options.thickness / 8 + 3;  // of 8 voxels
    constexpr std::size_t kBytes = 4 + 4 + 4 + 12;
    requireMemory(area / (64 * voxel * voxel) * blocksAcross, kBytes);
}

void add(Triangles& to, const MeshShell& shell) {
    to.insert(to.end(), shell.triangles.begin(), shell.triangles.end());
}

/// The triangles of closed shells, or of open ones.
Triangles trianglesOf(const MeshShells& shells, bool closed) {
    Triangles triangles;
    for (const MeshShell& shell : shells.shells)
        if (shell.closed == closed) add(triangles, shell);
    return triangles;
}

void count(double voxel, MeshVolume& volume) {
    for (const MeshShell& shell : volume.shells.shells) {
        ++(!shell.closed ? volume.sheets : shell.volume < 0 ? volume.inwards : volume.solids);
        volume.thin += shell.closed && 2 * std::abs(shell.volume) < shell.area * voxel;
    }
}

/// Fills closed shells. @return null if stopped
FloatGrid::Ptr fillClosed(const MeshPart& closed, const MeshLattice& lattice, const ProgressCallback& progress) {
    const FloatGrid::Ptr distance = signedDistance(closed, lattice, kBand, progress).distance;
    return distance ? levelSetToSolid(*distance) : nullptr;
}

/// Gives open shells a thickness. @return null if stopped
FloatGrid::Ptr thicken(const MeshPart& open, const MeshLattice& lattice, double thickness,
                       const ProgressCallback& progress) {
    const FloatGrid::Ptr sheet = unsignedDistance(open, lattice, thickness / 2 + 1, progress).distance;
    if (!sheet) return nullptr;
    const double densest = std::min(1.0, thickness);
    forEachActive(*sheet, [&](float& value, const openvdb::CoordBBox&) {
        value = float(std::clamp((thickness + 1) / 2 - double(value) / lattice.voxel, 0.0, densest));
    });
    openvdb::tools::changeBackground(sheet->tree(), 0.0f);
    return sheet;
}

/// Colour of the place on triangle `t` that is nearest to `p`.
openvdb::Vec3s colorNear(const TriangleMesh& mesh, const TriangleMesh::Triangle& t, const openvdb::Vec3d& p) {
    const auto corner = [&](int i) {
        const Vec3& at = mesh.positions[t[std::size_t(i)]];
        return openvdb::Vec3d(at.x, at.y, at.z);
    };
    openvdb::Vec3d weights;  // of the corners
    openvdb::math::closestPointOnTriangleToPoint(corner(0), corner(1), corner(2), p, weights);
    Color color(0, 0, 0);
    for (int i = 0; i < 3; ++i) color += mesh.colors[t[std::size_t(i)]] * float(weights[i]);
    return openvdb::Vec3s(color.x, color.y, color.z);
}

openvdb::Vec3s meanColor(const TriangleMesh& mesh) {
    Vec3 sum(0);  // single floats lose a percent of a million
    for (const Color& color : mesh.colors) sum += Vec3(color);
    sum /= double(mesh.colors.size());
    return openvdb::Vec3s(float(sum.x), float(sum.y), float(sum.z));
}

/// Where solids and sheets are the denser counts. @return null if stopped
FloatGrid::Ptr densityOf(const TriangleMesh& mesh, const MeshLattice& lattice, const MeshVolume& volume,
                         const ProgressCallback& progress) {
    const MeshPart closed{mesh, trianglesOf(volume.shells, true)}, open{mesh, trianglesOf(volume.shells, false)};
    if (closed.triangles.empty() && open.triangles.empty()) throw InvalidArgument("the mesh has no extent");
    FloatGrid::Ptr solids, sheets;
    if (!closed.triangles.empty() && !(solids = fillClosed(closed, lattice, progress))) return nullptr;
    if (!open.triangles.empty() && !(sheets = thicken(open, lattice, volume.thickness, progress))) return nullptr;
    if (!solids) return sheets;
    if (sheets) openvdb::tools::compMax(*solids, *sheets);
    return solids;
}

/// Colours of the voxels near the surface, and of all others of `density`, where no light gets: the mean.
/// @return null if stopped
openvdb::Vec3SGrid::Ptr colorsFor(const MeshPart& all, const MeshLattice& lattice, double band,
                                  const FloatGrid& density, const ProgressCallback& progress) {
    const openvdb::Int32Grid::Ptr nearest = unsignedDistance(all, lattice, band, progress).nearest;
    if (!nearest) return nullptr;
    const auto color = openvdb::Vec3SGrid::create(meanColor(all.mesh));
    color->setTransform(lattice.transform());
    color->setName("Cd");
    color->topologyUnion(*nearest);
    setActive(*color, [&] {
        return [&, triangles = nearest->getConstUnsafeAccessor()](const openvdb::Coord& at) {
            const auto part = std::size_t(triangles.getValue(at));
            return colorNear(all.mesh, all.mesh.triangles[all.triangles[part]], color->indexToWorld(at));
        };
    });
    color->topologyUnion(density);
    openvdb::tools::changeBackground(color->tree(), openvdb::Vec3s(0));
    return color;
}

}  // namespace

void MeshVolumeOptions::validate() const {
    if (voxelSize)
        requireField(*voxelSize > 0 && std::isfinite(*voxelSize), "voxelSize", *voxelSize, "finite and above 0");
    requireField(size >= 1 && size <= kMostVoxels, "size", size, "between 1 and 65536");
    requireField(thickness > 0 && thickness <= 1024, "thickness", thickness, "above 0 and at most 1024 voxels");
    requireField(!name.empty(), "name", "''", "not empty");
}

MeshVolume meshToVolume(const TriangleMesh& asGiven, const MeshVolumeOptions& options,
                        const ProgressCallback& progress) {
    options.validate();
    const MeshLattice lattice = latticeFor(asGiven, options);
    MeshVolume volume;
    volume.thickness = options.thickness;
    volume.shells = shellsOf(asGiven);
    requireRoom(volume.shells, options, lattice.voxel);
    count(lattice.voxel, volume);
    const TriangleMesh mesh = facingAlike(asGiven, volume.shells);
    volume.density = densityOf(mesh, lattice, volume, progress);
    if (!volume.density) return volume;
    forEachActive(*volume.density, [](float& value, const openvdb::CoordBBox&) {
        value = value < kRounding ? 0 : value > 1 - kRounding ? 1 : value;
    });
    openvdb::tools::deactivate(volume.density->tree(), 0.0f);
    openvdb::tools::prune(volume.density->tree());
    volume.density->setName(options.name);
    volume.density->setGridClass(openvdb::GRID_FOG_VOLUME);
    if (mesh.colors.empty()) return volume;
    MeshPart all{mesh, {}};
    for (const MeshShell& shell : volume.shells.shells) add(all.triangles, shell);
    volume.color = colorsFor(all, lattice, options.thickness / 2 + kBand, *volume.density, progress);
    if (!volume.color) volume.density = nullptr;
    return volume;
}

}  // namespace raysweep
