/// What a unit of the machine's words stands for when it reconstructs. Floats have units of 1.
#pragma once

#include "cube4/fixed_point.h"
#include "cube4/reconstruction.h"

#include "raysweep/core/error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace raysweep::cube4 {

template <class Arithmetic>
class ReconstructionUnits {
  public:
    using Word = typename Arithmetic::Word;

    /// @throw InvalidArgument if sums along rays do not fit their words
    ReconstructionUnits(const Arithmetic& arithmetic, const ReconstructionSetup& setup)
        : arithmetic_(arithmetic), setup_(setup) {
        if constexpr (!Arithmetic::kExact) {
            const NumberFormat& format = arithmetic.format();
            const int sign = setup.lower < 0 ? 1 : 0;
            value = setup.largestValue / (std::ldexp(1.0, format.scalar - sign) - 1);
            correction = setup.largestCorrection / (std::ldexp(1.0, format.energy - 1) - 1);
            weight = std::ldexp(1.0, -format.weight);
            format.requireSumsHold(setup.largestSums.value / value, "sums of voxels along a ray");
            format.requireSumsHold(setup.largestSums.weight / weight, "sums of weights along a ray");
        }
    }

    /// Saturates: a correction that is too large is made in several passes.
    Word correctionWord(double change) const {
        if constexpr (Arithmetic::kExact) return Word(change);
        return Arithmetic::word(std::clamp(change, -setup_.largestCorrection, setup_.largestCorrection), correction);
    }

    /// λ. @throw InvalidArgument if its product with a correction needs more than 63 bits
    Word relaxationWord(double relaxation) const {
        if constexpr (Arithmetic::kExact) {
            return Word(relaxation);
        } else {
            const NumberFormat& format = arithmetic_.format();
            const double word = std::ldexp(relaxation * correction / value, arithmetic_.relaxationBits());
            constexpr int kBits = 62;
            if (std::abs(word) >= std::ldexp(1.0, kBits - std::max(format.energy, format.weight)))
                throw InvalidArgument("corrections of up to " + std::to_string(setup_.largestCorrection) +
                                      " are too many times the voxels' largest value, " +
                                      std::to_string(setup_.largestValue) + ", for energy words of " +
                                      std::to_string(format.energy) + " bits: their products do not fit");
            return Word(std::llround(word));
        }
    }

    double value = 1;       ///< of a voxel, 1/world unit
    double correction = 1;  ///< of a ray, 1/world unit
    double weight = 1;      ///< of interpolation

  private:
    const Arithmetic& arithmetic_;
    const ReconstructionSetup& setup_;
};

}  // namespace raysweep::cube4
