/// Floating point: the reference that formats of fixed width (fixed_point.h) are compared with.
#pragma once

#include "cube4/words.h"

#include <algorithm>
#include <cstdint>

namespace raysweep::cube4 {

struct FloatArithmetic {
    using Word = float;
    using Weight = float;

    static constexpr bool kExact = true;  ///< words are real numbers: no tables, no widths

    Weight weight(double part) const { return float(part); }
    /// Interpolates values that may be of either sign.
    Word mix(const Between<Weight>& weights, Word low, Word high) const {
        return weights.low * low + weights.high * high;
    }
    /// The part of a power.
    Word partOf(Word power, Word part) const { return power * part; }
    Word add(Word a, Word b) const { return a + b; }
    Word accumulate(Word sum, Word more) const { return sum + more; }
    Word subtract(Word a, Word b) const { return a - b; }
    /// x + λ value / weight, within [low, high].
    Word corrected(Word x, const Ray<Word>& mean, const Ray<Word>& bounds, Word relaxation) const {
        return std::clamp(x + relaxation * (mean.value / mean.weight), bounds.value, bounds.weight);
    }
    Word one() const { return 1; }
    std::uint64_t takeSaturations() const { return 0; }
    /// The word of a value; units are for integers.
    static Word word(double value, double /*unit*/) { return Word(value); }
    Word partWord(double part) const { return Word(part); }
};

}  // namespace raysweep::cube4
