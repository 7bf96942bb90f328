#include "raysweep/sweep/directions.h"

#include "raysweep/sweep/axis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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

DirectionSequence::DirectionSequence(const Options& options, std::function<int(const Vec3&)> classOf)
    : options_(options), classOf_(std::move(classOf)), random_(options.seed) {
    if (options.set != DirectionSet::fibonacci) batch_ = left_ = std::numeric_limits<int>::max();
}

/// An estimate is good when a batch is complete: if it is known how many directions there will be, as many halvings of
/// that as lead about there.
std::size_t DirectionSequence::firstBatch() const {
    double size = options_.total > 0 ? options_.total : options_.batch;
    while (size > 1.5 * options_.batch) size /= 2;
    return std::size_t(std::ceil(size));
}

/// As large as all before; the last one takes what would be left for one of less than half its size.
std::size_t DirectionSequence::nextBatch() const {
    const std::size_t first = firstBatch(), total = std::size_t(options_.total);
    const std::size_t size = drawn_ == 0 ? first : std::min(drawn_, std::max(first, kLargestBatch));
    if (drawn_ >= total || drawn_ + size + size / 2 < total) return size;
    return total - drawn_;
}

void DirectionSequence::refill() {
    const Matrix3 rotation = randomRotation(random_);
    const std::size_t size = nextBatch();
    std::vector<Vec3> shuffled = sphericalFibonacci(int(size));
    drawn_ += size;
    batch_ = left_ = int(size);
    // Fisher-Yates by hand: std::shuffle is not the same on every platform.
    for (std::size_t i = shuffled.size() - 1; i > 0; --i)
        std::swap(shuffled[i], shuffled[std::size_t(uniform01(random_) * double(i + 1))]);
    const auto piecesOf = [](std::size_t all, std::size_t most) { return (all + most - 1) / most; };
    std::size_t left[kDirectionClasses] = {0}, groups[kDirectionClasses];
    for (Vec3& direction : shuffled) {
        direction = direction * rotation;
        ++left[classOf(direction)];
    }
    for (int c = 0; c < kDirectionClasses; ++c) groups[c] = piecesOf(left[c], std::size_t(options_.groupSize));
    // A class makes as few groups as it can, all of about one size. A group comes when it is full, so groups are in as
    // random an order as their members.
    std::vector<Vec3> open[kDirectionClasses];
    for (const Vec3& direction : shuffled) {
        const int c = classOf(direction);
        open[c].push_back(direction);
        if (open[c].size() < piecesOf(left[c], groups[c])) continue;
        left[c] -= open[c].size();
        --groups[c];
        groups_.push_back(std::exchange(open[c], {}));
    }
}

int DirectionSequence::classOf(const Vec3& direction) const {
    return options_.groupSize > 1 ? classOf_(direction) : 0;
}

Vec3 DirectionSequence::nextOfRecurrence() {
    // Roberts 2018: the plastic number's powers give the most even plane recurrence.
    constexpr double kA = 0.7548776662466927, kB = 0.5698402909980532;
    ++step_;
    return onSphere(1 - 2 * fraction(0.5 + kA * double(step_)), 2 * kPi * fraction(0.5 + kB * double(step_)));
}

std::vector<Vec3> DirectionSequence::nextGroup(int most) {
    if (options_.set == DirectionSet::random) {
        const double z = 1 - 2 * uniform01(random_);
        return {onSphere(z, 2 * kPi * uniform01(random_))};
    }
    if (options_.set == DirectionSet::lowDiscrepancy) return {nextOfRecurrence()};
    if (groups_.empty()) refill();
    std::vector<Vec3>& first = groups_.front();
    const std::size_t count = std::min(first.size(), std::size_t(most));
    const std::vector<Vec3> group(first.begin(), first.begin() + std::ptrdiff_t(count));
    first.erase(first.begin(), first.begin() + std::ptrdiff_t(count));
    if (first.empty()) groups_.pop_front();
    left_ -= int(count);
    return group;
}

}  // namespace raysweep
