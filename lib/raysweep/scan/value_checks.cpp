#include "raysweep/scan/value_checks.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace raysweep {
namespace {

/// Values that are looked at: more do not change a median.
constexpr std::size_t kAsked = std::size_t(1) << 20;

/// Some of the values that were measured, evenly spread.
std::vector<float> sampleOf(const Projections& projections) {
    const std::size_t count = projections.values.size();
    std::size_t step = std::max<std::size_t>(1, count / kAsked);
    while (std::gcd(step, std::size_t(projections.width)) > 1 && step > 1) ++step;  // so that all columns have a say
    std::vector<float> sample;
    for (std::size_t p = 0; p < count; p += step)
        if (!std::isnan(projections.values[p])) sample.push_back(projections.values[p]);
    return sample;
}

/// The value that `part` of them are below; 0 without any.
float quantile(std::vector<float>& values, double part) {
    if (values.empty()) return 0;
    const auto at = values.begin() + std::ptrdiff_t(part * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

/// Standard deviation of the noise, from what neighbours in a row differ by.
double noiseOf(const Projections& projections) {
    std::vector<float> differences;
    const std::size_t width = std::size_t(projections.width), rows = projections.values.size() / width;
    const std::size_t step = std::max<std::size_t>(1, projections.values.size() / kAsked);
    for (std::size_t y = 0; y < rows; y += step)
        for (std::size_t x = 1; x < width; ++x) {
            const float* value = projections.values.data() + y * width + x;
            const float difference = std::abs(value[0] - value[-1]);
            if (!std::isnan(difference)) differences.push_back(difference);
        }
    return quantile(differences, 0.5) / (0.6745 * std::sqrt(2.0));
}

/// What the outermost columns of each view measure on average, and what those between them do.
struct Sides {
    std::vector<double> outer, inner;  ///< for each view
    int columns = 0;                   ///< on either side
};

double meanOf(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / double(values.size());
}

/// Sum of what was measured, and how many pixels it is of.
struct Sum {
    double sum = 0, count = 0;
    void add(const float* first, const float* last) {
        for (; first != last; ++first)
            if (!std::isnan(*first)) sum += *first, ++count;
    }
};

Sides sidesOf(const Projections& projections) {
    Sides sides;
    sides.columns = std::max(1, projections.width / 50);
    const int width = projections.width, side = std::min(sides.columns, width / 2);
    std::vector<Sum> outer(std::size_t(projections.views)), inner(outer.size());
    parallelFor(outer.size(), [&](std::size_t n) {
        for (int y = 0; y < projections.height; ++y) {
            const float* row = projections.view(int(n)) + std::size_t(y) * std::size_t(width);
            outer[n].add(row, row + side);
            inner[n].add(row + side, row + width - side);
            outer[n].add(row + width - side, row + width);
        }
    });
    for (std::size_t n = 0; n < outer.size(); ++n) {
        if (outer[n].count == 0 || inner[n].count == 0) continue;
        sides.outer.push_back(outer[n].sum / outer[n].count);
        sides.inner.push_back(inner[n].sum / inner[n].count);
    }
    return sides;
}

/// True if the sides are evenly bright in all views, and brighter than what is between them, as air beside an object.
bool areBright(const Sides& sides) {
    constexpr double kEven = 0.1, kBrighter = 1.02;  // relative
    if (sides.outer.empty()) return false;
    const auto [least, most] = std::minmax_element(sides.outer.begin(), sides.outer.end());
    return *least > 0 && *most - *least < kEven * *most && meanOf(sides.outer) > kBrighter * meanOf(sides.inner);
}

}  // namespace

std::size_t markImplausible(Projections& projections) {
    constexpr float kNever = 1e30f;
    constexpr double kLarge = 1000, kTimes = 100, kManyTimes = 1e6;
    std::vector<float> sizes;
    for (const float value : sampleOf(projections))
        if (value != 0 && std::abs(value) < kNever) sizes.push_back(std::abs(value));
    const double usual = quantile(sizes, 0.5), largest = quantile(sizes, 0.98);
    const double limit =
        usual > 0 ? std::min({std::max(kLarge, kTimes * largest), kManyTimes * usual, double(kNever)}) : kNever;
    std::size_t found = 0;
    for (float& value : projections.values) {
        if (!(std::abs(value) > limit)) continue;
        value = std::numeric_limits<float>::quiet_NaN();
        ++found;
    }
    return found;
}

std::vector<std::string> doubtsAbout(const Projections& projections, bool corrected) {
    std::vector<std::string> doubts;
    const Sides sides = projections.width >= 8 && !corrected ? sidesOf(projections) : Sides();
    if (areBright(sides))
        doubts.push_back("the values are " + brief(meanOf(sides.outer), 3) + " at the detector's sides, and " +
                         brief(meanOf(sides.inner), 3) + " between them, as " +
                         (meanOf(sides.outer) < 2 ? "transmissions" : "counts") +
                         " are, but are taken for line integrals; if they are none, say with `flat` what is measured " +
                         "without object");
    constexpr double kPart = 0.05, kNoise = 5, kShare = 1e-3;  // of the largest, of the deviation, of all values
    std::vector<float> sample = sampleOf(projections);
    const double bound = -std::max(kPart * quantile(sample, 0.98), kNoise * noiseOf(projections));
    const auto below = std::count_if(sample.begin(), sample.end(), [&](float value) { return value < bound; });
    if (bound < 0 && double(below) > kShare * double(sample.size()))
        doubts.push_back(brief(100 * double(below) / double(sample.size())) + " % of the line integrals are below " +
                         brief(bound) + ", more than noise makes them, down to " +
                         brief(*std::min_element(sample.begin(), sample.end()), 3) +
                         ": was more counted with the object than without?");
    return doubts;
}

std::vector<float> flatFromSides(const Projections& counts) {
    const Sides sides = sidesOf(counts);
    if (!areBright(sides))
        throw InvalidArgument(
            "flat: what is counted without object cannot be estimated: the detector's sides are not evenly brighter "
            "than what is between them, so the object may be there; give frames, or a number");
    std::vector<float> flat(counts.pixelsPerView());
    const std::size_t width = std::size_t(counts.width), side = std::size_t(sides.columns);
    for (std::size_t y = 0; y < std::size_t(counts.height); ++y) {
        double sum = 0, measured = 0;
        for (int n = 0; n < counts.views; ++n)
            for (std::size_t x = 0; x < width; ++x) {
                const float value = counts.view(n)[y * width + x];
                if ((x >= side && x < width - side) || std::isnan(value)) continue;
                sum += value;
                ++measured;
            }
        std::fill_n(flat.begin() + std::ptrdiff_t(y * width), width, float(sum / measured));
    }
    return flat;
}

std::optional<double> exposureLimit(const Projections& counts, SampleType type, const std::vector<float>& flat) {
    if (isFloatingPoint(type)) return {};
    const float most = largestValue(counts);
    const auto isLimit = [&](int bits) { return most == float((1 << bits) - 1); };
    const bool ofType = sizeOf(type) <= 2 && double(most) == highestOf(type);
    if (!ofType && !isLimit(8) && !isLimit(10) && !isLimit(12) && !isLimit(14) && !isLimit(16)) return {};
    const auto there = std::size_t(std::count(counts.values.begin(), counts.values.end(), most));
    if (!ofType && there < std::max<std::size_t>(3, counts.values.size() / 100000)) return {};
    constexpr double kSame = 0.005;  // relative
    const auto same = std::count_if(flat.begin(), flat.end(), [&](float f) { return std::abs(f / most - 1) < kSame; });
    if (2 * std::size_t(same) > flat.size()) return {};
    return double(most);
}

}  // namespace raysweep
