#include "cube4/escape_table.h"

#include <algorithm>
#include <cmath>

namespace raysweep::cube4 {
namespace {

constexpr int kDirections = 1 << 17, kQuantiles = 512, kEntries = 1 << 15;
constexpr double kLeast = -16, kMost = 16;  ///< of the table, logarithm of σ len

/// Lengths of rays in voxels for directions that are spread evenly, sorted.
std::vector<double> sortedLengths(const Matrix3& worldFromIndex) {
    const Matrix3 inverse = worldFromIndex.inverse();
    const double golden = kPi * (3 - std::sqrt(5.0));
    std::vector<double> lengths;
    lengths.reserve(kDirections);
    for (int i = 0; i < kDirections; ++i) {
        const double z = (2 * i + 1.0) / kDirections - 1, r = std::sqrt(1 - z * z), phi = golden * i;
        const Vec3 index = Vec3(r * std::cos(phi), r * std::sin(phi), z) * inverse;
        lengths.push_back(1 / std::abs(index[majorAxis(index)]));
    }
    std::sort(lengths.begin(), lengths.end());
    return lengths;
}

}  // namespace

EscapeTable::EscapeTable(const Matrix3& worldFromIndex) {
    const std::vector<double> all = sortedLengths(worldFromIndex);
    constexpr int kEach = kDirections / kQuantiles;
    for (int q = 0; q < kQuantiles; ++q) {
        double sum = 0;
        for (int i = 0; i < kEach; ++i) sum += all[std::size_t(q * kEach + i)];
        lengths_.push_back(sum / kEach);
    }
    for (const double length : lengths_) {
        mean_ += length / kQuantiles;
        meanInverse_ += 1 / length / kQuantiles;
    }
    unit_ = lengths_[kQuantiles / 2];
    for (int entry = 0; entry <= kEntries; ++entry) {
        const double extinction = std::exp(kLeast + (kMost - kLeast) * entry / kEntries) / unit_;
        double sum = 0;
        for (const double length : lengths_) sum += -std::expm1(-extinction * length) / (extinction * length);
        table_.push_back(sum / kQuantiles);
    }
}

double EscapeTable::probability(double extinction) const {
    if (!(extinction > 0)) return 1;
    const double at = (std::log(extinction * unit_) - kLeast) / (kMost - kLeast) * kEntries;
    if (at <= 0) return 1;
    if (at >= kEntries) return table_.back() * std::exp(kMost) / (extinction * unit_);
    const auto below = std::size_t(at);
    return table_[below] + (at - double(below)) * (table_[below + 1] - table_[below]);
}

}  // namespace raysweep::cube4
