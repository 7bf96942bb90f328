#include "raysweep/sweep/escape.h"

#include "raysweep/core/error.h"
#include "raysweep/sweep/axis.h"
#include "raysweep/sweep/directions.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace raysweep {
namespace {

constexpr int kDirections = 16384;
constexpr int kQuantiles = 256;
double escapeAlong(double t) {
    constexpr double kOpaque = 40;  // from here on 1 - exp(-t) is 1
    return t > kOpaque ? 1 / t : t > 0 ? -std::expm1(-t) / t : 1;
}

/// Solves A x = y for a symmetric positive definite matrix (Cholesky); n is at most 9.
std::vector<double> solveNormalEquations(std::vector<std::vector<double>> A, std::vector<double> y) {
    const std::size_t n = y.size();
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = A[i][j];
            for (std::size_t k = 0; k < j; ++k) sum -= A[i][k] * A[j][k];
            A[i][j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / A[j][j];
        }
        for (std::size_t k = 0; k < i; ++k) y[i] -= A[i][k] * y[k];
        y[i] /= A[i][i];
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) y[i] -= A[k][i] * y[k];
        y[i] /= A[i][i];
    }
    return y;
}

struct Sample {
    double t, p, weight;
};

/// One weighted least-squares step for numerator(t) - p denominator(t) = 0 with a numerator of degree n and a
/// denominator of degree n + 1. Tied: a1 = b1 + 1/2 (slope of p at 0) and a_{n+1} = b_n / <1/l> (p t at infinity).
EscapeFit fitOnce(const std::vector<Sample>& samples, int n, double meanInverse) {
    const std::size_t unknowns = std::size_t(2 * n - 1);  // b1..bn, a2..an
    std::vector<std::vector<double>> A(unknowns, std::vector<double>(unknowns, 0.0));
    std::vector<double> y(unknowns, 0.0), row(unknowns);
    for (const Sample& s : samples) {
        for (int k = 1; k <= n; ++k) {
            double value = std::pow(s.t, k);
            if (k == 1) value -= s.p * s.t;
            if (k == n) value -= s.p * std::pow(s.t, n + 1) / meanInverse;
            row[std::size_t(k - 1)] = value * s.weight;
            if (k > 1) row[std::size_t(n + k - 2)] = -s.p * std::pow(s.t, k) * s.weight;
        }
        const double target = -(1 - s.p * (1 + 0.5 * s.t)) * s.weight;
        for (std::size_t i = 0; i < unknowns; ++i) {
            y[i] += row[i] * target;
            for (std::size_t j = 0; j < unknowns; ++j) A[i][j] += row[i] * row[j];
        }
    }
    const std::vector<double> x = solveNormalEquations(A, y);
    EscapeFit fit;
    for (int k = 0; k < n; ++k) fit.b[k] = float(x[std::size_t(k)]);
    fit.a[0] = float(x[0] + 0.5);
    for (int k = 1; k < n; ++k) fit.a[k] = float(x[std::size_t(n + k - 1)]);
    fit.a[n] = float(x[std::size_t(n - 1)] / meanInverse);
    return fit;
}

bool isUsable(const EscapeFit& fit) {
    return std::all_of(std::begin(fit.a), std::end(fit.a), [](float c) { return c >= 0; }) &&
           std::all_of(std::begin(fit.b), std::end(fit.b), [](float c) { return c >= 0; });
}

/// Fits by repeated least squares, each time weighted by the last denominator, which makes the error relative.
EscapeFit fitDegree(std::vector<Sample> samples, int degree, double meanInverse) {
    EscapeFit fit;
    for (Sample& s : samples) s.weight = 1 / (s.p * (1 + std::pow(s.t, degree + 1)));
    for (int pass = 0; pass < 12; ++pass) {
        fit = fitOnce(samples, degree, meanInverse);
        for (Sample& s : samples) s.weight = 1 / (s.p * EscapeFit::polynomial(fit.a, s.t));
    }
    for (const Sample& s : samples)
        fit.maxRelativeError = std::max(fit.maxRelativeError, std::abs(fit.probability(s.t) / s.p - 1));
    return fit;
}

}  // namespace

Escape::Escape(const Matrix3& worldFromIndex) {
    const Matrix3 indexFromWorld = worldFromIndex.inverse();
    std::vector<double> all;
    for (const Vec3& direction : sphericalFibonacci(kDirections)) {
        const Vec3 inIndex = direction * indexFromWorld;
        all.push_back(1 / std::abs(inIndex[majorAxis(inIndex)]));
    }
    std::sort(all.begin(), all.end());
    double sum = 0;
    for (const double length : all) sum += length;
    meanStepLength_ = sum / kDirections;
    for (int q = 0; q < kQuantiles; ++q) {
        constexpr int kEach = kDirections / kQuantiles;
        double part = 0;
        for (int i = q * kEach; i < (q + 1) * kEach; ++i) part += all[std::size_t(i)];
        lengths_.push_back(part / kEach / meanStepLength_);
    }
    for (const double l : lengths_) meanInverse_ += 1 / l / kQuantiles;

    std::vector<Sample> samples;
    for (double log = -3; log <= 4; log += 0.025) samples.push_back({std::pow(10, log), 0, 1});
    for (Sample& s : samples) s.p = probabilityByQuadrature(s.t);
    for (int degree = EscapeFit::kDegree; degree >= 2; --degree) {
        fit_ = fitDegree(samples, degree, meanInverse_);
        if (isUsable(fit_) && fit_.maxRelativeError < 0.01) return;
    }
    throw InvalidArgument(
        "voxels this elongated or sheared cannot be swept; resample the volume to nearly cubic voxels");
}

double Escape::probabilityByQuadrature(double t) const {
    double sum = 0;
    for (const double l : lengths_) sum += escapeAlong(t * l);
    return sum / double(lengths_.size());
}

Escape Escape::scaled(double factor) const {
    Escape result = *this;
    result.meanStepLength_ *= factor;
    return result;
}

}  // namespace raysweep
