/// The largest of many values, of which none may be passed over.
#pragma once

#include <cmath>

namespace raysweep::test {

/// Raises `worst` to `x` if that is larger. Unlike with std::max a NaN stays, so that comparisons with a limit fail.
template <class Value>
void raiseTo(Value& worst, Value x) {
    if (!std::isnan(worst) && !(x <= worst)) worst = x;
}

}  // namespace raysweep::test
