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

/// Fills closed shells.
FloatGrid::Ptr fillClosed(const TriangleMesh& mesh, const MeshLattice& lattice, MeshVolume& volume) {
    MeshPart closed{mesh, {}};
    for (const MeshShell& shell : volume.shells.shells) {
        if (!shell.closed) continue;
        add(closed.triangles, shell);
        ++(shell.volume < 0 ? volume.inwards : volume.solids);
        volume.thin += 2 * std::abs(shell.volume) < shell.area * lattice.voxel;
    }
    if (closed.triangles.empty()) return nullptr;
    return levelSetToSolid(*signedDistance(closed, lattice, kBand).distance);
}

/// Gives open shells a thickness.
FloatGrid::Ptr thicken(const TriangleMesh& mesh, const MeshLattice& lattice, double thickness, MeshVolume& volume) {
    MeshPart open{mesh, {}};
    for (const MeshShell& shell : volume.shells.shells) {
        if (shell.closed) continue;
        add(open.triangles, shell);
        ++volume.sheets;
    }
    if (open.triangles.empty()) return nullptr;
    const FloatGrid::Ptr sheet = unsignedDistance(open, lattice, thickness / 2 + 1).distance;
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
    Color sum(0, 0, 0);
    for (const Color& color : mesh.colors) sum += color;
    sum /= float(mesh.colors.size());
    return openvdb::Vec3s(sum.x, sum.y, sum.z);
}

/// Colours of the voxels near the surface, and of all others of `density`, where no light gets: the mean.
openvdb::Vec3SGrid::Ptr colorsFor(const MeshPart& all, const MeshLattice& lattice, const MeshVolumeOptions& options,
                                  const FloatGrid& density) {
    const openvdb::Int32Grid::Ptr nearest = unsignedDistance(all, lattice, options.thickness / 2 + kBand).nearest;
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

MeshVolume meshToVolume(const TriangleMesh& asGiven, const MeshVolumeOptions& options) {
    options.validate();
    const MeshLattice lattice = latticeFor(asGiven, options);
    MeshVolume volume;
    volume.thickness = options.thickness;
    volume.shells = shellsOf(asGiven);
    requireRoom(volume.shells, options, lattice.voxel);
    const TriangleMesh mesh = facingAlike(asGiven, volume.shells);
    volume.density = fillClosed(mesh, lattice, volume);
    const FloatGrid::Ptr sheets = thicken(mesh, lattice, options.thickness, volume);
    if (volume.density && sheets)
        openvdb::tools::compMax(*volume.density, *sheets);
    else if (sheets)
        volume.density = sheets;
    if (!volume.density) throw InvalidArgument("the mesh has no extent");
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
    volume.color = colorsFor(all, lattice, options, *volume.density);
    return volume;
}

}  // namespace raysweep
