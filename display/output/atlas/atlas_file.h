// Path atlases as files: deep OpenEXR whose samples are words.
//
//   part `words`   deep: word (UINT), R G B (FLOAT), one sample a word that the pixel has light of, by ascending
//                  number; eighth (HALF), which of the eighths of the pixel's samples brought the word's luminance,
//                  (R + G + B) / 3: 1 to 8, 0 where there is none, 9 where several did; and where light may be
//                  negative Rrest Grest Brest (FLOAT), what R G B lack of it: words that nearly cancel make layers that
//                  are much less than they
//   part `parts`   deep, one sample a word whose `eighth` is 9, in the same order: p0 ... p7 (HALF), what share of its
//                  luminance each brought
//   part `rgba`    flat: R G B A of the render, and n0 ... n7 (FLOAT), how many of the pixel's samples each eighth had
//
// Deep parts without Z: samples are no surfaces. The header of `words` holds the table, as text:
//
//   atlas/version  2; in version 1 part `parts` had all words, and there was no `eighth`
//   atlas/by       what words are told apart by: label,lobe,group,straight,technique
//   atlas/length   scatterings of the longest word kept whole
//   atlas/events   events of the scene that had light, as lpe/match.h writes them
//   atlas/letters  for each of these its letter; events of one letter were not told apart
//   atlas/words    a line a word, the first is number 0: letters from the camera on, the last a terminal; `*` stands
//                  for one scattering or more, of any of the events, `* *` for two or more; told apart by techniques,
//                  each ends in its own, as s1t3, where 127 vertices stand for as many or more
//   atlas/straight `dropped` where light passed cutouts that the words do not tell of
//   atlas/signed   where a word's light may be negative: `weights`, a pixel filter with negative lobes; `light`, paths
//                  of one wavelength
//   atlas/merged   how many words gave up a scattering for the budget
//
// and what else the description says.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/sinks/path_atlas.h"
#include "display/output/writer/exr_writer.h"
#include "display/services/samples/word_alphabet.h"
#include "lpe/event.h"
#include "lpe/result.h"

namespace raylex::display {

/// Whether light of a word may be negative, and why.
enum class SignedLight : std::uint8_t { none, light, weights };

/// The words of a file and what their letters mean.
struct WordTable {
    using Letter = WordAlphabet::Letter;
    WordRules rules;
    std::vector<lpe::Event> events;
    std::vector<Letter> letters;             ///< [event]
    std::vector<std::vector<Letter>> words;  ///< WordAlphabet::open: one scattering or more
    std::vector<Technique> techniques;       ///< [word] how its light was found; empty where words do not tell
    bool dropped_straight = false;
    SignedLight negative = SignedLight::none;
    [[nodiscard]] bool is_signed() const { return negative != SignedLight::none; }
    std::uint64_t merged = 0;
};

/// A word of a pixel, as the file has it.
struct WordSample {
    std::uint32_t word = 0;
    std::array<double, 3> rgb{};                  ///< of float precision where light is not signed
    std::array<float, PathAtlas::parts> parts{};  ///< shares of the luminance
};

/// One row of an atlas.
struct AtlasRow {
    std::vector<std::uint32_t> begin;  ///< [pixel + 1] into samples
    std::vector<WordSample> samples;
    std::vector<std::array<float, 4>> rgba;                   ///< of the render
    std::vector<std::array<float, PathAtlas::parts>> counts;  ///< of the pixel's samples
};

/// Whatever rows come from: a render, files to be merged.
class AtlasSource {
  public:
    virtual ~AtlasSource() = default;
    [[nodiscard]] virtual int width() const = 0;
    [[nodiscard]] virtual int height() const = 0;
    [[nodiscard]] virtual const WordTable& table() const = 0;
    /// Rows are asked for from the top on.
    virtual Status row(int y, AtlasRow& row) = 0;
};

/// The atlas of a render, its words sorted by their light, the brightest first. All must outlive it; `image` is where
/// the beauty and alpha come from.
std::unique_ptr<AtlasSource> atlas_of_render(const PathAtlas& atlas, const WordAlphabet& alphabet,
                                             const FrameBuffer& image, ChannelId beauty, SignedLight negative);

/// Written to a temporary name and renamed.
Status write_atlas(const std::string& path, AtlasSource& source, const ImageDescription& description);

/// An atlas in a file, read row by row.
class AtlasFile final : public AtlasSource {
  public:
    /// Errors: no OpenEXR file, none of an atlas, one of another version, a damaged table.
    static Result<std::unique_ptr<AtlasFile>> open(const std::string& path);
    ~AtlasFile() override;
    [[nodiscard]] int width() const override;
    [[nodiscard]] int height() const override;
    [[nodiscard]] const WordTable& table() const override;
    /// In any order, and by several threads at once.
    Status row(int y, AtlasRow& row) override;
    /// Without `parts` rows are read sooner, and come without WordSample::parts.
    void read_parts(bool wanted);
    /// What the header of part `rgba` says: attributes, chromaticities, matrices, whether it is complete.
    [[nodiscard]] const ImageDescription& description() const;
    [[nodiscard]] const std::string& path() const;

  private:
    struct Impl;
    explicit AtlasFile(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Whether the header says that the file is an atlas, of whatever version. False for what is no OpenEXR file.
bool is_atlas(const std::string& path);

/// Words against the beauty that stands beside them, pixel by pixel: |sum - beauty| <= 2^-23 (sum of |words| +
/// |beauty|).
struct AtlasVerdict {
    double largest = 0;  ///< |sum - beauty| over the sum of |words| + |beauty|
    int x = 0, y = 0;
    std::uint64_t exceeding = 0;  ///< pixels
    std::uint64_t clamped = 0;    ///< pixels with a value at the largest float: what it can explain is no error
    std::uint64_t samples = 0, most_samples = 0;
    std::size_t words = 0;
    bool holds = false;
};
/// `magnitude`: of light_magnitude (stored_precision.h), 2^-45 of which comes on top.
Result<AtlasVerdict> check_atlas(AtlasSource& source, double magnitude = 0);

}  // namespace raylex::display
