// Channel files of other tools: RIB DisplayChannel lines, USD ASCII RenderVar prims, rendermn.ini macros. Other content
// of a channel (pixel filters, statistics, attributes of a prim) is kept and written back.
//
// Reading needs neither the tool that wrote the file nor a scene. For any bytes, reading takes time proportional to the
// size of the file, which limits.h limits.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/language/extensions.h"
#include "lpe/language/names.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

enum class ChannelFormat : std::uint8_t { rib, usda, ini };

/// A channel with the text around its expression.
struct FileChannel {
    ChannelSource source;        ///< name and expression; its map gives positions in the file
    std::string type = "color";  ///< in the notation of the format: "color", "varying color", "color3f"
    std::string comment;         ///< comment lines directly above, without comment marks, joined by '\n'
    /// Everything else that the file contains for the channel, verbatim: parameters of a DisplayChannel ("\"string
    /// filter\" \"box\""), attributes of a prim ("token driver:parameters:aov:format = \"color3h\"").
    std::vector<std::string> parameters;
    std::string prim_metadata;  ///< usda: the (...) after the prim's name, verbatim
};

/// An option such as `lpe:diffuse2 = "Diffuse,HairDiffuse"`; see lobe_slots.h.
struct LobeOption {
    std::string slot;   ///< "diffuse2"
    std::string names;  ///< "Diffuse,HairDiffuse"
    std::string origin;
    int line = 0, column = 0;  ///< of the first byte of `names`
};

struct ChannelFile {
    std::vector<FileChannel> channels;
    std::vector<ChannelSource> macros;
    std::vector<LobeOption> lobe_options;
    /// Channels without an expression (depth, normals, ...). The `expression` of their source is the variable: "Nn" of
    /// "normal Nn".
    std::vector<FileChannel> other_channels;
    std::vector<std::string> warnings;
};

/// Determines the format from the file name (.rib, .usda, .usd, .ini), or else from the beginning of the text. Errors:
/// neither identifies a format; binary USD or RIB.
Result<ChannelFormat> channel_format(std::string_view path, std::string_view text);

/// Parses a channel file. Errors contain `origin`, line and column.
Result<ChannelFile> parse_channel_file(std::string_view text, const std::string& origin, ChannelFormat format);

/// The statistics of a channel: "mse" for `"string statistics" ["mse"]`, "variance" for `string ...:statistics =
/// "variance"`; otherwise empty. Such a channel contains the spread of another channel, not light.
[[nodiscard]] std::string statistics_of(const FileChannel& channel);

/// Parameters that a format cannot store ("filter"), each with the channels that have it.
using LeftOut = std::map<std::string, std::vector<std::string>>;
/// Adds a parameter, in the notation of its file, to `left`.
void leave_out(const FileChannel& channel, const std::string& parameter, LeftOut& left);
/// The list as text: "filter ('a', 'b'), filterwidth ('a')"; of many channels only the first ones and the number of the
/// others.
[[nodiscard]] std::string left_out_text(const LeftOut& left);

/// The text of a channel file. Names that the format cannot store are changed (usda: the name of the prim; an attribute
/// keeps the channel's name). For RenderMan (`reader`) expressions are written without blanks and comments. Errors: an
/// expression that RenderMan does not support, a dialect that the format cannot store, a name that cannot be written.
/// `warnings` lists what was left out.
Result<std::string> write_channel_file(const ChannelFile& file, ChannelFormat format,
                                       std::vector<std::string>& warnings, Reader reader = Reader::renderman);

// One parser per format; parse_channel_file() and write_channel_file() select the format.
[[nodiscard]] ChannelFile parse_rib(std::string_view text, const std::string& origin);   ///< throws Failure
[[nodiscard]] ChannelFile parse_usda(std::string_view text, const std::string& origin);  ///< throws Failure
[[nodiscard]] ChannelFile parse_ini(std::string_view text, const std::string& origin);   ///< throws Failure

}  // namespace raylex::lpe
