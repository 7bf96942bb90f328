#include "raysweep/reconstruct/ramp_filter.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/core/types.h"

#include <kissfft/kissfft.hh>

#include <cmath>
#include <complex>

namespace raysweep {
namespace {

using Complex = std::complex<double>;
using Fourier = kissfft<double>;

/// The power of two that leaves room for a row and for all that its filter spreads it to.
std::size_t paddedLength(int width) {
    std::size_t length = 2;
    while (length < 2 * std::size_t(width)) length *= 2;
    return length;
}

/// Eq. 5 of ramp_filter.h: of sample n, and, as the transform is periodic, of n - length.
double kernel(std::size_t n, std::size_t length) {
    const double distance = double(n <= length / 2 ? n : length - n);
    if (n == 0) return 0.25;
    return n % 2 == 0 ? 0 : -1 / (kPi * kPi * distance * distance);
}

/// `f`: frequency over the cutoff.
double windowAt(RampWindow window, double f) {
    if (f > 1) return 0;
    switch (window) {
        case RampWindow::ramLak:
            return 1;
        case RampWindow::sheppLogan:
            return f == 0 ? 1 : std::sin(0.5 * kPi * f) / (0.5 * kPi * f);
        case RampWindow::cosine:
            return std::cos(0.5 * kPi * f);
        case RampWindow::hamming:
            return 0.54 + 0.46 * std::cos(kPi * f);
        case RampWindow::hann:
            return 0.5 + 0.5 * std::cos(kPi * f);
    }
    return 1;
}

}  // namespace

RampFilter::RampFilter(int width, RampWindow window, double cutoff) : width_(width) {
    requireField(width >= 1, "ramp filter: samples of a row", width, "at least 1");
    requireField(cutoff > 0 && cutoff <= 1, "cutoff", cutoff, "in (0,1]");
    const std::size_t length = paddedLength(width);
    std::vector<Complex> samples(length), spectrum(length);
    for (std::size_t n = 0; n < length; ++n) samples[n] = kernel(n, length);
    Fourier(length, false).transform(samples.data(), spectrum.data());
    response_.resize(length);
    for (std::size_t n = 0; n < length; ++n) {
        const double frequency = double(n <= length / 2 ? n : length - n) / (0.5 * double(length));
        response_[n] = spectrum[n].real() * windowAt(window, frequency / cutoff) / double(length);
    }
}

void RampFilter::apply(float* rows, std::size_t count, std::size_t stride) const {
    const std::size_t length = response_.size();
    const Fourier forward(length, false), inverse(length, true);
    // The response is real and even, so a complex transform filters two rows, as its real and its imaginary part.
    parallelFor((count + 1) / 2,
                [&](std::size_t pair) {
                    float* first = rows + 2 * pair * stride;
                    float* second = 2 * pair + 1 < count ? first + stride : nullptr;
                    std::vector<Complex> samples(length), spectrum(length);
                    for (int x = 0; x < width_; ++x) samples[x] = Complex(first[x], second ? second[x] : 0.0f);
                    forward.transform(samples.data(), spectrum.data());
                    for (std::size_t n = 0; n < length; ++n) spectrum[n] *= response_[n];
                    inverse.transform(spectrum.data(), samples.data());
                    for (int x = 0; x < width_; ++x) {
                        first[x] = float(samples[x].real());
                        if (second) second[x] = float(samples[x].imag());
                    }
                },
                8);
}

}  // namespace raysweep
