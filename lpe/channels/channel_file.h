// Channels as other tools keep them: RIB DisplayChannel lines, USD ASCII RenderVar prims, rendermn.ini macros. What a
// file says beside expressions (pixel filters, statistics, attributes of a prim) is kept and written back.
//
// A file is read without the tool that wrote it and without a scene. Whatever its bytes are, reading takes time in
// proportion to its size, which limits.h bounds.
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

/// A channel with what stands around its expression.
struct FileChannel {
    ChannelSource source;        ///< name and expression; its map leads to the bytes of the file
    std::string type = "color";  ///< as the format says it: "color", "varying color", "color3f"
    std::string comment;         ///< lines of comment directly above, without their marks, '\n' between them
    /// What else the file says of the channel, word for word: parameters of a DisplayChannel ("\"string filter\"
    /// \"box\""), attributes of a prim ("token driver:parameters:aov:format = \"color3h\"").
    std::vector<std::string> parameters;
    std::string prim_metadata;  ///< usda: the (...) behind the prim's name, word for word
};

/// An option such as `lpe:diffuse2 = "Diffuse,HairDiffuse"`; lobe_slots.h says what it means.
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
    /// Channels without an expression (depth, normals, ...): the source's is what they hold, "Nn" of "normal Nn".
    std::vector<FileChannel> other_channels;
    std::vector<std::string> warnings;
};

/// By the file's name (.rib, .usda, .usd, .ini), else by how the text begins. Errors: neither tells; USD or RIB in its
/// binary form.
Result<ChannelFormat> channel_format(std::string_view path, std::string_view text);

/// Errors carry `origin`, line and column.
Result<ChannelFile> parse_channel_file(std::string_view text, const std::string& origin, ChannelFormat format);

/// "mse" of `"string statistics" ["mse"]`, "variance" of `string ...:statistics = "variance"`; else empty. Such
/// channels hold the spread of another one, not light.
[[nodiscard]] std::string statistics_of(const FileChannel& channel);

/// What a format has no place for: names of parameters ("filter"), each with the channels that have it.
using LeftOut = std::map<std::string, std::vector<std::string>>;
/// Adds a channel's parameter, as its file has it.
void leave_out(const FileChannel& channel, const std::string& parameter, LeftOut& left);
/// "filter ('a', 'b'), filterwidth ('a')"; of many channels the first and how many more.
[[nodiscard]] std::string left_out_text(const LeftOut& left);

/// The file's text. Names that the format cannot hold are changed into ones it can (usda: the prim's name; the
/// channel's own name stays in an attribute). For RenderMan (`reader`) expressions are written without blanks and
/// comments, and one that RenderMan does not read is an error. Errors: expressions in a dialect that the format cannot
/// hold, a name that cannot be written. `warnings` gets what was left out.
Result<std::string> write_channel_file(const ChannelFile& file, ChannelFormat format,
                                       std::vector<std::string>& warnings, Reader reader = Reader::renderman);

// One per format; parse_channel_file and write_channel_file choose.
[[nodiscard]] ChannelFile parse_rib(std::string_view text, const std::string& origin);   ///< throws Failure
[[nodiscard]] ChannelFile parse_usda(std::string_view text, const std::string& origin);  ///< throws Failure
[[nodiscard]] ChannelFile parse_ini(std::string_view text, const std::string& origin);   ///< throws Failure

}  // namespace raylex::lpe
