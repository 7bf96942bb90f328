// Four floats side by side, as voxels and rays of composite.h have them: one vector wherever there are vectors.
// Included once for each instruction set.
#if defined(RAYSWEEP_FOUR_FLOATS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_FOUR_FLOATS_INL_H
#undef RAYSWEEP_FOUR_FLOATS_INL_H
#else
#define RAYSWEEP_FOUR_FLOATS_INL_H
#endif

#include <hwy/highway.h>

#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

struct Four {
    float lane[4];
};

template <class Operation>
HWY_INLINE Four eachLane(const Operation& operation) {
    Four all;
    for (int i = 0; i < 4; ++i) all.lane[i] = operation(i);
    return all;
}

HWY_INLINE Four loadFour(const float* from) {
    return eachLane([&](int i) { return from[i]; });
}
HWY_INLINE void storeFour(Four a, float* to) {
    for (int i = 0; i < 4; ++i) to[i] = a.lane[i];
}
HWY_INLINE Four setFour(float value) {
    return eachLane([&](int) { return value; });
}
HWY_INLINE Four operator+(Four a, Four b) {
    return eachLane([&](int i) { return a.lane[i] + b.lane[i]; });
}
HWY_INLINE Four operator-(Four a, Four b) {
    return eachLane([&](int i) { return a.lane[i] - b.lane[i]; });
}
HWY_INLINE Four operator*(Four a, Four b) {
    return eachLane([&](int i) { return a.lane[i] * b.lane[i]; });
}
HWY_INLINE Four operator/(Four a, Four b) {
    return eachLane([&](int i) { return a.lane[i] / b.lane[i]; });
}
/// a b + c
HWY_INLINE Four mulAdd(Four a, Four b, Four c) {
    return a * b + c;
}
HWY_INLINE Four mulSub(Four a, Four b, Four c) {
    return a * b - c;
}
HWY_INLINE Four leastOf(Four a, Four b) {
    return eachLane([&](int i) { return a.lane[i] < b.lane[i] ? a.lane[i] : b.lane[i]; });
}
HWY_INLINE Four mostOf(Four a, Four b) {
    return eachLane([&](int i) { return a.lane[i] > b.lane[i] ? a.lane[i] : b.lane[i]; });
}
HWY_INLINE Four rootOf(Four a) {
    return eachLane([&](int i) { return std::sqrt(a.lane[i]); });
}
HWY_INLINE float sumOf(Four a) {
    return (a.lane[0] + a.lane[2]) + (a.lane[1] + a.lane[3]);
}
/// The first lane of a, the others of b.
HWY_INLINE Four firstOf(Four a, Four b) {
    return eachLane([&](int i) { return i == 0 ? a.lane[0] : b.lane[i]; });
}
HWY_INLINE bool isZero(Four a) {
    return a.lane[0] == 0 && a.lane[1] == 0 && a.lane[2] == 0 && a.lane[3] == 0;
}

#else

constexpr hn::FixedTag<float, 4> kFour;

/// What `hn::Vec` is, with operators: those of the vectors themselves, if they have them, are not used.
struct Four {
    hn::Vec<decltype(kFour)> v;
};

HWY_INLINE Four loadFour(const float* from) {
    return {hn::Load(kFour, from)};
}
HWY_INLINE void storeFour(Four a, float* to) {
    hn::Store(a.v, kFour, to);
}
HWY_INLINE Four setFour(float value) {
    return {hn::Set(kFour, value)};
}
HWY_INLINE Four operator+(Four a, Four b) {
    return {hn::Add(a.v, b.v)};
}
HWY_INLINE Four operator-(Four a, Four b) {
    return {hn::Sub(a.v, b.v)};
}
HWY_INLINE Four operator*(Four a, Four b) {
    return {hn::Mul(a.v, b.v)};
}
HWY_INLINE Four operator/(Four a, Four b) {
    return {hn::Div(a.v, b.v)};
}
/// a b + c
HWY_INLINE Four mulAdd(Four a, Four b, Four c) {
    return {hn::MulAdd(a.v, b.v, c.v)};
}
HWY_INLINE Four mulSub(Four a, Four b, Four c) {
    return {hn::MulSub(a.v, b.v, c.v)};
}
HWY_INLINE Four leastOf(Four a, Four b) {
    return {hn::Min(a.v, b.v)};
}
HWY_INLINE Four mostOf(Four a, Four b) {
    return {hn::Max(a.v, b.v)};
}
HWY_INLINE Four rootOf(Four a) {
    return {hn::Sqrt(a.v)};
}
HWY_INLINE float sumOf(Four a) {
    return hn::GetLane(hn::SumOfLanes(kFour, a.v));
}
/// The first lane of a, the others of b.
HWY_INLINE Four firstOf(Four a, Four b) {
    return {hn::IfThenElse(hn::FirstN(kFour, 1), a.v, b.v)};
}
HWY_INLINE bool isZero(Four a) {
    return hn::AllTrue(kFour, hn::Eq(a.v, hn::Zero(kFour)));
}

#endif

// Two of them one after the other, as neighbours in memory are.
#if HWY_TARGET != HWY_SCALAR && HWY_MAX_BYTES >= 32

constexpr hn::FixedTag<float, 8> kEight;

struct Eight {
    hn::Vec<decltype(kEight)> v;
};

HWY_INLINE Eight loadEight(const float* from) {
    return {hn::LoadU(kEight, from)};
}
HWY_INLINE void storeEight(Eight a, float* to) {
    hn::StoreU(a.v, kEight, to);
}
HWY_INLINE Eight setEight(float value) {
    return {hn::Set(kEight, value)};
}
HWY_INLINE Eight together(Four low, Four high) {
    return {hn::Combine(kEight, high.v, low.v)};
}
HWY_INLINE Four lowOf(Eight a) {
    return {hn::LowerHalf(kFour, a.v)};
}
HWY_INLINE Four highOf(Eight a) {
    return {hn::UpperHalf(kFour, a.v)};
}
HWY_INLINE Eight operator+(Eight a, Eight b) {
    return {hn::Add(a.v, b.v)};
}
HWY_INLINE Eight operator-(Eight a, Eight b) {
    return {hn::Sub(a.v, b.v)};
}
HWY_INLINE Eight operator*(Eight a, Eight b) {
    return {hn::Mul(a.v, b.v)};
}
HWY_INLINE Eight mulAdd(Eight a, Eight b, Eight c) {
    return {hn::MulAdd(a.v, b.v, c.v)};
}

#else

struct Eight {
    Four low, high;
};

HWY_INLINE Eight loadEight(const float* from) {
    return {loadFour(from), loadFour(from + 4)};
}
HWY_INLINE void storeEight(Eight a, float* to) {
    storeFour(a.low, to);
    storeFour(a.high, to + 4);
}
HWY_INLINE Eight setEight(float value) {
    return {setFour(value), setFour(value)};
}
HWY_INLINE Eight together(Four low, Four high) {
    return {low, high};
}
HWY_INLINE Four lowOf(Eight a) {
    return a.low;
}
HWY_INLINE Four highOf(Eight a) {
    return a.high;
}
HWY_INLINE Eight operator+(Eight a, Eight b) {
    return {a.low + b.low, a.high + b.high};
}
HWY_INLINE Eight operator-(Eight a, Eight b) {
    return {a.low - b.low, a.high - b.high};
}
HWY_INLINE Eight operator*(Eight a, Eight b) {
    return {a.low * b.low, a.high * b.high};
}
HWY_INLINE Eight mulAdd(Eight a, Eight b, Eight c) {
    return {mulAdd(a.low, b.low, c.low), mulAdd(a.high, b.high, c.high)};
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif  // include guard
