#include "lpe/channels/channel_file.h"

#include <algorithm>
#include <utility>

#include "lpe/channels/channel_errors.h"
#include "lpe/channels/file_text.h"
#include "lpe/failure.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

bool ends_with_any(std::string_view path, std::initializer_list<std::string_view> endings) {
    return std::any_of(endings.begin(), endings.end(), [&](std::string_view ending) { return path.ends_with(ending); });
}

[[noreturn]] void fail_in(const std::string& origin, std::string message, std::string hint = {}) {
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    error.file = origin;
    throw Failure{std::move(error)};
}

ChannelFormat find_format(std::string_view path, std::string_view text) {
    const std::string origin(path);
    if (text.starts_with("PXR-USDC") || ends_with_any(path, {".usdc", ".usdz"})) {
        fail_in(origin, "this file is binary USD; expected .usda text", "convert it: 'usdcat IN -o OUT.usda'");
    }
    if (text.starts_with("\x1f\x8b")) {
        fail_in(origin, "this file is compressed; expected plain text", "convert it with 'gunzip' or 'catrib -ascii'");
    }
    if (text.starts_with("#usda") || ends_with_any(path, {".usda", ".usd"})) { return ChannelFormat::usda; }
    if (ends_with_any(path, {".rib"})) { return ChannelFormat::rib; }
    if (ends_with_any(path, {".ini"})) { return ChannelFormat::ini; }
    if (text.starts_with("##RenderMan RIB") || text.find("DisplayChannel") != std::string_view::npos) {
        return ChannelFormat::rib;
    }
    if (text.find("/prman/lpe/") != std::string_view::npos) { return ChannelFormat::ini; }
    fail_in(origin, "unknown kind of channel file; expected .toml, .rib, .usda or .ini", "name the kind with --format");
}

ChannelFile parse_any(std::string_view text, const std::string& origin, ChannelFormat format) {
    if (text.size() > limits::channel_file_bytes) {
        fail_in(origin, "the file has " + std::to_string(text.size()) + " bytes; at most " +
                            std::to_string(limits::channel_file_bytes) + " are read");
    }
    switch (format) {
        case ChannelFormat::rib:
            return parse_rib(text, origin);
        case ChannelFormat::usda:
            return parse_usda(text, origin);
        case ChannelFormat::ini:
            break;
    }
    return parse_ini(text, origin);
}

}  // namespace

Result<ChannelFormat> channel_format(std::string_view path, std::string_view text) {
    return guarded([&] { return find_format(path, text); });
}

Result<ChannelFile> parse_channel_file(std::string_view text, const std::string& origin, ChannelFormat format) {
    return guarded([&] { return parse_any(text, origin, format); });
}

Result<ChannelFile> parse_channels(std::string_view text, const std::string& origin, ChannelFormat format,
                                   std::vector<Error>& errors) {
    return guarded([&]() -> ChannelFile {
        try {
            return parse_any(text, origin, format);
        } catch (ChannelErrors& wrong) {
            errors.insert(errors.end(), wrong.errors.begin(), wrong.errors.end());
            return std::move(wrong.file);
        }
    });
}

std::string statistics_of(const FileChannel& channel) {
    for (const std::string& parameter : channel.parameters) {
        const std::size_t at = parameter.find("statistics");
        if (at == std::string::npos) { continue; }
        for (const std::string_view kind : statistics_names) {
            if (parameter.find("\"" + std::string(kind) + "\"", at) != std::string::npos) { return std::string(kind); }
        }
    }
    return {};
}

void leave_out(const FileChannel& channel, const std::string& parameter, LeftOut& left) {
    // RIB: "string filter" "gaussian". USD: token driver:parameters:filter = "gaussian".
    const bool rib = parameter.starts_with('"');
    std::string name = parameter.substr(rib ? 1 : 0, parameter.find(rib ? '"' : '=', 1) - (rib ? 1 : 0));
    while (name.ends_with(' ')) { name.pop_back(); }
    left[name.substr(name.find_last_of(" \t") + 1)].push_back(channel.source.name);
}

std::string left_out_text(const LeftOut& left) {
    constexpr std::size_t most = 8;
    std::string text;
    for (const auto& [parameter, channels] : left) {
        text += (text.empty() ? "" : ", ") + parameter + " (";
        for (std::size_t k = 0; k < std::min(channels.size(), most); ++k) {
            text += (k == 0 ? "'" : ", '") + channels[k] + "'";
        }
        text += (channels.size() > most ? " and " + std::to_string(channels.size() - most) + " more" : "") + ")";
    }
    return text;
}

}  // namespace raylex::lpe
