#include "raysweep/reconstruct/photo_sheets.h"

#include "raysweep/core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raysweep {
namespace {

constexpr int kReach = 1;                ///< voxels, of the mean
constexpr double kSigma = 0.4;           ///< voxels, of its Gaussian weights
constexpr int kSlopes = 8 + 2 * kReach;  ///< along an edge: voxels whose gradients are needed
constexpr int kOpacities = kSlopes + 2;  ///< and opacities
constexpr std::array<int, 3> kStride = {kSlopes * kSlopes, kSlopes, 1};

using Tensor = std::array<float, 6>;  ///< xx, yy, zz, xy, xz, yz

std::array<float, 2 * kReach + 1> weights() {
    std::array<float, 2 * kReach + 1> w{};
    float sum = 0;
    for (int i = -kReach; i <= kReach; ++i) {
        w[std::size_t(i + kReach)] = float(std::exp(-0.5 * i * i / (kSigma * kSigma)));
        sum += w[std::size_t(i + kReach)];
    }
    for (float& value : w) value /= sum;
    return w;
}

/// A brick and what is around it.
class BrickSlopes {
  public:
    BrickSlopes(const CompositeLayout& layout, const std::vector<CompositeVoxel>& voxels, const Index3& origin)
        : opacities_(std::size_t(kOpacities) * kOpacities * kOpacities),
          gradients_(std::size_t(kSlopes) * kSlopes * kSlopes),
          tensors_(gradients_.size()) {
        constexpr int kFirst = -kReach - 1;
        std::size_t n = 0;
        for (int x = 0; x < kOpacities; ++x)
            for (int y = 0; y < kOpacities; ++y)
                for (int z = 0; z < kOpacities; ++z) {
                    const Index3 at = origin + Index3(x + kFirst, y + kFirst, z + kFirst);
                    opacities_[n++] = -std::expm1(-voxels[layout.voxel(at)].extinction);
                }
        differentiate();
        for (int axis = 0; axis < 3; ++axis) smooth(axis);
    }

    /// Of the brick's voxel (x,y,z).
    SheetNormal normal(int x, int y, int z) const {
        const std::size_t at = place(x + kReach, y + kReach, z + kReach);
        const Tensor& t = tensors_[at];
        const float trace = t[0] + t[1] + t[2];
        SheetNormal to;
        if (!(trace > 0)) return to;
        const std::array<float, 3> axis = largest(t), &g = gradients_[at];
        const float along = (g[0] * axis[0] + g[1] * axis[1] + g[2] * axis[2]) / std::sqrt(trace);
        for (int i = 0; i < 3; ++i) to.axis[i] = axis[std::size_t(i)];
        to.side = std::clamp(along, -1.0f, 1.0f);
        return to;
    }

  private:
    static std::size_t place(int x, int y, int z) {
        return std::size_t(x * kStride[0] + y * kStride[1] + z * kStride[2]);
    }

    /// Towards what is less opaque.
    void differentiate() {
        constexpr int kX = kOpacities * kOpacities, kY = kOpacities;
        std::size_t n = 0;
        for (int x = 1; x <= kSlopes; ++x)
            for (int y = 1; y <= kSlopes; ++y)
                for (int z = 1; z <= kSlopes; ++z, ++n) {
                    const float* at = &opacities_[std::size_t(x * kX + y * kY + z)];
                    const float gx = 0.5f * (at[-kX] - at[kX]), gy = 0.5f * (at[-kY] - at[kY]);
                    const float gz = 0.5f * (at[-1] - at[1]);
                    gradients_[n] = {gx, gy, gz};
                    tensors_[n] = {gx * gx, gy * gy, gz * gz, gx * gy, gx * gz, gy * gz};
                }
    }

    /// Along an axis; the places at its ends are not used any more.
    void smooth(int axis) {
        static const auto w = weights();
        const std::vector<Tensor> from = tensors_;
        const int stride = kStride[std::size_t(axis)];
        for (int n = 0; n < int(from.size()); ++n) {
            const int along = n / stride % kSlopes;
            if (along < kReach || along >= kSlopes - kReach) continue;
            Tensor sum{};
            for (int i = -kReach; i <= kReach; ++i)
                for (std::size_t k = 0; k < 6; ++k)
                    sum[k] += w[std::size_t(i + kReach)] * from[std::size_t(n + i * stride)][k];
            tensors_[std::size_t(n)] = sum;
        }
    }

    /// The eigenvector of the largest eigenvalue, by repeated squares.
    static std::array<float, 3> largest(const Tensor& t) {
        constexpr int kSquares = 5;  // the 32nd power
        double m[3][3] = {{t[0], t[3], t[4]}, {t[3], t[1], t[5]}, {t[4], t[5], t[2]}};
        for (int n = 0; n <= kSquares; ++n) {
            const double trace = m[0][0] + m[1][1] + m[2][2];
            double s[3][3];
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) s[i][j] = m[i][j] / trace;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    m[i][j] = n < kSquares ? s[i][0] * s[0][j] + s[i][1] * s[1][j] + s[i][2] * s[2][j] : s[i][j];
        }
        int best = 0;  // all columns are multiples of it
        for (int i = 1; i < 3; ++i)
            if (m[i][i] > m[best][best]) best = i;
        const double length = std::sqrt(m[0][best] * m[0][best] + m[1][best] * m[1][best] + m[2][best] * m[2][best]);
        return {float(m[0][best] / length), float(m[1][best] / length), float(m[2][best] / length)};
    }

    std::vector<float> opacities_;
    std::vector<std::array<float, 3>> gradients_;
    std::vector<Tensor> tensors_;
};

}  // namespace

std::vector<SheetNormal> sheetNormals(const CompositeLayout& layout, const std::vector<CompositeVoxel>& voxels) {
    std::vector<SheetNormal> normals(voxels.size());
    parallelFor(layout.brickCount() - 1, [&](std::size_t n) {
        const BrickSlopes slopes(layout, voxels, layout.origins[n + 1]);
        for (int i = 0; i < 512; ++i)
            normals[(n + 1) * 512 + std::size_t(i)] = slopes.normal(i >> 6, i >> 3 & 7, i & 7);
    });
    return normals;
}

}  // namespace raysweep
