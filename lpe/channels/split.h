// Generates splits: channels that sort every path into one bin per axis. They are a partition by construction, and a
// proof confirms this before the split is returned.
//
// A path is a camera, scattering events and a terminal. The terminal determines the light group and the kind of
// terminal. The first scattering event determines lobe and object. The number of scattering events is the bounce. Light
// without scattering is in the bin `visible` of the axes lobe, bounce and object.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/path_strings.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

enum class SplitAxis : std::uint8_t {
    light_group,  ///< one bin per group; `default` for lights in none of the groups, and for emission
    lobe,         ///< first scattering event: type and scatter, lobe number, or lobe name; `other` for the rest
    bounce,       ///< 1, 2, ..., the last open-ended; with two bins `direct` and `indirect`
    object,       ///< label of the first object; `other` for the rest
    terminal      ///< `lights`, `background`, `emission`
};

/// Parses an axis: "light-group", "lobe", "bounce", "object", "terminal". Errors: another word; the error suggests a
/// similar one.
Result<SplitAxis> parse_split_axis(std::string_view text);

struct SplitRequest {
    std::vector<SplitAxis> by;        ///< in the order in which they form names: light-group, lobe: "key_diffuse"
    std::vector<std::string> groups;  ///< light groups; the axis `light_group` requires them
    /// Events (RD, RS, S4, T, V, R[GS]), each also as NAME=EVENT; or lobe names such as coat. Where events overlap the
    /// first one applies: S4,S is the clear coat and all other specular lobes. Empty: RD, RS, TD, TS and V.
    std::vector<std::string> lobes;
    std::vector<std::string> objects;  ///< object labels; the axis `object` requires them
    int bounces = 3;                   ///< bins of `bounce`, 1 to 64
    std::optional<ChannelSource> of;   ///< the expression to split; the beauty when absent
    Dialect dialect = Dialect::renderman;
    std::string prefix;               ///< prefix of every name
    std::string visible = "visible";  ///< bin of light that no event scattered
    PathStrings words;                ///< the W of the proof; bins without a word of it are left out
};

struct Split {
    std::vector<ChannelSource> channels;  ///< valid layer names: letters, digits, _ and -
    std::optional<ChannelSource> of;      ///< the expression to split, names resolved, if it is less than the beauty
    std::string summary;                  ///< summary of the proof
    std::vector<std::string> notes;
};

/// Returns a request for the layers that compositors rebuild a beauty from: light group, then direct or indirect, then
/// diffuse, specular, transmission, subsurface or volume; and `emission`, light that no event scattered. The group
/// `default` has the lights that are in none of `groups`, which may be empty.
[[nodiscard]] SplitRequest compositing_split(std::vector<std::string> groups, Dialect dialect, PathStrings words);

/// Generates the split. Errors: an axis that is repeated or lacks its list; lobes that do not parse or are covered by
/// earlier ones; names that become equal; a bin that the dialect cannot express (osl: lights without a label, unless
/// words.unlabelled_lights is false; objects and lobe names); a proof that fails.
Result<Split> generate_split(const SplitRequest& request);

}  // namespace raylex::lpe
