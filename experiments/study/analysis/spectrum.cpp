#include "experiments/study/analysis/spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>

namespace raylex::experiments {
namespace {

using Complex = std::complex<double>;

std::vector<Complex> roots_of_unity(std::size_t n) {
    std::vector<Complex> roots;
    for (std::size_t i = 0; i < n; ++i)
        roots.push_back(std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n)));
    return roots;
}

/// Fourier transform of n values with distance `stride`, by Cooley and Tukey 1965 with the smallest prime factor.
void transform(const Complex* in, std::size_t stride, Complex* out, std::size_t n, const std::vector<Complex>& roots) {
    *out = *in;
    if (n == 1) return;
    std::size_t p = 2;
    while (n % p != 0) ++p;
    const std::size_t m = n / p, step = roots.size() / n;
    for (std::size_t r = 0; r < p; ++r) transform(in + r * stride, stride * p, out + r * m, m, roots);
    std::vector<Complex> parts(p);
    for (std::size_t k = 0; k < m; ++k) {
        for (std::size_t r = 0; r < p; ++r) parts[r] = out[r * m + k];
        for (std::size_t j = k; j < n; j += m) {
            out[j] = 0;
            for (std::size_t r = 0; r < p; ++r) out[j] += parts[r] * roots[r * j % n * step];
        }
    }
}

/// Transforms `lines` lines in place. A line has n values with distance `stride`; the next line begins `next` values
/// later.
void transform_lines(std::vector<Complex>& values, std::size_t lines, std::size_t next, std::size_t n,
                     std::size_t stride) {
    const std::vector<Complex> roots = roots_of_unity(n);
    std::vector<Complex> line(n);
    for (std::size_t l = 0; l < lines; ++l) {
        transform(&values[l * next], stride, line.data(), n, roots);
        for (std::size_t i = 0; i < n; ++i) values[l * next + i * stride] = line[i];
    }
}

/// Returns the absolute frequency, in cycles per pixel, of the k-th of n frequencies.
double cycles(std::size_t k, std::size_t n) {
    return static_cast<double>(std::min(k, n - k)) / static_cast<double>(n);
}

}  // namespace

std::vector<FrequencyRing> radial_spectrum(const PixelArray& image) {
    const std::size_t w = image.width, h = image.height, n = image.components;
    const double first = 1 / static_cast<double>(std::max(w, h));
    std::map<int, FrequencyRing> rings;  // by quarters of an octave above `first`
    std::vector<Complex> values(w * h);
    // Transforms two real components at once: |F(k)|^2 + |F(-k)|^2 of a + i b is the sum for a and b, and k and -k are
    // in the same ring.
    for (std::size_t c = 0; c < n; c += 2) {
        for (std::size_t i = 0; i < w * h; ++i)
            values[i] = {image.values[n * i + c], c + 1 < n ? image.values[n * i + c + 1] : 0.0};
        transform_lines(values, h, w, w, 1);
        transform_lines(values, w, 1, h, w);
        for (std::size_t i = 0; i < w * h; ++i) {
            // A frequency on a bound belongs to the upper ring, whatever the rounding.
            const double octaves = std::log2(std::hypot(cycles(i % w, w), cycles(i / w, h)) / first) + 1e-9;
            FrequencyRing& ring = rings[i == 0 ? -1 : static_cast<int>(4 * octaves)];
            ring.power += std::norm(values[i]) / static_cast<double>(w * h * n);
            ring.count += c == 0 ? 1 : 0;
        }
    }
    std::vector<FrequencyRing> result;
    for (auto& [place, ring] : rings) {
        ring.frequency = place < 0 ? 0 : first * std::exp2((place + 0.5) / 4);
        ring.power /= static_cast<double>(ring.count);
        result.push_back(ring);
    }
    return result;
}

}  // namespace raylex::experiments
