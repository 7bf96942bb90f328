#include "cube4/fixed_point.h"

#include "raysweep/core/require.h"

namespace raysweep::cube4 {

void NumberFormat::validate() const {
    const auto within = [](int bits, int least, int most) { return bits >= least && bits <= most; };
    requireField(within(scalar, 4, 24), "scalar", scalar, "4 to 24 bits");
    requireField(within(energy, 4, 31), "energy", energy, "4 to 31 bits");
    requireField(within(part, 4, 24), "part", part, "4 to 24 bits");
    requireField(within(weight, 4, 24), "weight", weight, "4 to 24 bits");
    requireField(within(sum, 4, 48), "sum", sum, "4 to 48 bits");
}

}  // namespace raysweep::cube4
