/// Objects wider than the detector: found, and continued beyond it. What rays beside the detector would have measured
/// decides how dense everything inside is; to take it for nothing makes a dish of the volume. Each detector row sees a
/// slice, which is continued as the ellipse of one extinction that its line integrals fit best (fitEllipticBody): such
/// a body's rows belong together from view to view, as those of a cosine or of a circle about the axis, which end
/// where each row likes, do not. Measured against these, and a coarse reconstruction of more than the field, in
/// docs/ct.md.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/camera/projections.h"
#include "raysweep/reconstruct/aligned_views.h"
#include "raysweep/reconstruct/elliptic_body.h"
#include "raysweep/reconstruct/orbit_fit.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/volume/grids.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// Sides on which the rows of a view end where no other view goes on: at pixel 0, at the last one.
struct OuterEnds {
    bool low = false, high = false;
};

/// A scan whose object is wider than the detector.
struct Truncation {
    double radius = 0;            ///< of the field about the axis in which all lines were measured, world units
    double share = 0;             ///< of the outer ends of detector rows, in all views: those within the object
    double border = 0;            ///< mean line integral at these, relative to the largest
    double reach = 0;             ///< of the object about the axis, as it is continued, world units
    bool sideways = false;        ///< detector columns run across the axis, not rows; "row" means column then
    std::vector<OuterEnds> ends;  ///< of each view
    OrbitFit orbit;
    Vec3 planeX{0}, planeY{0};         ///< axes of the plane across the axis, in which the bodies are
    std::vector<EllipticBody> bodies;  ///< for each row; extinction 0: it sees all of its slice
    float threshold = 0;               ///< line integral at a row's end, from which on it is within the object

    /// In words, with what became of it.
    std::string warning() const;
};

/// Nothing if no row ends within the object, if the views are no turn about an axis, or if no ray passes near it: then
/// there is no field. A row does if the line integral at its outer end (median of three pixels, mean over a twelfth of
/// a turn) is more than a twentieth of the largest, in a twentieth of the views at least. What a detector that is
/// displaced in a full turn, or one of several side by side, misses at its other end, another view measures.
std::optional<Truncation> findTruncation(const Projections& projections, const ProjectionGeometry& geometry);
std::optional<Truncation> findTruncation(const Projections& projections, const ProjectionGeometry& geometry,
                                         const OrbitFit& orbit);

/// A detector as wide as the object.
struct WideDetector {
    ProjectionGeometry geometry;
    std::vector<DetectorPart> parts;  ///< of each view: what was measured, and is continued at outer ends
    int low = 0, high = 0;            ///< pixels that were added to rows
};

WideDetector wideDetector(const Truncation& truncation, const ProjectionGeometry& geometry);

/// What view n of the wide detector would have measured; beyond ends that are none of `truncation.ends` what is
/// measured there goes on. @param measured pixels of the view, all finite
std::vector<float> continuedView(const Truncation& truncation, const ProjectionGeometry& geometry,
                                 const WideDetector& wide, std::size_t n, const float* measured);

/// A grid whose voxels include those of `grid` and reach as far across the axis as the object.
ReconstructionGrid widened(const Truncation& truncation, const ReconstructionGrid& grid);

/// A volume that is known, and where: in `grid` as far as the field reaches, and further where it is active.
struct KnownVolume {
    const openvdb::FloatGrid* volume = nullptr;  ///< may be null: nothing is known
    const ReconstructionGrid& grid;
};

/// The bodies in the voxels of `grid`, and what is known, zeros included.
/// @throw InvalidArgument if the voxels of the known volume are not where those of `grid` are
openvdb::FloatGrid::Ptr continuedObject(const Truncation& truncation, const ProjectionGeometry& geometry,
                                        const ReconstructionGrid& grid, const KnownVolume& known);

/// The part of `volume`, voxels and no tiles, that is in `grid` and in the field: what is further away was not measured
/// from all sides. Its metadata say so, "field_radius" and "field_rows_cut" (`share`).
openvdb::FloatGrid::Ptr fieldOf(const Truncation& truncation, const ReconstructionGrid& grid,
                                const openvdb::FloatGrid& volume);

}  // namespace raysweep
