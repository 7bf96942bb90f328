/// What a real detector makes of line integrals.
#pragma once

#include "raysweep/camera/projections.h"

#include <cstdint>

namespace raysweep {

struct DetectorModel {
    double photons = 0;     ///< counted in a pixel without object; Poisson noise follows from it. 0: no noise, >= 0
    double saturation = 0;  ///< larger line integrals are measured as this; 0: none, >= 0
    int bits = 0;  ///< line integrals are rounded to 2^bits levels from 0 to the largest; 0: not, else in [1,24]
    std::uint32_t seed = 1;  ///< of the noise

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Applies noise, saturation and rounding, in that order. A pixel that counts no photon has the line integral of half
/// of one. The same numbers for any number of threads. @throw InvalidArgument as DetectorModel::validate.
void detect(Projections& projections, const DetectorModel& model);

}  // namespace raysweep
