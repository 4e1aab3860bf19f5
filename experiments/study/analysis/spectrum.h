// How the error of an image is spread over spatial frequencies: Celarek, Jakob, Wimmer, Lehtinen 2019, "Quantifying the
// error of light transport algorithms", Computer Graphics Forum 38(4).
#pragma once

#include <vector>

#include "experiments/study/results.h"

namespace raylex::experiments {

/// A ring of frequencies of a Fourier-transformed image.
struct FrequencyRing {
    double frequency = 0;  ///< cycles per pixel: the geometric mean of the ring's bounds
    double power = 0;      ///< mean over the ring; its mean over all frequencies is the mean square of the image
    std::size_t count = 0;
};
/// First the frequency 0, then rings of a quarter of an octave from one cycle per longer side on; empty ones are left
/// out. An FFT, which is quick where sides have small prime factors.
std::vector<FrequencyRing> radial_spectrum(const PixelArray& image);

}  // namespace raylex::experiments
