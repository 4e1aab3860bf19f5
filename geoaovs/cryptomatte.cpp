#include "geoaovs/cryptomatte.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <set>
#include <utility>

#include "display/services/parameters.h"

namespace raylex::geoaovs {
namespace {

struct KindNames {
    const char* word;   // in jobs and flags
    const char* layer;  // in files
};
constexpr std::array kinds{KindNames{"object", "CryptoObject"}, KindNames{"material", "CryptoMaterial"},
                           KindNames{"asset", "CryptoAsset"}};

std::string hexadecimal(std::uint32_t value) {
    std::array<char, 9> text{};
    std::snprintf(text.data(), text.size(), "%08x", static_cast<unsigned>(value));
    return text.data();
}

/// Number of bytes of the UTF-8 character at `at`; 0 if it is invalid (overlong forms and surrogates are invalid).
std::size_t utf8_length(std::string_view text, std::size_t at) {
    const auto byte = [&](std::size_t i) {
        return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0u;
    };
    const unsigned first = byte(0);
    const std::size_t length = first < 0x80   ? 1
                               : first < 0xc2 ? 0
                               : first < 0xe0 ? 2
                               : first < 0xf0 ? 3
                               : first < 0xf5 ? 4
                                              : 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte(i) & 0xc0) != 0x80) return 0;
    const bool wrong = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xed && byte(1) > 0x9f) ||
                       (first == 0xf0 && byte(1) < 0x90) || (first == 0xf4 && byte(1) > 0x8f);
    return wrong ? 0 : length;
}

/// The text as a JSON string. U+FFFD replaces bytes that are not UTF-8.
std::string quoted(std::string_view text) {
    std::string result = "\"";
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = utf8_length(text, at);
        const auto byte = static_cast<unsigned char>(text[at]);
        if (length == 0) {
            result += "\\ufffd";
        } else if (byte == '"' || byte == '\\') {
            result += '\\';
            result += text[at];
        } else if (byte < 0x20) {
            result += "\\u" + hexadecimal(byte).substr(4);
        } else {
            result += text.substr(at, length);
        }
        at += std::max<std::size_t>(length, 1);
    }
    return result + "\"";
}

std::vector<std::uint32_t> ids_by_surface(const MatteNames& names) {
    std::vector<std::uint32_t> hashed;
    for (const std::string& name : names.names) hashed.push_back(matte_id(name));
    std::vector<std::uint32_t> ids{0};
    ids.reserve(names.of_surface.size() + 1);
    for (const std::uint32_t name : names.of_surface) ids.push_back(hashed[name]);
    return ids;
}

}  // namespace

std::uint32_t murmur_hash3(std::string_view bytes) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])); };
    const auto scrambled = [](std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
    std::uint32_t h = 0;
    const std::size_t whole = bytes.size() / 4 * 4;
    for (std::size_t i = 0; i < whole; i += 4) {
        h ^= scrambled(byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
        h = std::rotl(h, 13) * 5 + 0xe6546b64u;
    }
    std::uint32_t tail = 0;
    for (std::size_t i = bytes.size(); i > whole; --i) tail = tail << 8 | byte(i - 1);
    if (bytes.size() > whole) h ^= scrambled(tail);
    h ^= static_cast<std::uint32_t>(bytes.size());
    h ^= h >> 16;
    h *= 0x85ebca6bu;
    h ^= h >> 13;
    h *= 0xc2b2ae35u;
    return h ^ h >> 16;
}

std::uint32_t matte_id(std::string_view name) {
    const std::uint32_t hash = murmur_hash3(name), exponent = hash >> 23 & 255;
    return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

Result<MatteKind> parse_matte_kind(std::string_view name, const std::string& where) {
    std::vector<std::string> known;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        if (name == kinds[i].word) return static_cast<MatteKind>(i);
        known.emplace_back(kinds[i].word);
    }
    return error_at({where, 0, 0},
                    "'" + std::string(name) + "' is not a kind of cryptomatte; expected object, material or asset",
                    near_miss(name, known));
}

std::string matte_layer(MatteKind kind) {
    return kinds[static_cast<std::size_t>(kind)].layer;
}

Cryptomatte::Cryptomatte(MatteKind kind, int ranks, int width, int height, const MatteNames& names)
    : kind_(kind), ranks_(ranks), coverage_(width, height, ids_by_surface(names)) {
    std::map<std::uint32_t, std::string> by_id;
    for (const std::string& name : names.names) {
        const std::uint32_t id = matte_id(name);
        if (!names_.emplace(name, id).second) continue;
        const auto [other, fresh] = by_id.emplace(id, name);
        if (!fresh) collisions_.emplace_back(other->second, name);
    }
}

std::vector<std::string> Cryptomatte::names() const {
    std::vector<std::string> result;
    for (const auto& [name, id] : names_) result.push_back(name);
    return result;
}

std::vector<std::string> Cryptomatte::planes() const {
    std::vector<std::string> result;
    for (int rank = 0; rank < ranks_; ++rank) {
        const int layer = rank / 2;
        const std::string prefix = name() + (layer < 10 ? "0" : "") + std::to_string(layer);
        for (const char* plane : rank % 2 == 0 ? std::array{".R", ".G"} : std::array{".B", ".A"})
            result.push_back(prefix + plane);
    }
    return result;
}

std::vector<float> Cryptomatte::values(int first, int end) const {
    const auto width = static_cast<std::size_t>(coverage_.width());
    const std::size_t before = static_cast<std::size_t>(first) * width,
                      pixels = static_cast<std::size_t>(end - first) * width;
    std::vector<display::RankedCoverage::Rank> found(static_cast<std::size_t>(ranks_));
    std::vector<float> result(2 * found.size() * pixels);
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        coverage_.resolve(before + pixel, found);
        for (std::size_t rank = 0; rank < found.size(); ++rank) {
            result[2 * rank * pixels + pixel] = std::bit_cast<float>(found[rank].id);
            result[(2 * rank + 1) * pixels + pixel] = static_cast<float>(found[rank].coverage);
        }
    }
    return result;
}

std::string Cryptomatte::manifest() const {
    std::set<std::uint32_t> shown;
    const bool all = names_.size() <= most_manifest_names;
    if (!all) coverage_.for_each_id([&](std::uint32_t id) { shown.insert(id); });
    std::string text = "{";
    for (const auto& [name, id] : names_) {
        if (!all && !shown.contains(id)) continue;
        if (text.size() > 1) text += ",";
        text += quoted(name);
        text += ":\"";
        text += hexadecimal(id);
        text += "\"";
    }
    return text + "}";
}

std::map<std::string, std::string> Cryptomatte::attributes() const {
    // Any key of at most 7 characters is valid if it is the same in every frame; the specification suggests a hash of
    // the name.
    const std::string prefix = "cryptomatte/" + hexadecimal(murmur_hash3(name())).substr(0, 7) + "/";
    const Remainder left = remainder();
    std::array<char, 128> summary{};
    std::snprintf(summary.data(), summary.size(), "%d ranks; left out: at most %.3g of a pixel, %zu pixels above 1e-4",
                  ranks_, left.largest, left.pixels);
    return {{prefix + "name", name()},
            {prefix + "hash", "MurmurHash3_32"},
            {prefix + "conversion", "uint32_to_float32"},
            {prefix + "manifest", manifest()},
            {"raylex/" + name(), summary.data()}};
}

Cryptomatte::Remainder Cryptomatte::remainder() const {
    const std::size_t pixels =
        static_cast<std::size_t>(coverage_.width()) * static_cast<std::size_t>(coverage_.height());
    std::vector<display::RankedCoverage::Rank> found(static_cast<std::size_t>(ranks_));
    Remainder result;
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        const double left = coverage_.resolve(pixel, found);
        result.largest = std::max(result.largest, left);
        result.mean += left / static_cast<double>(pixels);
        if (left > 1e-4) ++result.pixels;
    }
    return result;
}

}  // namespace raylex::geoaovs
