#include "display/output/denoise/denoise.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "display/buffer/pixel_image.h"
#include "display/output/denoise/layer_sums.h"
#include "display/output/denoise/settled_variance.h"
#include "display/output/denoise/tile_filter.h"
#include "display/services/thread_or_none.h"

namespace raylex::display {

namespace {

constexpr int tile_size = 64;
/// Estimates of pixels miss highlights that look like noise, so the mean error is this factor larger. The interval of
/// 95 % reaches from the estimate divided by `least_error` to the estimate times `most_error`. Both were measured
/// (experiments/bench/denoising.py).
constexpr double missed_error = 1.6, least_error = 16, most_error = 6;

/// The result for one tile: of each layer three planes, and the squared error.
class Denoiser {
  public:
    explicit Denoiser(NoisyImage& image) : image_(image), output_(image.layers.size()) {
        const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
        for (Output& each : output_) {
            for (std::vector<float>& plane : each.values) plane.resize(pixels);
            each.error.resize(pixels);
        }
    }

    std::vector<LayerError> run(int threads) {
        const int columns = (image_.width + tile_size - 1) / tile_size,
                  rows = (image_.height + tile_size - 1) / tile_size;
        const std::size_t planes = 3 * image_.layers.size();
        on_threads(planes + image_.features.size(), threads, [&](std::size_t i) {
            const bool is_light = i < planes;
            std::vector<float>& values =
                is_light ? image_.layers[i / 3].values[i % 3] : image_.features[i - planes].values;
            settle_variance(values,
                            is_light ? image_.layers[i / 3].variance[i % 3] : image_.features[i - planes].variance,
                            image_.width, image_.height);
        });
        on_threads(static_cast<std::size_t>(columns * rows), threads, [&](std::size_t i) {
            const int x = static_cast<int>(i) % columns * tile_size, y = static_cast<int>(i) / columns * tile_size;
            filter({x, y, std::min(x + tile_size, image_.width), std::min(y + tile_size, image_.height)});
        });
        std::vector<LayerError> errors;
        for (std::size_t i = 0; i < output_.size(); ++i) {
            errors.push_back(error_of(i));
            NoisyLayer& layer = image_.layers[i];
            for (std::size_t c = 0; c < 3; ++c) layer.values[c] = std::move(output_[i].values[c]);
            layer.variance = {std::move(output_[i].error), {}, {}};
        }
        return errors;
    }

  private:
    struct Output {
        std::array<std::vector<float>, 3> values;
        std::vector<float> error;
    };

    /// The better estimate of each pixel.
    static void improve(TileEstimate& estimate, const TileEstimate& other) {
        for (std::size_t i = 0; i < estimate.risk.size(); ++i) {
            if (other.risk[i] >= estimate.risk[i]) continue;
            estimate.risk[i] = other.risk[i];
            estimate.shown[i] = other.shown[i];
            for (std::size_t c = 0; c < 3; ++c) estimate.values[c][i] = other.values[c][i];
        }
    }

    void filter(const PixelRegion& tile) {
        TileFilter filter(image_, tile);
        const std::size_t layers = image_.layers.size();
        std::vector<TileEstimate> estimates;
        const bool guided = filter.weigh(0), summed = !image_.sums.empty();
        for (std::size_t i = 0; i < layers; ++i)
            estimates.push_back(!guided            ? filter.noisy(i)
                                : summed || i == 0 ? filter.estimate(i)
                                                   : filter.estimate(i, &estimates.front()));
        for (std::size_t i = 1; i < layers && summed; ++i)
            if (filter.weigh(i)) improve(estimates[i], filter.estimate(i));
        store(tile, estimates);
    }

    void store(const PixelRegion& tile, const std::vector<TileEstimate>& estimates) {
        const std::size_t layers = estimates.size();
        LayerSums sums(image_.sums, layers);
        std::vector<double> noisy(layers), risk(layers), values(layers), reduced(layers);
        for (int y = tile.y0, i = 0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x, ++i) {
                const std::size_t to = static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                                       static_cast<std::size_t>(x),
                                  from = static_cast<std::size_t>(i);
                for (std::size_t l = 0; l < layers; ++l) risk[l] = static_cast<double>(estimates[l].risk[from]) / 3;
                for (std::size_t c = 0; c < 3; ++c) {
                    for (std::size_t l = 0; l < layers; ++l) {
                        noisy[l] = static_cast<double>(image_.layers[l].values[c][to]);
                        values[l] = static_cast<double>(estimates[l].values[c][from]);
                        if (noisy[l] >= 0 && !image_.sums.empty()) values[l] = std::max(0.0, values[l]);
                    }
                    sums.make_sum(noisy, risk, values);
                    for (std::size_t l = 0; l < layers; ++l) output_[l].values[c][to] = static_cast<float>(values[l]);
                }
                sums.reduce_risk(risk, reduced);
                for (std::size_t l = 0; l < layers; ++l)
                    output_[l].error[to] = estimates[l].shown[from] * static_cast<float>(reduced[l]);
            }
    }

    [[nodiscard]] LayerError error_of(std::size_t index) const {
        const NoisyLayer& layer = image_.layers[index];
        const Output& output = output_[index];
        LayerError result;
        const double pixels = static_cast<double>(output.error.size());
        for (std::size_t i = 0; i < output.error.size(); ++i) {
            result.after += static_cast<double>(output.error[i]) / pixels;
            for (std::size_t c = 0; c < 3; ++c) {
                result.before += static_cast<double>(layer.variance[c][i]) / (3 * pixels);
                result.light += static_cast<double>(layer.values[c][i]);
                result.light_after += static_cast<double>(output.values[c][i]);
            }
        }
        result.after *= missed_error;
        result.least = result.after / least_error;
        result.most = result.after * most_error;
        return result;
    }

    NoisyImage& image_;
    std::vector<Output> output_;
};

}  // namespace

std::vector<LayerError> denoise(NoisyImage& image, int threads) {
    return Denoiser(image).run(threads);
}

}  // namespace raylex::display
