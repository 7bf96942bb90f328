#include "raysweep/image/compare.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace raysweep {
namespace {

constexpr int kMaxRadius = 5;  // 11 x 11 pixels
constexpr double kSigma = 1.5;

std::string shape(const Image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height) + "x" + std::to_string(image.channels);
}

void requireComparable(const Image& image, const Image& reference, double peak) {
    if (image.width != reference.width || image.height != reference.height || image.channels != reference.channels)
        throw InvalidArgument("cannot compare images of different shapes (width x height x channels): " + shape(image) +
                              " and " + shape(reference));
    if (image.pixels.empty() || image.pixels.size() != reference.pixels.size())
        throw InvalidArgument("cannot compare empty images");
    if (!(peak > 0 && std::isfinite(peak))) throw InvalidArgument("peak must be positive and finite");
}

/// Normalised weights for offsets -radius to radius.
std::vector<double> gaussian(int radius) {
    std::vector<double> weights(2 * radius + 1);
    double sum = 0;
    for (int i = -radius; i <= radius; ++i) sum += weights[i + radius] = std::exp(-0.5 * i * i / (kSigma * kSigma));
    for (double& weight : weights) weight /= sum;
    return weights;
}

struct Moments {
    double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    void add(double weight, const Moments& m) {
        a += weight * m.a, b += weight * m.b;
        aa += weight * m.aa, bb += weight * m.bb, ab += weight * m.ab;
    }
};

double similarity(const Moments& m, double peak) {
    const double c1 = 0.01 * 0.01 * peak * peak, c2 = 0.03 * 0.03 * peak * peak;
    const double varianceA = m.aa - m.a * m.a, varianceB = m.bb - m.b * m.b, covariance = m.ab - m.a * m.b;
    return (2 * m.a * m.b + c1) * (2 * covariance + c2) / ((m.a * m.a + m.b * m.b + c1) * (varianceA + varianceB + c2));
}

/// Sum of the similarity over one row of windows: moments are weighted down the columns first, then along the row.
double rowSimilarity(const Image& image, const Image& reference, int y, const std::vector<double>& weights,
                     double peak) {
    const int radius = int(weights.size()) / 2, stride = image.channels;
    std::vector<Moments> columns(std::size_t(image.width) * stride);
    for (int dy = -radius; dy <= radius; ++dy) {
        const float *rowA = image.at(0, y + dy), *rowB = reference.at(0, y + dy);
        for (std::size_t i = 0; i < columns.size(); ++i) {
            const double a = rowA[i], b = rowB[i];
            columns[i].add(weights[dy + radius], {a, b, a * a, b * b, a * b});
        }
    }
    double sum = 0;
    for (int i = radius * stride; i < (image.width - radius) * stride; ++i) {
        Moments window;
        for (int dx = -radius; dx <= radius; ++dx) window.add(weights[dx + radius], columns[i + dx * stride]);
        sum += similarity(window, peak);
    }
    return sum;
}

double meanSimilarity(const Image& image, const Image& reference, double peak) {
    const int radius = std::min(kMaxRadius, (std::min(image.width, image.height) - 1) / 2);
    const std::vector<double> weights = gaussian(radius);
    const std::size_t rows = image.height - 2 * radius;
    const double sum = orderedSum(
        rows, [&](std::size_t row) { return rowSimilarity(image, reference, int(row) + radius, weights, peak); }, 1);
    return sum / (double(rows) * (image.width - 2 * radius) * image.channels);
}

Image channelsOf(const Image& image, int first, int count) {
    Image part(image.width, image.height, count);
    for (std::size_t p = 0, from = std::size_t(first); p < part.pixels.size(); p += std::size_t(count)) {
        std::copy_n(image.pixels.begin() + std::ptrdiff_t(from), count, part.pixels.begin() + std::ptrdiff_t(p));
        from += std::size_t(image.channels);
    }
    return part;
}

}  // namespace

ImageDifference compareImages(const Image& image, const Image& reference, double peak) {
    requireComparable(image, reference, peak);
    const std::size_t count = image.pixels.size();
    const auto square = [](double x) { return x * x; };
    const auto difference = [&](std::size_t i) { return double(image.pixels[i]) - reference.pixels[i]; };
    ImageDifference result;
    result.rmse = std::sqrt(orderedSum(
                                count, [&](std::size_t i) { return square(difference(i)); }, 4096) /
                            count);
    const double norm = std::sqrt(orderedSum(
                                      count, [&](std::size_t i) { return square(reference.pixels[i]); }, 4096) /
                                  count);
    result.relativeRmse = result.rmse == 0 ? 0 : result.rmse / norm;
    result.psnr = result.rmse == 0 ? std::numeric_limits<double>::infinity() : 20 * std::log10(peak / result.rmse);
    result.ssim = meanSimilarity(image, reference, peak);
    for (std::size_t i = 0; i < count; ++i) {
        const double d = std::abs(difference(i));
        if (!(d <= result.maxDifference)) result.maxDifference = d;
        if (std::isnan(d)) break;
    }
    if (std::isnan(result.maxDifference)) result.ssim = result.maxDifference;
    return result;
}

PictureDifference comparePictures(const Image& image, const Image& reference, double peak) {
    const auto hasAlpha = [](const Image& picture) { return picture.channels == 2 || picture.channels == 4; };
    PictureDifference result;
    if (!hasAlpha(image) && !hasAlpha(reference)) {
        result.color = compareImages(image, reference, peak);
        return result;
    }
    const auto colors = [&](const Image& picture) {
        return channelsOf(picture, 0, picture.channels - (hasAlpha(picture) ? 1 : 0));
    };
    const auto alpha = [&](const Image& picture) {
        if (hasAlpha(picture)) return channelsOf(picture, picture.channels - 1, 1);
        Image opaque(picture.width, picture.height, 1);
        std::fill(opaque.pixels.begin(), opaque.pixels.end(), 1.0f);
        return opaque;
    };
    result.color = compareImages(colors(image), colors(reference), peak);
    result.alpha = compareImages(alpha(image), alpha(reference), peak);
    return result;
}

double psnr(const Image& image, const Image& reference, double peak) {
    return compareImages(image, reference, peak).psnr;
}

double ssim(const Image& image, const Image& reference, double peak) {
    return compareImages(image, reference, peak).ssim;
}

}  // namespace raysweep
