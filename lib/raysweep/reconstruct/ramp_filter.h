/// The filter that filtered backprojection is named for.
#pragma once

#include <cstddef>
#include <vector>

namespace raysweep {

/// By what the ramp |f| is multiplied: 1 up to the cutoff, or a window that falls towards it. The more it falls the
/// less noise, and the softer the edges.
enum class RampWindow {
    ramLak,      ///< 1
    sheppLogan,  ///< sin(x)/x, 2/pi at the cutoff
    cosine,      ///< cosine, 0 at the cutoff
    hamming,     ///< 0.54 + 0.46 cosine
    hann         ///< 0.5 + 0.5 cosine, 0 at the cutoff
};

/// Ramp filter for rows of samples at distance 1; at distance d its results are d times too large. Rows count as 0
/// beyond their ends. Kernel: Kak and Slaney, Principles of Computerized Tomographic Imaging (1988), eq. 61 of chapter
/// 3, made in space and transformed: |f| sampled in frequency would lose the mean of the row.
class RampFilter {
  public:
    /// `width`: samples of a row, > 0. `cutoff`: where the window ends, in (0,1] of the highest frequency (1/2 per
    /// sample); nothing passes beyond. @throw InvalidArgument naming what is out of range.
    explicit RampFilter(int width, RampWindow window = RampWindow::ramLak, double cutoff = 1);

    /// Filters `count` rows in place, row n beginning at `rows + n * stride`; by all threads.
    void apply(float* rows, std::size_t count, std::size_t stride) const;

  private:
    int width_;
    std::vector<double> response_;  ///< of each frequency of the padded row, divided by its length
};

}  // namespace raysweep
