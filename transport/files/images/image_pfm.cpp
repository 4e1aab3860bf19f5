#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "display/services/parameters.h"
#include "lpe/input/budgets.h"
#include "transport/files/images/image_readers.h"

namespace raylex::transport {

namespace {

/// The header is four words; exactly one blank separates the last from the data.
class PfmHeader {
  public:
    explicit PfmHeader(const std::string& content) : content_(content) {}

    std::string_view word() {
        while (at_ < content_.size() && is_blank(content_[at_])) ++at_;
        const std::size_t begin = at_;
        while (at_ < content_.size() && !is_blank(content_[at_])) ++at_;
        return std::string_view(content_).substr(begin, at_ - begin);
    }
    [[nodiscard]] std::size_t data_begin() const { return at_ + 1; }

  private:
    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

    const std::string& content_;
    std::size_t at_ = 0;
};

template <class T>
bool parse_whole(std::string_view word, T& value) {
    const auto [stop, status] = std::from_chars(word.data(), word.data() + word.size(), value);
    return status == std::errc() && stop == word.data() + word.size();
}

float load_float(const char* from, bool swap) {
    char bytes[4];
    for (std::size_t i = 0; i < 4; ++i) bytes[i] = from[swap ? 3 - i : i];
    float value;
    std::memcpy(&value, bytes, 4);
    return value;
}

}  // namespace

Result<Image> read_pfm(const std::string& content, const std::string& path) {
    const auto failure = [&path](std::string message) { return error_at({path, 0, 0}, std::move(message)); };
    PfmHeader header(content);
    Image image;
    image.channels = header.word() == "PF" ? 3 : 1;
    double scale = 0;
    if (!parse_whole(header.word(), image.width) || !parse_whole(header.word(), image.height) || image.width <= 0 ||
        image.height <= 0)
        return failure("PFM header has no size; expected a width and a height above 0");
    if (!parse_whole(header.word(), scale) || scale == 0 || !std::isfinite(scale))
        return failure("PFM header has no scale; expected a number other than 0, negative for little-endian data");
    const std::string size = std::to_string(image.width) + " x " + std::to_string(image.height);
    if (static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height) >
        budget(Budget::image_pixels))
        return over_budget(Budget::image_pixels, "the image has " + size + " pixels", path);
    const std::uint64_t row = static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.channels);
    const std::uint64_t count = row * static_cast<std::uint64_t>(image.height);
    const std::uint64_t left = content.size() > header.data_begin() ? content.size() - header.data_begin() : 0;
    if (left / 4 < count)
        return failure("PFM file is truncated: found " + std::to_string(left) + " bytes of pixels, expected " +
                       std::to_string(count * 4));
    const bool swap = (scale < 0) != (std::endian::native == std::endian::little);
    const float factor = static_cast<float>(std::abs(scale));
    image.pixels.resize(count);
    const char* data = content.data() + header.data_begin();
    for (std::uint64_t y = 0; y < static_cast<std::uint64_t>(image.height); ++y) {
        float* target = image.pixels.data() + (static_cast<std::uint64_t>(image.height) - 1 - y) * row;
        for (std::uint64_t i = 0; i < row; ++i) target[i] = load_float(data + 4 * (y * row + i), swap) * factor;
    }
    return image;
}

}  // namespace raylex::transport
