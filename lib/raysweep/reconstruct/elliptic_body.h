/// An ellipse of one extinction, and the one that line integrals fit best: what a slice is like from afar.
#pragma once

#include <array>
#include <vector>

namespace raysweep {

/// A line in a plane, and what was measured along it. World units.
struct PlaneLine {
    double normalX = 1, normalY = 0;  ///< length 1
    double distance = 0;              ///< from the origin, along the normal
    double value = 0;                 ///< line integral, without unit
};

/// All points `center` + L e with |e| <= 1 and a lower triangular L.
struct EllipticBody {
    double xx = 1, yx = 0, yy = 1;    ///< of L, world units; xx, yy > 0
    double centerX = 0, centerY = 0;  ///< world units
    double extinction = 0;            ///< 1/world unit, >= 0

    /// Along a line: 2 μ det L √(w - d²) / w, where w = |Lᵀ n|² and d is the line's distance from the centre.
    double lineIntegral(double normalX, double normalY, double distance) const;
    bool contains(double x, double y) const;
    double reach() const;  ///< largest distance of its points from the origin

    /// What is between two bodies, 0 <= `part` <= 1.
    static EllipticBody between(const EllipticBody& a, const EllipticBody& b, double part);
};

/// The body whose line integrals come nearest to `lines`, in the sense of Cauchy's log(1 + (residual / scale)²): what
/// is not of one extinction within it is passed over rather than averaged. Levenberg-Marquardt, from circles that are
/// drawn out four ways. P. W. Holland and R. E. Welsch, "Robust regression using iteratively reweighted least squares",
/// Commun. Stat. A 6, 1977.
/// @param field distance from the origin up to which all lines were measured, > 0; the axes of L are a quarter of
/// it at least, and at most four times.
EllipticBody fitEllipticBody(const std::vector<PlaneLine>& lines, double field);

}  // namespace raysweep
