/// The ramp filter |f| of filtered backprojection, as the convolution of rows with samples of its kernel (Kak and
/// Slaney, Principles of Computerized Tomographic Imaging, 1988, chapter 3, eq. 61; docs/ct.md, eq. 5), for a distance
/// of 1:
///
///     h[0] = 1/4,   h[n] = 0 for even n,   h[n] = -1 / (π n)² for odd n                                      (5)
///
/// It is made in space and transformed: |f| sampled in frequency would lose the mean of the row.
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

/// For rows of samples at distance 1; at distance d its results are d times too large. Rows count as 0 beyond their
/// ends.
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
