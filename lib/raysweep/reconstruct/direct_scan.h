/// A scan as filtered backprojection takes it: the turn, detectors that are aligned with it, what each ray counts, and
/// what rays there are none of.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/camera/projections.h"
#include "raysweep/reconstruct/aligned_views.h"
#include "raysweep/reconstruct/orbit_fit.h"
#include "raysweep/reconstruct/redundancy.h"

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace raysweep {

/// By how much the ray through a point passes the axis, q of eq. 9 in redundancy.h.
double passOf(const ProjectionGeometry& geometry, const OrbitFit& orbit, const XrayView& view, const Vec3& point);

/// How far from the axis rays of that q pass, world units, with its sign.
double distanceOf(const ProjectionGeometry& geometry, const OrbitFit& orbit, double q);

struct DirectScan {
    const ProjectionGeometry& geometry;
    OrbitFit orbit;
    std::vector<AlignedView> views;
    Redundancy redundancy;

    double field = std::numeric_limits<double>::infinity();  ///< lines that pass the axis further away are not needed,
                                                             ///< world units

    /// Keeps the reference. @param parts as of alignedViews  @throw InvalidArgument as alignedViews.
    DirectScan(const ProjectionGeometry& geometry, const OrbitFit& orbit, const std::vector<DetectorPart>& parts = {});

    /// What the rays of a column of view n count before its rows are filtered as if pixels were 1 apart, and its values
    /// backprojected with 1/depth²: Δθ w / pitch of eq. 3, Δβ w SID / (SDD pitch) of eq. 4.
    std::vector<double> columnWeights(std::size_t n) const;

    /// cos φ of eq. 4 for a pixel of view n's aligned detector; 1 for parallel rays.
    double cosine(std::size_t n, double x, double y) const;

    /// @throw InvalidArgument if views see what is around the axis, but not the axis, or hardly: no ramp filter makes
    /// up for that.
    void requireAxisSeen() const;

    /// @throw InvalidArgument if many lines through what the projections show are measured from no side, because the
    /// detector is displaced or the turn has several gaps.
    void requireLines(const Projections& projections) const;

    /// What rays are missing, in words; empty if none are, or if what they would have shown is empty.
    /// @param projections null: nothing is known to be empty
    std::string warning(const Projections* projections) const;

  private:
    double steepness(std::size_t n, double q) const;
    std::string shortArcWarning() const;
    bool showsBeyond(double q, const Projections& projections) const;
    struct MissingLines {
        double from = 0, to = 0;  ///< q, see redundancy.h
        double most = 0;          ///< part of those at one q; 0: none is missing
    };
    MissingLines missingLines(double part) const;
    std::string describe(const MissingLines& lines) const;
    bool isSimple() const;
};

}  // namespace raysweep
