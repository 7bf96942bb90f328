/// Redundancy weights: what a ray counts, so that each line of sight counts as one, whether a scan measures it once,
/// twice or more often (D. L. Parker, "Optimal short scan convolution reconstruction for fanbeam CT", Med. Phys. 9,
/// 1982; G. Wang, "X-ray micro-CT with a displaced detector array", Med. Phys. 29, 2002; the ratio is that of F. Noo,
/// M. Defrise, R. Clackdoyle and H. Kudo, "Image reconstruction from fan-beam projections on less than a short scan",
/// Phys. Med. Biol. 47, 2002, eq. 34):
///
///     w_n(β, q) = m_n(β, q) / (M(β, q) + M(β + π + 2 γ, -q)),   m_n = a(β) d_n(q)                              (9)
///
/// β: angle of the source; q: by how much the ray passes the axis: of a cone its angle γ with the source's line to the
/// axis, of parallel rays their distance from it; d_n: 1, and towards the edges of view n's detector a squared sine
/// down to 0; a: the same towards the ends of the scan; M: mean of m over the views near β, of which there may be
/// several at one angle. Where both sums have only one term w is 1 or 1/2; on a displaced detector it falls to 0 at the
/// near edge, without a step that the ramp filter would show. For parallel rays 2 γ is 0. If their detectors are not
/// displaced, views from opposite sides measure the same: they are neighbours, modulo half a turn, and there is no
/// second term.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/reconstruct/scan_angles.h"

#include <cstddef>
#include <vector>

namespace raysweep {

/// What a view's detector reaches: q from `low` to `high`, in the orbit's sense.
struct DetectorReach {
    double low = 0, high = 0;
};

/// True if it reaches about as far to both sides of the axis.
bool isCentred(const DetectorReach& reach);

class Redundancy {
  public:
    /// @param angles of the views' sources, radians, as OrbitFit::angles  @param reaches of each view
    Redundancy(BeamShape beam, const std::vector<double>& angles, const std::vector<DetectorReach>& reaches);

    const ScanAngles& scan() const { return scan_; }

    /// w of eq. 9 for a ray of view n, >= 0.
    double weight(std::size_t n, double q) const;

    /// True if some ray runs along the line that a source at `angle`, radians, sees at q.
    bool isMeasured(double angle, double q) const;

    /// Part of the lines of sight that pass the axis at q, of all directions, that no ray runs along, in [0,1].
    double missed(double q) const;

    /// The same of those only that detectors end before: views look that way.
    double cut(double q) const;

    /// The largest |q| of any ray.
    double furthest() const { return furthest_; }

  private:
    double taperAt(double angle) const;
    bool seesAt(double angle, double q) const;
    double windowOf(const ScanDirection& direction, double q) const;
    double windowAbout(std::size_t k, double q) const;
    double meanWindow(double angle, double q) const;

    bool cone_;
    bool folded_;  ///< angles count modulo half a turn
    double period_;
    ScanAngles scan_;
    std::vector<double> angles_;          ///< of each view: that of its direction
    std::vector<DetectorReach> reaches_;  ///< folded: as seen from the first half of the turn
    std::vector<bool> reversed_;          ///< folded: seen from the other half
    double furthest_ = 0;                 ///< largest |q|
};

}  // namespace raysweep
