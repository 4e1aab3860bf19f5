// The path atlas: per pixel, the light of every distinct word. Whatever expression one thinks of afterwards is a sum of
// some of these words, so it is answered without a ray.
//
// Sums. The light of a word in the samples of one pixel of a batch (a block) is summed in double, in the order of
// contributions, and added exactly as the frame buffer adds (frame_buffer.h): what is kept does not depend on threads
// or order (Law 3). Beside R, G and B a word keeps the luminance ((R + G + B) / 3) of its light in eight parts, by the
// sample index modulo 8: their scatter, words of one layer added up first, says what the layer's error is.
//
// Raster splats are kept apart from the light of camera samples, which is divided by another number of samples.
//
// Budget. Words number what the scene and their length make of them. Where the memory exceeds the budget, words with
// least light are merged: a word gives up its last scattering and becomes one of the class "these scatterings, then one
// or more, then that terminal", as words beyond the length are; classes give up one more. Last of all go the first
// scattering and whether light is direct: most expressions ask for these. A class is honest: its light is of words that
// it describes. Merging happens between phases of a render, when what is in the atlas depends on nothing but the
// samples, so the merges do not depend on threads either; until then memory may pass the budget by what one phase
// brings. Light that arrives later of a word that was merged goes to its class.
//
// Memory: 32 bytes a pixel and word whose light came once, 64 one whose came more often, 128 more where it is of more
// than one eighth, 11 to 22 for finding it, 80 a pixel.
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
#include "display/services/samples/word_alphabet.h"

namespace raylex::display {

class PathWords;

class PathAtlas final : public SampleSink {
  public:
    static constexpr std::size_t parts = 8;

    struct Settings {
        int width = 0, height = 0;
        int scale_exponent = 0;               ///< ChannelDefinition::scale_exponent of the beauty
        std::uint64_t budget = 0;             ///< bytes; 0: none
        const PixelFilter* raster = nullptr;  ///< the kernel of raster splats, which must outlive this; null: none come
    };
    explicit PathAtlas(const Settings& settings);
    ~PathAtlas() override;

    void accumulate(const SampleTable& table) override;
    void splat(const SampleTable& table, std::span<const int> rows) override;
    void end_phase() override;
    [[nodiscard]] bool wants_phases() const override { return settings_.budget > 0; }
    [[nodiscard]] bool reads_channels() const override { return false; }
    [[nodiscard]] std::size_t expected_bytes() const override;

    /// One word of one pixel, as the image has it.
    struct Light {
        std::uint32_t word = 0;  ///< in words()
        std::array<double, 3> rgb{};
        std::array<double, parts> eighths{};  ///< R + G + B of the parts
    };
    /// What the words of a pixel come to, in no order; `light_paths`: FrameBuffer's.
    void resolve(std::size_t pixel, std::uint64_t light_paths, std::vector<Light>& words) const;
    /// How many of the pixel's samples each part had.
    [[nodiscard]] std::span<const std::uint32_t, parts> samples(std::size_t pixel) const;

    [[nodiscard]] const WordTree& words() const { return words_; }
    /// [column] whether some word had light through this event.
    [[nodiscard]] std::span<const std::uint8_t> seen() const { return seen_; }
    [[nodiscard]] bool dropped_straight() const { return dropped_straight_; }
    /// Words that gave up a scattering for the budget.
    [[nodiscard]] std::uint64_t merged_words() const { return merged_words_; }
    /// [word] the sum over the image of |R| + |G| + |B|, of words that no other took in.
    [[nodiscard]] std::vector<double> light_of_words() const;
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
    std::uint32_t known_as(PathWords& words, std::uint32_t word);
    void add(std::size_t pixel, std::uint32_t word, const std::array<double, 3 + parts>& light, Reserves& reserves);
    static void take_in(Entry& entry, const Entry& more, Reserves& reserves);
    void note_events(PathWords& words);
    [[nodiscard]] std::uint32_t class_above(std::uint32_t word);
    void fit_budget();
    bool merge_round(std::uint64_t most_entries);
    void apply_merges();
    [[nodiscard]] std::uint32_t survivor(std::uint32_t word) const;

    Settings settings_;
    std::vector<Pixel> pixels_;
    std::unique_ptr<Pools> pools_;
    std::mutex words_mutex_;
    WordTree words_;
    std::vector<std::uint32_t> merged_into_;  // [word] itself, or the class that took it in
    std::vector<std::uint8_t> seen_;
    bool dropped_straight_ = false;
    std::uint64_t merged_words_ = 0, generation_ = 0;
};

}  // namespace raylex::display
