/// How much of the light from each point of a ray reaches the eye, as the march through the smoke has found it.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace raysweep {

/// Constant extinction in each step, none between steps. Distances are from the eye, in any one unit.
class TransmittanceAlongRay {
  public:
    void clear() {
        steps_.clear();
        next_ = 0;
        after_ = 1;
    }

    /// The next step, of the opacity `opacity` > 0, where `before` of the light from its beginning reaches the eye.
    void add(double begin, double end, double before, double opacity) {
        steps_.push_back({begin, end, before, std::fmin(-std::log1p(-opacity), kDark)});
        after_ = before * (1 - opacity);
    }

    /// Nothing is seen of what is behind the last step.
    void endInTheDark() { after_ = 0; }

    /// Integral of the transmittance from `from` to `to`; each call begins where the one before did, or later.
    double integral(double from, double to) {
        double sum = 0;
        while (from < to) {
            while (next_ < steps_.size() && steps_[next_].end <= from) ++next_;
            if (next_ == steps_.size()) return sum + after_ * (to - from);
            const Step& step = steps_[next_];
            const bool inside = from >= step.begin;
            const double until = std::fmin(to, inside ? step.end : step.begin);
            sum += inside ? through(step, from, until) : step.before * (until - from);
            if (!(until > from)) break;  // rounding
            from = until;
        }
        return sum;
    }

  private:
    struct Step {
        double begin, end, before, depth;  ///< depth: optical, of all of it
    };

    static double through(const Step& step, double from, double to) {
        const double perLength = step.depth / (step.end - step.begin), depth = perLength * (to - from);
        return step.before * std::exp(-perLength * (from - step.begin)) * meanAlong(depth) * (to - from);
    }

    /// Mean of exp(-t) for t from 0 to `depth`.
    static double meanAlong(double depth) {
        constexpr double kThin = 1e-3;  // where the next term is below a float's rounding
        return depth < kThin ? 1 - depth / 2 + depth * depth / 6 : -std::expm1(-depth) / depth;
    }

    /// Optical depth behind which nothing is seen. An opacity of 1, which is any above 17 in floats, tells none.
    static constexpr double kDark = 700;
    std::vector<Step> steps_;
    std::size_t next_ = 0;
    double after_ = 1;
};

}  // namespace raysweep
