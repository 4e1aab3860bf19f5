// Deep pixels: all samples along the rays of a pixel, merged into a limited number of deep samples.
//
// Transmittances are averaged, not alphas. Let W be the sum of the pixel's weights. A sample of weight w, with rows of
// opacity o_1, o_2, ... from front to back, reduces T at row i by w/W (1 - o_1) ... (1 - o_{i-1}) o_i (mean of the
// colours). A deep sample that reduces the transmittance T in front of it by d has
//     A = d / T,    colour = (sum of its rows' weighted light) / (W T),
// so that front-to-back compositing restores the shallow pixel's alpha and colour exactly. (Averaging alphas does not:
// two opaque samples of half weight would composite to 0.75. See "Interpreting OpenEXR Deep Pixels".)
//
// Light of rays without a hit (an environment) is one last sample with A = 0 at Z = deep_background, so that the
// flattened colour is the beauty.
//
// Merging. Rows are assigned to bins by depth alone: bin k at level L contains depths whose float bits agree except for
// the last L bits (surfaces and volumes separately). Level L merges depths within a factor of 1 + 2^(L - 23). A pixel
// starts at the level of the tolerance. If it has more bins than the limit, the level rises until they fit. The final
// level depends only on the set of all rows, and bins are summed exactly (128-bit fixed point), so the order of batches
// and threads does not matter (Law 3). Bins merge in depth order, so flattening stays exact at any level.
//
// A bin of surface rows becomes a point at their mean depth. A bin of volume rows becomes a span from their nearest to
// their farthest depth.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/sample_sink.h"

namespace raylex::display {

class RayRows;

/// Depth of light behind everything: large, but finite in a float.
inline constexpr float deep_background = 1e30f;

struct DeepOptions {
    int most_samples = 32;         ///< deep samples per pixel, at least 1, not counting the background
    double tolerance = 1.0 / 256;  ///< relative difference between depths that can be merged, 2^-23 to 1
    bool tidy = false;             ///< shorten spans so that no two deep samples overlap, instead of only sorting them
};

/// One deep sample, with the values that a file contains.
struct DeepSample {
    float z = 0, z_back = 0;  ///< equal for a point
    float alpha = 0;
    std::vector<float> values;  ///< [component] of the buffer's channels, premultiplied by the sample's alpha
};

struct DeepCounts {
    std::uint64_t samples = 0;        ///< total over all pixels
    std::uint64_t merged_pixels = 0;  ///< number of pixels that exceeded the limit
    double coarsest = 0;              ///< largest relative difference between depths that were merged because of it
    std::uint64_t refused_rows = 0;   ///< rows that were left out: values out of range, or negative depths
};

class DeepBuffer : public SampleSink {
  public:
    /// `channels` are those of the render; `chosen` are the stored ones: light or kernel-filtered numbers.
    DeepBuffer(int width, int height, std::span<const ChannelDefinition> channels, std::vector<ChannelId> chosen,
               const DeepOptions& options);
    ~DeepBuffer() override;
    DeepBuffer(DeepBuffer&&) noexcept;
    DeepBuffer& operator=(DeepBuffer&&) noexcept;

    /// Checks the options. Errors: a channel that cannot be deep (integers, rules), options out of range.
    static Status check(std::span<const ChannelDefinition> channels, std::span<const ChannelId> chosen,
                        const DeepOptions& options);

    void accumulate(const SampleTable& table) override;
    /// Estimates four deep samples per pixel.
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
    std::vector<int> quanta_;  // [stride()] quanta of the sums
    DeepOptions options_;
    int first_level_ = 0;
    std::vector<Pixel> pixels_;
};

}  // namespace raylex::display
