// Deep pixels: what every sample found along its ray, merged into a bounded number of deep samples per pixel.
//
// Transmittance decides, never alpha. With W the sum of the pixel's weights, a sample of weight w with rows of opacity
// o_1, o_2, ... from front to back lets T drop by w/W (1 - o_1) ... (1 - o_{i-1}) o_i at row i (mean of the colours). A
// deep sample that takes drop d from the transmittance T in front of it has
//     A = d / T,    colour = (sum of its rows' weighted light) / (W T),
// so that front-to-back over gives back the shallow pixel's alpha and colour exactly. (Weighting alphas instead does
// not: two opaque samples of half weight would composite to 0.75. See "Interpreting OpenEXR Deep Pixels".)
//
// Light of rays that hit nothing (an environment) is one last sample with A = 0 at Z = deep_background, so that the
// colour of the whole flattens to the beauty.
//
// Merging. Rows are put into bins by their depth alone: bin k at level L holds depths whose float bits agree but for
// the last L (surfaces and volumes apart). Level L merges depths within a factor of 1 + 2^(L - 23). A pixel begins at
// the level of the tolerance, and when it has more bins than the limit the level rises until they fit. The level in the
// end is that of the set of all rows, and bins are summed exactly (128-bit fixed point), so neither the order of
// batches nor threads show (Law 3). Bins merge in depth order, so flattening stays exact however coarse they become.
//
// A bin of surface rows is a point at their mean depth. A bin of volume rows is a span from the first to the last of
// them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/sample_sink.h"

namespace raylex::display {

class RayRows;

/// Depth of light that comes from behind everything: far, and finite in a float.
inline constexpr float deep_background = 1e30f;

struct DeepOptions {
    int most_samples = 32;         ///< deep samples per pixel, 1 or more; the background is not counted
    double tolerance = 1.0 / 256;  ///< relative difference of depths that may be merged, 2^-23 to 1
    bool tidy = false;             ///< cut spans so that no two deep samples overlap, instead of only sorting
};

/// One deep sample; values as they go into a file.
struct DeepSample {
    float z = 0, z_back = 0;  ///< equal for a point
    float alpha = 0;
    std::vector<float> values;  ///< [component] of the buffer's channels, premultiplied by what is in the sample
};

struct DeepCounts {
    std::uint64_t samples = 0;        ///< in all pixels
    std::uint64_t merged_pixels = 0;  ///< pixels in which the limit was passed
    double coarsest = 0;              ///< largest relative difference of depths merged for it
    std::uint64_t refused_rows = 0;   ///< rows with values out of range, or depths that are negative: left out
};

class DeepBuffer : public SampleSink {
  public:
    /// `channels` are those of the render; `chosen` the ones kept, all light or kernel-filtered numbers.
    DeepBuffer(int width, int height, std::span<const ChannelDefinition> channels, std::vector<ChannelId> chosen,
               const DeepOptions& options);
    ~DeepBuffer() override;
    DeepBuffer(DeepBuffer&&) noexcept;
    DeepBuffer& operator=(DeepBuffer&&) noexcept;

    /// Errors: a channel that cannot be deep (integers, rules), options out of range.
    static Status check(std::span<const ChannelDefinition> channels, std::span<const ChannelId> chosen,
                        const DeepOptions& options);

    void accumulate(const SampleTable& table) override;
    /// Four deep samples a pixel.
    [[nodiscard]] std::size_t expected_bytes() const override;

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] const DeepOptions& options() const { return options_; }
    [[nodiscard]] std::span<const ChannelId> chosen() const { return chosen_; }
    [[nodiscard]] std::span<const ChannelDefinition> channels() const { return channels_; }
    [[nodiscard]] std::size_t component_count() const { return components_; }
    /// The deep samples of a pixel, front to back.
    [[nodiscard]] std::vector<DeepSample> resolve(int x, int y) const;
    [[nodiscard]] DeepCounts counts() const;

  private:
    struct Pixel;
    struct Bin;
    struct Row;
    struct Scratch;
    void add_sample(Pixel& pixel, const SampleTable& table, const RayRows& rays, int camera_row, Scratch& scratch);
    void add_row(Pixel& pixel, const SampleTable& table, const Row& row, Scratch& scratch);
    void coarsen(Pixel& pixel) const;
    [[nodiscard]] std::size_t stride() const { return 2 + components_; }  // of Pixel::sums: drop, drop x depth, values
    int width_, height_;
    std::vector<ChannelDefinition> channels_;
    std::vector<ChannelId> chosen_;
    std::size_t components_ = 0;
    std::vector<int> quanta_;  // [stride()] of the sums
    DeepOptions options_;
    int first_level_ = 0;
    std::vector<Pixel> pixels_;
};

}  // namespace raylex::display
