#include "transport/files/images/image.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "display/services/elementary.h"
#include "display/services/parameters.h"
#include "transport/files/images/image_readers.h"
#include "transport/files/input_file.h"

namespace raylex::transport {

namespace {

std::string lower_extension(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

bool starts_with(const std::string& content, std::string_view magic) {
    return content.compare(0, magic.size(), magic) == 0;
}

/// The error for an image format that raylex does not read.
std::string unread_format(const std::string& content) {
    static constexpr std::pair<std::string_view, const char*> known[] = {
        {"GIF8", "GIF"},        {"8BPS", "Photoshop (PSD)"}, {"P5", "PGM"},   {"P6", "PPM"},
        {{"II*\0", 4}, "TIFF"}, {{"MM\0*", 4}, "TIFF"},      {"DDS ", "DDS"}, {"RIFF", "WebP"}};
    for (const auto& [magic, name] : known)
        if (starts_with(content, magic)) return std::string(name) + " images are not supported";
    return "unknown image format";
}

}  // namespace

// IEC 61966-2-1 for sRGB.
float Encoding::decode(double stored) const {
    switch (kind) {
        case Kind::linear:
            return static_cast<float>(stored);
        case Kind::gamma:
            return static_cast<float>(elementary::pow(stored, exponent));
        case Kind::srgb:
            break;
    }
    return static_cast<float>(stored <= 0.04045 ? stored / 12.92 : elementary::pow((stored + 0.055) / 1.055, 2.4));
}

Result<Encoding> parse_encoding(const std::string& text) {
    if (text.empty() || text == "sRGB") return Encoding{};
    if (text == "linear") return Encoding{Encoding::Kind::linear, 1};
    constexpr std::string_view prefix = "gamma ";
    if (starts_with(text, prefix)) {
        double exponent = 0;
        const char* const end = text.data() + text.size();
        const auto [stop, status] = std::from_chars(text.data() + prefix.size(), end, exponent);
        if (status == std::errc() && stop == end && exponent > 0 && std::isfinite(exponent))
            return Encoding{Encoding::Kind::gamma, exponent};
    }
    return Error{
        "unknown image encoding '" + text + "'; expected sRGB, linear or gamma <exponent above 0>", {}, 0, 0, {}, {}};
}

// The content decides, not the file name: only TGA has no magic number.
Result<Image> read_image(const std::string& path, const std::string& encoding) {
    const Result<Encoding> decoding = parse_encoding(encoding);
    if (!decoding) {
        Error error = decoding.error();
        error.file = path;
        return error;
    }
    const Result<std::string> content = read_file(path, NamedBy::file, "an image");
    if (!content) return content.error();
    if (starts_with(*content, "\x76\x2f\x31\x01")) return read_exr_image(path);
    if (starts_with(*content, "PF") || starts_with(*content, "Pf")) return read_pfm(*content, path);
    if (starts_with(*content, "\x89PNG")) return read_png(*content, path, *decoding);
    if (starts_with(*content, "\xff\xd8")) return read_jpeg(*content, path, *decoding);
    if (starts_with(*content, "qoif"))
        return read_qoi(*content, path, encoding.empty() ? std::nullopt : std::optional(*decoding));
    if (!starts_with(*content, "#?") && !starts_with(*content, "BM") && lower_extension(path) != ".tga")
        return Error{
            unread_format(*content) + "; expected PNG, JPEG, TGA, BMP, QOI, HDR, OpenEXR or PFM", path, 0, 0, {}, {}};
    return read_with_stb(*content, path, *decoding);
}

std::optional<std::string> clear_invalid_texels(Image& image, NegativeTexels negative) {
    const auto channels = static_cast<std::size_t>(image.channels), width = static_cast<std::size_t>(image.width);
    std::size_t values = 0, texels = 0, first = 0, last = image.pixels.size();
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        float& value = image.pixels[i];
        if (std::isfinite(value) && (value >= 0 || negative == NegativeTexels::kept)) continue;
        value = 0;
        const std::size_t texel = i / channels;
        if (values == 0) first = texel;
        if (texel != last) ++texels;
        last = texel;
        ++values;
    }
    if (values == 0) return std::nullopt;
    return std::to_string(values) + (values == 1 ? " value" : " values") + " in " + std::to_string(texels) +
           (texels == 1 ? " texel" : " texels") +
           (negative == NegativeTexels::kept ? " not finite" : " negative or not finite") + ", first at column " +
           std::to_string(first % width) + ", row " + std::to_string(first / width) + "; taken as 0";
}

}  // namespace raylex::transport
