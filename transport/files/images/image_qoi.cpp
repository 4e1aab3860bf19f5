// QOI, after its specification (qoiformat.org, version 1.0): chunks of one to five bytes. Each is a pixel, coded
// relative to earlier pixels, or a run of the last one.
#include <algorithm>
#include <array>
#include <limits>

#include "transport/files/images/image_readers.h"

namespace raylex::transport {

namespace {

using Pixel = std::array<std::uint8_t, 4>;

constexpr std::size_t header_bytes = 14;
constexpr std::string_view end_marker("\0\0\0\0\0\0\0\1", 8);

class QoiReader {
  public:
    /// `content` contains at least a header.
    explicit QoiReader(const std::string& content) : content_(content) {}

    [[nodiscard]] std::uint8_t byte(std::size_t i) const { return static_cast<std::uint8_t>(content_[i]); }
    [[nodiscard]] std::uint32_t big_endian(std::size_t i) const {
        return std::uint32_t{byte(i)} << 24 | std::uint32_t{byte(i + 1)} << 16 | std::uint32_t{byte(i + 2)} << 8 |
               std::uint32_t{byte(i + 3)};
    }
    /// Returns false if the chunks end before `samples` is full, or if a run continues beyond it.
    bool read(std::span<std::uint8_t> samples, std::size_t channels) {
        if (!content_.ends_with(end_marker) || content_.size() < header_bytes + end_marker.size()) return false;
        end_ = content_.size() - end_marker.size();
        for (std::size_t i = 0; i < samples.size();) {
            std::size_t run = 1;
            if (!read_chunk(run) || run * channels > samples.size() - i) return false;
            for (; run > 0; --run, i += channels)
                std::copy_n(pixel_.begin(), channels, samples.begin() + static_cast<std::ptrdiff_t>(i));
        }
        return true;
    }

  private:
    bool read_chunk(std::size_t& run) {
        if (at_ >= end_) return false;
        const std::uint8_t first = byte(at_++), low = first & 63;
        if (first >= 0xfe) {
            const std::size_t count = first == 0xfe ? 3 : 4;
            if (count > end_ - at_) return false;
            for (std::size_t c = 0; c < count; ++c) pixel_[c] = byte(at_++);
        } else if (first >= 0xc0) {
            run = std::size_t{low} + 1;
        } else if (first >= 0x80) {
            if (at_ >= end_) return false;
            const std::uint8_t second = byte(at_++);
            const int green = low - 32;
            add(green + (second >> 4) - 8, green, green + (second & 15) - 8);
        } else if (first >= 0x40) {
            add((low >> 4) - 2, (low >> 2 & 3) - 2, (low & 3) - 2);
        } else {
            pixel_ = seen_[low];
        }
        seen_[(pixel_[0] * 3u + pixel_[1] * 5u + pixel_[2] * 7u + pixel_[3] * 11u) % seen_.size()] = pixel_;
        return true;
    }
    /// Adds differences to the pixel; they wrap around.
    void add(int red, int green, int blue) {
        const std::array<int, 3> by{red, green, blue};
        for (std::size_t c = 0; c < 3; ++c) pixel_[c] = static_cast<std::uint8_t>(pixel_[c] + by[c]);
    }

    const std::string& content_;
    std::size_t at_ = header_bytes, end_ = header_bytes;
    Pixel pixel_{0, 0, 0, 255};
    std::array<Pixel, 64> seen_{};
};

}  // namespace

Result<Image> read_qoi(const std::string& content, const std::string& path, const std::optional<Encoding>& encoding) {
    const auto failure = [&path](const char* reason) { return undecodable(reason, path); };
    if (content.size() < header_bytes) return failure("QOI is truncated; expected a header of 14 bytes");
    QoiReader reader(content);
    const std::uint32_t width = reader.big_endian(4), height = reader.big_endian(8);
    const std::size_t channels = reader.byte(12);
    const int space = reader.byte(13);
    constexpr std::uint32_t most = std::numeric_limits<int>::max();
    if (width == 0 || height == 0 || width > most || height > most)
        return failure("the QOI header has no size; expected a width and a height from 1 to 2147483647");
    if (channels != 3 && channels != 4) return failure("QOI has other than 3 or 4 channels");
    if (space > 1) return failure("QOI is of an unknown colour space; expected 0 (sRGB) or 1 (linear)");
    if (Status fits =
            check_unpacked_size(static_cast<int>(width), static_cast<int>(height), channels, content.size(), path);
        !fits)
        return fits.error();
    constexpr std::uint64_t longest_run = 62;
    if (std::uint64_t{width} * height > longest_run * content.size())  // checked before memory is allocated
        return failure("QOI is truncated; expected as many pixels as its header states");
    std::vector<std::uint8_t> samples(std::size_t{width} * height * channels);
    if (!reader.read(samples, channels))
        return failure("QOI is truncated or damaged; expected as many pixels as its header states, and its end marker");
    return from_integers(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channels), samples,
                         encoding.value_or(Encoding{space == 0 ? Encoding::Kind::srgb : Encoding::Kind::linear, 1}));
}

}  // namespace raylex::transport
