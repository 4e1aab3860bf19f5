// Splits made to measure: channels that sort every path into one bin an axis, a partition by construction and proved to
// be one before anybody sees it.
//
// A path is a camera, scattering events and a terminal. Where light comes from (group, kind of terminal) is read off
// the terminal; what it was scattered by (lobe, object) off the first scattering event; the bounce is the number of
// scattering events. Light seen without any is in the bin `visible` of all axes of scattering.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"
#include "lpe/words.h"

namespace raylex::lpe {

enum class SplitAxis : std::uint8_t {
    light_group,  ///< one bin a group; `default` for lights without one of them, and for emission
    lobe,    ///< of the first scattering: type and scatter, lobe numbers, or lobe names; `other` for what is not listed
    bounce,  ///< 1, 2, ..., the last one open-ended; `direct` and `indirect` when there are two
    object,  ///< label of the first object; `other` for objects not listed
    terminal  ///< `lights`, `background`, `emission`
};

/// "light-group", "lobe", "bounce", "object", "terminal". Errors: another word, with its near miss.
Result<SplitAxis> parse_split_axis(std::string_view text);

struct SplitRequest {
    std::vector<SplitAxis> by;        ///< in the order in which they make names: light-group, lobe: "key_diffuse"
    std::vector<std::string> groups;  ///< light groups; needed by `light_group`
    /// RD, RS, S4, T, V, R[GS], each of them also as NAME=EVENT; or else lobe names such as coat. Where events overlap
    /// the earlier one has them: S4,S is the clear coat and all other specular lobes. Empty: RD, RS, TD, TS and V.
    std::vector<std::string> lobes;
    std::vector<std::string> objects;  ///< object labels; needed by `object`
    int bounces = 3;                   ///< bins of `bounce`, 1 to 64
    std::optional<ChannelSource> of;   ///< what is split; the beauty when absent
    Dialect dialect = Dialect::renderman;
    std::string prefix;  ///< of every name
    Words words;         ///< what the proof is relative to; bins that no word of it is in are left out
};

struct Split {
    std::vector<ChannelSource> channels;  ///< names fit for layers: letters, digits, _ and -
    std::optional<ChannelSource> of;      ///< what is split, names resolved, where it is less than the beauty
    std::string summary;                  ///< the proof's sentence
    std::vector<std::string> notes;
};

/// Errors: an axis twice or without its list, lobes that do not read or are covered by earlier ones, names that fall
/// together, what a dialect cannot say (osl: lights without a label, unless words.unlabelled_lights is false; objects
/// and lobe names), and a split whose proof fails.
Result<Split> generate_split(const SplitRequest& request);

}  // namespace raylex::lpe
