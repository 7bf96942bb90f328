/// One number per ray of a view, detector column after detector column, so that the rays that cross the same columns of
/// voxels lie beside each other.
#pragma once

#include <cstddef>
#include <vector>

namespace raysweep {

class RayImage {
  public:
    /// Zeros before and behind each column, so that kernels may read and write whole vectors across its ends. What they
    /// write there must be 0.
    static constexpr int kMargin = 64;

    RayImage() = default;
    RayImage(int columns, int length) { resize(columns, length); }

    /// All numbers 0 if the size changes; else they stay.
    void resize(int columns, int length) {
        const std::size_t stride = (std::size_t(length) + 15) / 16 * 16 + 2 * kMargin;
        if (length == length_ && data_.size() == stride * std::size_t(columns)) return;
        length_ = length;
        stride_ = stride;
        data_.assign(stride * std::size_t(columns), 0.0f);
    }

    float* column(int n) { return data_.data() + std::size_t(n) * stride_ + kMargin; }
    const float* column(int n) const { return data_.data() + std::size_t(n) * stride_ + kMargin; }

  private:
    int length_ = 0;
    std::size_t stride_ = 0;
    std::vector<float> data_;
};

}  // namespace raysweep
