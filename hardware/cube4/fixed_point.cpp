#include "cube4/fixed_point.h"

#include "raysweep/core/error.h"
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

void NumberFormat::requireSumsHold(double largest, const std::string& what) const {
    const double most = std::ldexp(1.0, sum) - 1;
    if (largest <= most) return;
    throw InvalidArgument("sum words of " + std::to_string(sum) + " bits hold " + std::to_string(std::int64_t(most)) +
                          " units, and " + what + " reach " + std::to_string(largest / most) +
                          " times as much: " + std::to_string(int(std::ceil(std::log2(largest + 1)))) + " bits do");
}

}  // namespace raysweep::cube4
