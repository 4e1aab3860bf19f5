// The names of the prefixes of a renderman expression. The display services implement them.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace raylex::lpe {

inline constexpr std::array<std::string_view, 8> prefix_names{
    "unoccluded", "noclamp", "nothruput", "shadows", "holdouts", "overwrite", "noinfinitecheck", "unweighted"};

/// The sampling techniques that a prefix selects: `s2t3` those with 2 vertices from the light and 3 from the camera,
/// `beyond7` all with more than 7 vertices.
struct TechniquePrefix {
    std::uint32_t s = 0, t = 0;  ///< t == 0: `beyond` applies
    std::uint32_t beyond = 0;
    bool operator==(const TechniquePrefix&) const = default;
};
inline constexpr std::uint32_t most_technique_vertices = 9999;

/// Parses a technique prefix; nothing when the word is none. t is at least 1 for `s2t3`.
inline std::optional<TechniquePrefix> technique_prefix(std::string_view word) {
    const auto number = [&word](std::string_view mark, std::uint32_t& value) {
        if (!word.starts_with(mark)) return false;
        word.remove_prefix(mark.size());
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || value > most_technique_vertices) return false;
        word.remove_prefix(static_cast<std::size_t>(end - word.data()));
        return true;
    };
    TechniquePrefix prefix;
    if (word.starts_with("beyond")) {
        if (!number("beyond", prefix.beyond) || !word.empty()) return std::nullopt;
        return prefix;
    }
    if (!number("s", prefix.s) || !number("t", prefix.t) || !word.empty() || prefix.t == 0) return std::nullopt;
    return prefix;
}

}  // namespace raylex::lpe
