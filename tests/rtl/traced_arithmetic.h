/// FixedPoint that tells which random words it rounded with, so that hardware can be given the same.
#pragma once

#include "cube4/fixed_point.h"

#include <utility>
#include <vector>

namespace raysweep::test {

class TracedArithmetic {
  public:
    using Word = cube4::FixedPoint::Word;
    using Weight = cube4::FixedPoint::Weight;

    static constexpr bool kExact = false;

    explicit TracedArithmetic(const cube4::NumberFormat& format)
        : exact_(format), random_(format.seed * 2654435769u | 1u) {}

    Word mix(const cube4::Between<Weight>& weights, Word low, Word high) const {
        note();
        return exact_.mix(weights, low, high);
    }
    Word partOf(Word power, Word part) const {
        note();
        return exact_.partOf(power, part);
    }
    Word add(Word a, Word b) const { return exact_.add(a, b); }
    Word accumulate(Word sum, Word more) const { return exact_.accumulate(sum, more); }
    Word subtract(Word a, Word b) const { return exact_.subtract(a, b); }
    Word corrected(Word x, const cube4::Ray<Word>& mean, const cube4::Ray<Word>& bounds, Word relaxation) const {
        note();
        return exact_.corrected(x, mean, bounds, relaxation);
    }

    Word partWord(double part) const { return exact_.partWord(part); }

    /// The words since the last call, in the order in which they were used.
    std::vector<std::uint32_t> taken() const { return std::exchange(words_, {}); }

  private:
    /// Draws what `exact_` will: one word for each rounding.
    void note() const {
        if (exact_.format().rounding != cube4::Rounding::stochastic) return;
        random_ ^= random_ << 13;
        random_ ^= random_ >> 17;
        random_ ^= random_ << 5;
        words_.push_back(random_);
    }

    cube4::FixedPoint exact_;
    mutable std::uint32_t random_;
    mutable std::vector<std::uint32_t> words_;
};

}  // namespace raysweep::test
