/// Least squares in a few unknowns.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace raysweep {

template <std::size_t kUnknowns>
struct NormalEquations {
    using Vector = std::array<double, kUnknowns>;
    std::array<Vector, kUnknowns> matrix{};  ///< only the lower triangle
    Vector right{};

    /// Adds the equation slopes . x = value.
    void add(const Vector& slopes, double value, double weight) {
        for (std::size_t a = 0; a < kUnknowns; ++a) {
            for (std::size_t b = 0; b <= a; ++b) matrix[a][b] += weight * slopes[a] * slopes[b];
            right[a] += weight * slopes[a] * value;
        }
    }

    void operator+=(const NormalEquations& other) {
        for (std::size_t a = 0; a < kUnknowns; ++a) {
            for (std::size_t b = 0; b <= a; ++b) matrix[a][b] += other.matrix[a][b];
            right[a] += other.right[a];
        }
    }

    /// By Cholesky's factors. @param damping of the diagonal, relative to it; unknowns that no equation has stay 0
    Vector solved(double damping) const {
        std::array<Vector, kUnknowns> lower{};
        Vector x{};
        for (std::size_t a = 0; a < kUnknowns; ++a) {
            for (std::size_t b = 0; b <= a; ++b) {
                double sum = matrix[a][b] * (a == b ? 1 + damping : 1);
                for (std::size_t c = 0; c < b; ++c) sum -= lower[a][c] * lower[b][c];
                if (a == b)
                    lower[a][a] = std::sqrt(sum > 0 ? sum : 0);
                else
                    lower[a][b] = lower[b][b] > 0 ? sum / lower[b][b] : 0;
            }
            double sum = right[a];
            for (std::size_t c = 0; c < a; ++c) sum -= lower[a][c] * x[c];
            x[a] = lower[a][a] > 0 ? sum / lower[a][a] : 0;
        }
        for (std::size_t a = kUnknowns; a-- > 0;) {
            for (std::size_t c = a + 1; c < kUnknowns; ++c) x[a] -= lower[c][a] * x[c];
            x[a] = lower[a][a] > 0 ? x[a] / lower[a][a] : 0;
        }
        return x;
    }
};

}  // namespace raysweep
