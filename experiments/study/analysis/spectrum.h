// The spectrum of an image's error: Celarek, Jakob, Wimmer, Lehtinen 2019, "Quantifying the error of light transport
// algorithms", Computer Graphics Forum 38(4).
#pragma once

#include <vector>

#include "experiments/study/results.h"

namespace raylex::experiments {

/// A ring of frequencies of a Fourier-transformed image.
struct FrequencyRing {
    double frequency = 0;  ///< cycles per pixel: geometric mean of the ring's bounds
    double power = 0;      ///< mean over the ring; the mean over all frequencies is the mean square of the image
    std::size_t count = 0;
};
/// Returns the frequency 0, then rings of a quarter of an octave, starting at one cycle per longer side; empty rings
/// are omitted. The FFT is fast if the sides have small prime factors.
std::vector<FrequencyRing> radial_spectrum(const PixelArray& image);

}  // namespace raylex::experiments
