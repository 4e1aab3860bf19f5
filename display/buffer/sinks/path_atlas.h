// The path atlas stores, per pixel, the light of every distinct word. The layer of any expression is the sum of some of
// these words, so it can be computed later without tracing rays.
//
// Sums. The light of a word in one pixel of a batch (a block) is summed in double in the order of contributions. Block
// sums are added exactly, as in the frame buffer (frame_buffer.h), so the content does not depend on threads or order
// (Law 3). Beside R, G and B a word stores its luminance ((R + G + B) / 3) in eight parts, by the sample index modulo
// 8. The scatter of the parts, summed over the words of a layer, gives the layer's error.
//
// Raster splats are stored separately from the light of camera samples, because their divisor differs.
//
// Budget. The number of words depends on the scene and on their maximum length. If the memory exceeds the budget, the
// words with least light are merged: a word loses its last scattering and becomes part of the class "these scatterings,
// then one or more, then that terminal", like words beyond the maximum length; a class loses one more scattering. The
// first scattering and the distinction of direct light are lost last, because most expressions use them. A class
// contains only light of words that it describes. Merging happens between phases of a render, when the content depends
// only on the samples, so merges do not depend on threads. Until then memory can exceed the budget by the words of one
// phase. Later light of a merged word goes to its class.
//
// Memory: 32 bytes per pixel and word whose light came once, 64 if it came more often, 128 more if it belongs to more
// than one eighth, 11 to 22 for the index, 80 per pixel.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "display/buffer/fixed_point.h"
#include "display/buffer/pixel_filter.h"
#include "display/buffer/pixel_image.h"
#include "display/buffer/sample_sink.h"
#include "display/services/samples/path_alphabet.h"

namespace raylex::display {

class BatchPathStrings;

class PathAtlas final : public SampleSink {
  public:
    static constexpr std::size_t parts = 8;

    struct Settings {
        int width = 0, height = 0;
        int scale_exponent = 0;               ///< ChannelDefinition::scale_exponent of the beauty
        std::uint64_t budget = 0;             ///< bytes; 0: unlimited
        const PixelFilter* raster = nullptr;  ///< the kernel of raster splats, which must outlive this; null: no splats
    };
    explicit PathAtlas(const Settings& settings);
    ~PathAtlas() override;

    void accumulate(const SampleTable& table) override;
    void splat(const SampleTable& table, std::span<const int> rows) override;
    void end_phase() override;
    [[nodiscard]] bool wants_phases() const override { return settings_.budget > 0; }
    [[nodiscard]] bool reads_channels() const override { return false; }
    [[nodiscard]] std::size_t expected_bytes() const override;

    /// The resolved light of one word in one pixel.
    struct Light {
        std::uint32_t word = 0;  ///< index in words()
        std::array<double, 3> rgb{};
        std::array<double, parts> eighths{};  ///< R + G + B of each part
    };
    /// Resolves the words of a pixel, in no particular order. `light_paths`: FrameBuffer::light_path_count().
    void resolve(std::size_t pixel, std::uint64_t light_paths, std::vector<Light>& words) const;
    /// The number of the pixel's samples in each part.
    [[nodiscard]] std::span<const std::uint32_t, parts> samples(std::size_t pixel) const;

    [[nodiscard]] const PathStringTree& words() const { return words_; }
    /// [column] whether some word had light through this event.
    [[nodiscard]] std::span<const std::uint8_t> seen() const { return seen_; }
    [[nodiscard]] bool dropped_straight() const { return dropped_straight_; }
    /// The number of words that lost a scattering because of the budget.
    [[nodiscard]] std::uint64_t merged_path_strings() const { return merged_path_strings_; }
    /// [word] the sum of |R| + |G| + |B| over the image, for words that were not merged into others.
    [[nodiscard]] std::vector<double> light_of_path_strings() const;
    [[nodiscard]] std::uint64_t entry_count() const;
    [[nodiscard]] std::uint64_t memory_bytes() const;

  private:
    struct Eighths;
    struct Entry;
    struct Single;
    struct Slot;
    struct Pixel;
    template <class Item>
    class Pool;
    class SlotPool;
    struct Pools;
    struct Reserves;
    class Batch;
    std::uint32_t known_as(BatchPathStrings& words, std::uint32_t word);
    void add(std::size_t pixel, std::uint32_t word, const std::array<double, 3 + parts>& light, Reserves& reserves);
    static void take_in(Entry& entry, const Entry& more, Reserves& reserves);
    void note_events(BatchPathStrings& words);
    [[nodiscard]] std::uint32_t class_above(std::uint32_t word);
    void fit_budget();
    bool merge_round(std::uint64_t most_entries);
    void apply_merges();
    [[nodiscard]] std::uint32_t survivor(std::uint32_t word) const;

    Settings settings_;
    std::vector<Pixel> pixels_;
    std::unique_ptr<Pools> pools_;
    std::mutex path_strings_mutex_;
    PathStringTree words_;
    std::vector<std::uint32_t> merged_into_;  // [word] itself, or the class that contains it
    std::vector<std::uint8_t> seen_;
    bool dropped_straight_ = false;
    std::uint64_t merged_path_strings_ = 0, generation_ = 0;
};

}  // namespace raylex::display
