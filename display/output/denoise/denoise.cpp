#include "display/output/denoise/denoise.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <utility>

#include "display/buffer/pixel_image.h"
#include "display/output/denoise/layer_sums.h"
#include "display/output/denoise/settled_variance.h"
#include "display/output/denoise/tile_filter.h"
#include "display/services/thread_or_none.h"

namespace raylex::display {

namespace {

constexpr int tile_size = 64;
/// Runs `work` for 0 to count - 1 on threads, each number once.
template <class Work>
void on_threads(std::size_t count, int threads, const Work& work) {
    std::atomic<std::size_t> next{0};
    const auto run = [&] {
        for (std::size_t i; (i = next.fetch_add(1)) < count;) work(i);
    };
    const std::size_t cores =
        threads > 0 ? static_cast<std::size_t>(threads) : std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::thread> others(std::max<std::size_t>(1, std::min(cores, count)) - 1);
    for (std::thread& each : others) each = thread_or_none(run);
    run();
    for (std::thread& each : others)
        if (each.joinable()) each.join();
}

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
                for (std::size_t l = 0; l < layers; ++l) output_[l].error[to] = static_cast<float>(reduced[l]);
            }
    }

    /// The interval comes from the scatter of blocks of pixels, because the errors of near pixels are alike.
    [[nodiscard]] LayerError error_of(std::size_t index) const {
        constexpr int block = 16;
        const NoisyLayer& layer = image_.layers[index];
        const Output& output = output_[index];
        LayerError result;
        double squares = 0, blocks = 0;
        for (int y0 = 0; y0 < image_.height; y0 += block)
            for (int x0 = 0; x0 < image_.width; x0 += block, ++blocks) {
                double sum = 0;
                for (int y = y0; y < std::min(y0 + block, image_.height); ++y)
                    for (int x = x0; x < std::min(x0 + block, image_.width); ++x) {
                        const auto i = static_cast<std::size_t>(y * image_.width + x);
                        sum += static_cast<double>(output.error[i]);
                        for (std::size_t c = 0; c < 3; ++c) {
                            result.before += static_cast<double>(layer.variance[c][i]) / 3;
                            result.light += static_cast<double>(layer.values[c][i]);
                            result.light_after += static_cast<double>(output.values[c][i]);
                        }
                    }
                result.after += sum;
                squares += sum * sum;
            }
        const double pixels = static_cast<double>(output.error.size());
        if (blocks > 1)
            result.half_width =
                1.96 / pixels *
                std::sqrt(std::max(0.0, squares - result.after * result.after / blocks) * blocks / (blocks - 1));
        result.before /= pixels;
        result.after /= pixels;
        // Weights depend on noise, and highlights look like noise: measured errors exceed the estimates more than
        // blocks of pixels show.
        result.half_width = std::max(result.half_width, 2 * result.after);
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
