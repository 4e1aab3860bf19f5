// Path atlases as files: deep OpenEXR files whose samples are words.
//
//   part `words`   deep, one sample per word with light in the pixel, by ascending number: word (UINT); R G B (FLOAT);
//                  eighth (HALF), the eighth of the pixel's samples that found the word's luminance (R + G + B) / 3:
//                  1 to 8, 0 for none, 9 for several; and, if light can be negative, Rrest Grest Brest (FLOAT), the
//                  rounding errors of R G B: words that nearly cancel can sum to layers much smaller than themselves
//   part `parts`   deep, one sample per word whose `eighth` is 9, in the same order: p0 ... p7 (HALF), the fraction of
//                  its luminance that each eighth found
//   part `rgba`    flat: R G B A of the render, and n0 ... n7 (FLOAT), the pixel's samples in each eighth
//
// Deep parts have no Z, because samples are not surfaces. The header of `words` contains the table as text:
//
//   atlas/version  2; version 1 had all words in part `parts`, and no `eighth`
//   atlas/by       what distinguishes words: label,lobe,group,straight,technique
//   atlas/length   number of scatterings of the longest word that is stored completely
//   atlas/events   the events of the scene that had light, in the notation of lpe/match.h
//   atlas/letters  the letter of each of these events; events with the same letter are not distinguished
//   atlas/words    one line per word, the first is number 0: letters from the camera on, the last one a terminal;
//                  `*` is one scattering or more with any of the events, `* *` two or more; words that distinguish
//                  techniques end in theirs, such as s1t3; 127 vertices mean 127 or more
//   atlas/straight `dropped` if light passed cutouts that the words do not contain
//   atlas/signed   why a word's light can be negative: `weights`, a pixel filter with negative lobes; `light`, paths of
//                  one wavelength
//   atlas/merged   number of words that lost a scattering because of the budget
//
// and the remaining attributes of the image description.
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
#include "display/services/samples/path_alphabet.h"
#include "lpe/event.h"
#include "lpe/result.h"

namespace raylex::display {

/// Whether the light of a word can be negative, and why.
enum class SignedLight : std::uint8_t { none, light, weights };

/// The words of a file and the meaning of their letters.
struct PathStringTable {
    using Letter = PathAlphabet::Letter;
    PathStringRules rules;
    std::vector<lpe::Event> events;
    std::vector<Letter> letters;             ///< [event]
    std::vector<std::vector<Letter>> words;  ///< PathAlphabet::open: one scattering or more
    std::vector<Technique> techniques;       ///< [word] how its light was found; empty if words do not distinguish
                                             ///< techniques
    bool dropped_straight = false;
    SignedLight negative = SignedLight::none;
    [[nodiscard]] bool is_signed() const { return negative != SignedLight::none; }
    std::uint64_t merged = 0;
};

/// A word of a pixel, as stored in the file.
struct PathStringSample {
    std::uint32_t word = 0;
    std::array<double, 3> rgb{};                  ///< of float precision if light is not signed
    std::array<float, PathAtlas::parts> parts{};  ///< fractions of the luminance
};

/// One row of an atlas.
struct AtlasRow {
    std::vector<std::uint32_t> begin;  ///< [pixel + 1] offset into samples
    std::vector<PathStringSample> samples;
    std::vector<std::array<float, 4>> rgba;                   ///< pixels of the render
    std::vector<std::array<float, PathAtlas::parts>> counts;  ///< the pixel's samples in each eighth
};

/// A source of rows: a render, or files to be merged.
class AtlasSource {
  public:
    virtual ~AtlasSource() = default;
    [[nodiscard]] virtual int width() const = 0;
    [[nodiscard]] virtual int height() const = 0;
    [[nodiscard]] virtual const PathStringTable& table() const = 0;
    /// Reads one row. Callers read rows from top to bottom.
    virtual Status row(int y, AtlasRow& row) = 0;
};

/// The atlas of a render, with words sorted by light, the brightest first. All arguments must outlive it; `image`
/// provides the beauty and alpha.
std::unique_ptr<AtlasSource> atlas_of_render(const PathAtlas& atlas, const PathAlphabet& alphabet,
                                             const FrameBuffer& image, ChannelId beauty, SignedLight negative);

/// Writes the atlas to a temporary file and renames it.
Status write_atlas(const std::string& path, AtlasSource& source, const ImageDescription& description);

/// An atlas in a file, read row by row.
class AtlasFile final : public AtlasSource {
  public:
    /// Opens an atlas. Errors: not an OpenEXR file, not an atlas, another version, a damaged table.
    static Result<std::unique_ptr<AtlasFile>> open(const std::string& path);
    ~AtlasFile() override;
    [[nodiscard]] int width() const override;
    [[nodiscard]] int height() const override;
    [[nodiscard]] const PathStringTable& table() const override;
    /// Reads rows in any order; several threads can call it at once.
    Status row(int y, AtlasRow& row) override;
    /// If `wanted` is false, rows are read faster and lack PathStringSample::parts.
    void read_parts(bool wanted);
    /// The content of the header of part `rgba`: attributes, chromaticities, matrices, completeness.
    [[nodiscard]] const ImageDescription& description() const;
    [[nodiscard]] const std::string& path() const;

  private:
    struct Impl;
    explicit AtlasFile(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Returns whether the header marks the file as an atlas of any version. False if it is not an OpenEXR file.
bool is_atlas(const std::string& path);

/// The comparison of words with the beauty of the file, pixel by pixel: |sum - beauty| <= 2^-23 (sum of |words| +
/// |beauty|).
struct AtlasCheck {
    double largest = 0;  ///< |sum - beauty| over the sum of |words| + |beauty|
    int x = 0, y = 0;
    std::uint64_t exceeding = 0;  ///< pixels
    std::uint64_t clamped = 0;    ///< pixels with a value at the largest float; deviations that clamping explains are
                                  ///< not errors
    std::uint64_t samples = 0, most_samples = 0;
    std::size_t words = 0;
    bool holds = false;
};
/// Compares words and beauty. `magnitude`: light_magnitude (stored_precision.h); 2^-45 of it is added to the bound.
Result<AtlasCheck> check_atlas(AtlasSource& source, double magnitude = 0);

}  // namespace raylex::display
