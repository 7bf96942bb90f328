/// Integers of given widths, as hardware computes: products are exact, and each is rounded once to the width it is kept
/// in.
#pragma once

#include "cube4/words.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

namespace raysweep::cube4 {

enum class Rounding {
    truncate,   ///< bits below the last are dropped: towards minus infinity, as an arithmetic shift does
    nearest,    ///< half is added before: to the nearest, halves up
    stochastic  ///< a random number below one unit is added before: right on average
};

/// Widths, bits. Powers of voxels, rays and sums have one unit; sums have more bits above it.
struct NumberFormat {
    int scalar = 16;  ///< extinction, by which tables are looked up, or the value that is reconstructed; [4,24]
    int energy = 16;  ///< unshot power, power of a ray; correction of a ray, with its sign; [4,31]
    int part = 12;    ///< fraction of opacities, of effective albedos and of what is shot; [4,24]
    int weight = 12;  ///< fraction of interpolation weights; [4,24]
    int sum = 40;     ///< deposits and line integrals as they are added up; [4,48]
    Rounding rounding = Rounding::nearest;
    std::uint32_t seed = 1;  ///< of `stochastic`

    /// @throw InvalidArgument naming the width and its bounds.
    void validate() const;
    /// @throw InvalidArgument if sums of up to `largest` units do not fit; `what`: of which, "deposits"
    void requireSumsHold(double largest, const std::string& what) const;
};

class FixedPoint {
  public:
    using Word = std::int64_t;
    using Weight = std::int64_t;

    static constexpr bool kExact = false;
    static constexpr int kRelaxationBits = 20;  ///< of λ that are kept, however the units of its factors differ

    explicit FixedPoint(const NumberFormat& format) : format_(format), random_(format.seed * 2654435769u | 1u) {}

    const NumberFormat& format() const { return format_; }
    /// Fraction bits of λ, in units of voxels over units of corrections: more where those are finer than voxels are.
    int relaxationBits() const {
        constexpr int kLeast = 8;
        return std::max(kLeast, kRelaxationBits + format_.energy - 1 - format_.scalar);
    }
    Weight weight(double part) const { return Weight(std::lround(std::ldexp(part, format_.weight))); }
    Word mix(const Between<Weight>& weights, Word low, Word high) const {
        return shifted(weights.low * low + weights.high * high, format_.weight);
    }
    Word partOf(Word power, Word part) const { return shifted(power * part, format_.part); }
    /// Of powers; saturates.
    Word add(Word a, Word b) const { return limited(a + b, largest(format_.energy)); }
    Word accumulate(Word sum, Word more) const { return limited(sum + more, largest(format_.sum)); }
    /// Sums that did not fit their words since the last call.
    std::uint64_t takeSaturations() const { return std::exchange(saturations_, 0); }
    Word subtract(Word a, Word b) const { return a - b; }
    Word corrected(Word x, const Ray<Word>& mean, const Ray<Word>& bounds, Word relaxation) const {
        // λ / weight, as a table for the weight gives it.
        const Word factor = ((relaxation << format_.weight) + mean.weight / 2) / mean.weight;
        return std::clamp(x + shifted(mean.value * factor, relaxationBits()), bounds.value, bounds.weight);
    }
    /// A part of 1.
    Word one() const { return Word(1) << format_.part; }
    static Word word(double value, double unit) { return std::llround(value / unit); }
    /// The word of a part, as a table gives it.
    Word partWord(double part) const { return word(part, std::ldexp(1.0, -format_.part)); }

    /// `value` / 2^bits, rounded.
    Word shifted(Word value, int bits) const {
        switch (format_.rounding) {
            case Rounding::truncate:
                return value >> bits;
            case Rounding::nearest:
                return (value + (Word(1) << (bits - 1))) >> bits;
            default:
                return (value + randomBelow(bits)) >> bits;
        }
    }

  private:
    static Word largest(int bits) { return (Word(1) << bits) - 1; }
    Word limited(Word value, Word most) const {
        if (value <= most) return value;
        ++saturations_;
        return most;
    }
    /// A number of so many bits; of more than 32 the highest are random.
    Word randomBelow(int bits) const {
        constexpr int kDrawn = 32;
        const Word random = nextRandom();
        return bits < kDrawn ? random & ((Word(1) << bits) - 1) : random << (bits - kDrawn);
    }
    /// Marsaglia's xorshift, 32 bits.
    std::uint32_t nextRandom() const {
        random_ ^= random_ << 13;
        random_ ^= random_ >> 17;
        random_ ^= random_ << 5;
        return random_;
    }

    NumberFormat format_;
    mutable std::uint32_t random_;
    mutable std::uint64_t saturations_ = 0;
};

}  // namespace raysweep::cube4
