#include "raysweep/sweep/directions.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

Vec3 onSphere(double z, double azimuth) {
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

constexpr std::size_t kLargestBatch = 1u << 16;  ///< of batches that have grown

double fraction(double x) {
    return x - std::floor(x);
}

}  // namespace

double uniform01(std::mt19937_64& random) {
    return double(random() >> 11) * 0x1.0p-53;
}

std::vector<Vec3> sphericalFibonacci(int count) {
    const double goldenAngle = kPi * (3 - std::sqrt(5.0));
    std::vector<Vec3> points;
    points.reserve(std::size_t(count));
    for (int i = 0; i < count; ++i) points.push_back(onSphere(1 - (2 * i + 1.0) / count, goldenAngle * i));
    return points;
}

Matrix3 randomRotation(std::mt19937_64& random) {
    const double u = uniform01(random), a = 2 * kPi * uniform01(random), b = 2 * kPi * uniform01(random);
    const double x = std::sqrt(1 - u) * std::sin(a), y = std::sqrt(1 - u) * std::cos(a);
    const double z = std::sqrt(u) * std::sin(b), w = std::sqrt(u) * std::cos(b);
    return {1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),
            2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
            2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y)};
}

DirectionSequence::DirectionSequence(DirectionSet set, int batch, std::uint64_t seed)
    : set_(set), batch_(std::size_t(batch)), random_(seed) {}

void DirectionSequence::refill() {
    const Matrix3 rotation = randomRotation(random_);
    const std::size_t size = drawn_ == 0 ? batch_ : std::min(drawn_, std::max(batch_, kLargestBatch));
    shuffled_ = sphericalFibonacci(int(size));
    drawn_ += size;
    for (Vec3& point : shuffled_) point = point * rotation;
    // Fisher-Yates by hand: std::shuffle is not the same on every platform.
    for (std::size_t i = shuffled_.size() - 1; i > 0; --i)
        std::swap(shuffled_[i], shuffled_[std::size_t(uniform01(random_) * double(i + 1))]);
    used_ = 0;
}

Vec3 DirectionSequence::next() {
    switch (set_) {
        case DirectionSet::random: {
            const double z = 1 - 2 * uniform01(random_);
            return onSphere(z, 2 * kPi * uniform01(random_));
        }
        case DirectionSet::lowDiscrepancy: {
            // Roberts 2018: the plastic number's powers give the most even plane recurrence.
            constexpr double kA = 0.7548776662466927, kB = 0.5698402909980532;
            ++step_;
            return onSphere(1 - 2 * fraction(0.5 + kA * double(step_)), 2 * kPi * fraction(0.5 + kB * double(step_)));
        }
        case DirectionSet::fibonacci:
            break;
    }
    if (shuffled_.empty() || used_ == shuffled_.size()) refill();
    return shuffled_[used_++];
}

}  // namespace raysweep
