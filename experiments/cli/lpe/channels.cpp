// Reads the expressions and channels that the `raylex lpe` commands take as arguments.
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <utility>

#include "display/services/parameters.h"
#include "experiments/cli/expression_options.h"
#include "experiments/cli/lpe/commands.h"
#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

constexpr std::array<std::string_view, 5> file_endings{".rib", ".usda", ".usd", ".ini", ".toml"};

}  // namespace

lpe::Dialect DialectOption::value() const {
    return name == "osl" ? lpe::Dialect::osl : lpe::Dialect::renderman;
}

CLI::Option* add_dialect_option(CLI::App& command, DialectOption& dialect) {
    return command
        .add_option(
            "--dialect", dialect.name,
            "renderman (default) or osl; a prefix 'osl:' or 'renderman:' sets the dialect of a single expression")
        ->option_text("D")
        ->check(CLI::IsMember({"renderman", "osl"}));
}

CLI::Option* add_channel_files(CLI::App& command, ChannelArguments& arguments) {
    command
        .add_option("--format", arguments.format,
                    "format of the input files: toml, rib, usda or ini; default: by name and contents")
        ->option_text("F")
        ->check(CLI::IsMember(channel_format_names()));
    return command
        .add_option(
            "--channels", arguments.files,
            "file of channels: TOML tables, RIB DisplayChannel lines, USD ASCII RenderVar prims or rendermn.ini "
            "macros; may be repeated")
        ->option_text("FILE")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

CLI::Option* add_channel_arguments(CLI::App& command, ChannelArguments& arguments) {
    add_channel_files(command, arguments);
    // A name of CLI11 has no '='.
    return command
        .add_option("CHANNEL", arguments.named, "channels NAME=EXPR and channel files; channels of files come first")
        ->option_text("...");
}

Result<bool> is_channel_file(const std::string& text) {
    const bool ends_as_one = std::any_of(file_endings.begin(), file_endings.end(), [&](std::string_view ending) {
        return text.size() > ending.size() && text.ends_with(ending);
    });
    std::error_code failed;
    const bool exists = std::filesystem::exists(text, failed);
    if (!ends_as_one && std::filesystem::is_regular_file(text, failed) && text.find('=') == std::string::npos)
        return error_at({text, 0, 0},
                        "unknown file format; expected a file that ends in .toml, .rib, .usda, .usd or "
                        ".ini, or NAME=EXPR",
                        "'--channels " + text + " --format F' reads it as F: toml, rib, usda or ini");
    if (!ends_as_one) return false;
    const std::size_t equals = text.find('=');
    const bool named = equals != std::string::npos && equals > 0 && text.find('/') > equals;
    if (named && exists)
        return error_at({},
                        "'" + text + "' is a file name and also reads as NAME=EXPR; expected an unambiguous argument",
                        "'--channels " + text + "' or './" + text + "' means the file");
    if (named) return false;
    if (!exists) return error_at({text, 0, 0}, "this channel file does not exist");
    return true;
}

Status take_channel_files(ChannelArguments& arguments) {
    std::vector<std::string> named;
    for (std::string& text : arguments.named) {
        auto file = is_channel_file(text);
        if (!file) return file.error();
        (*file ? arguments.files : named).push_back(std::move(text));
    }
    arguments.named = std::move(named);
    return success();
}

Result<ChannelSet> read_channel_set(const ChannelArguments& arguments, lpe::Dialect dialect, bool every_error) {
    auto set = read_channel_files(arguments.files, arguments.format, dialect, every_error);
    if (!set) return set;
    for (const std::string& warning : set->file.warnings) print_warning(warning);
    for (const std::string& text : arguments.named) {
        auto request = parse_named_expression(text, dialect, "channel");
        if (!request) return request.error();
        lpe::FileChannel channel;
        channel.source = {request->name, request->expression, request->dialect, request->location.file, 0, 0, {}};
        set->file.channels.push_back(std::move(channel));
    }
    take_same_once(*set);
    if (!every_error && !set->errors.empty()) return set->errors.front();
    return set;
}

Result<std::vector<lpe::ChannelSource>> resolved_channels(const ChannelSet& set, const ChannelArguments& arguments) {
    if (set.file.channels.empty()) {
        std::string others;
        for (const lpe::FileChannel& each : set.file.other_channels)
            others += (others.empty() ? "" : ", ") + each.source.name;
        return error_at({arguments.files.empty() ? std::string() : arguments.files.front(), 0, 0},
                        "no channel with a light path expression; expected NAME=EXPR or a file of channels",
                        others.empty() ? "" : "channels without an expression: " + others);
    }
    std::vector<std::string> warnings;
    auto sources = expanded_channels(set, warnings);
    for (const std::string& warning : warnings) print_warning(warning);
    return sources;
}

Result<std::vector<lpe::ChannelSource>> read_channels(const ChannelArguments& arguments, lpe::Dialect dialect) {
    auto set = read_channel_set(arguments, dialect);
    if (!set) return set.error();
    return resolved_channels(*set, arguments);
}

Result<lpe::ChannelSource> channel_or_expression(const std::string& text, const ChannelArguments& arguments,
                                                 lpe::Dialect dialect, const std::string& what) {
    lpe::ChannelSource source = bare_expression(text, dialect, "", what);
    if (arguments.files.empty()) return source;
    auto set = read_channel_set(arguments, dialect);
    if (!set) return set.error();
    const ChannelSet all = *set;
    std::erase_if(set->file.channels, [&](const lpe::FileChannel& each) { return each.source.name != text; });
    if (set->file.channels.empty()) set->file.channels.emplace_back().source = std::move(source);
    std::vector<std::string> warnings;
    auto expanded = expanded_channels(*set, warnings);
    if (!expanded) return about_channel_name(expanded.error(), text, all);
    for (const std::string& warning : warnings) print_warning(warning);
    return std::move(expanded->front());
}

Error about_channel_name(Error error, const std::string& text, const ChannelSet& set) {
    const auto in_name = [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
               std::string_view("_-.:").find(c) != std::string::npos;
    };
    const bool of_text = error.excerpt == text;  // the error is in the text itself, not in a macro
    if (!of_text || set.file.channels.empty() || !std::all_of(text.begin(), text.end(), in_name)) return error;
    std::vector<std::string> names;
    std::string list;
    for (const lpe::FileChannel& each : set.file.channels) {
        if (each.source.name == text) return error;  // the channel exists, and its expression is wrong
        names.push_back(each.source.name);
        list += (list.empty() ? "" : ", ") + each.source.name;
    }
    if (const std::string near = near_miss(text, names); !near.empty()) error.hint = near;
    else if (text.find_first_of("-.:") == std::string::npos) error.hint = "known channels: " + list;
    return error;  // a text with a dot may be an expression
}

CLI::Option* add_reader_option(CLI::App& command, ReaderOption& reader) {
    return command
        .add_option("--for", reader.name,
                    "program that reads the channels: renderman (default for RIB, rendermn.ini, and USD in the dialect "
                    "renderman), which makes extensions that RenderMan lacks (V, B, G, ?, -, ...) an error; or raylex")
        ->option_text("renderman|raylex")
        ->check(CLI::IsMember({"renderman", "raylex"}));
}

void add_channel_output(CLI::App& command, ChannelOutput& output, const std::string& description) {
    command.add_option("-o,--output", output.path, description)->option_text("FILE.{toml,rib,usda,ini}");
    command.add_option("--write-as", output.format, "format to write; default: by the file name")
        ->option_text("F")
        ->check(CLI::IsMember(channel_format_names()));
}

Status write_channels(const ChannelSet& set, const ChannelOutput& output, lpe::Reader reader) {
    std::vector<std::string> warnings;
    auto text = channel_set_text(set, output.path, output.format, warnings, reader);
    if (!text) return text.error();
    if (Status written = write_channel_text(*text, output.path); !written) return written;
    for (const std::string& warning : warnings) print_warning(warning);
    return success();
}

lpe::ChannelSource bare_expression(std::string_view text, lpe::Dialect dialect, std::string name, std::string what) {
    lpe::ChannelSource source{std::move(name), std::string(text), dialect, std::move(what), 0, 0, {}};
    take_dialect_mark(source.expression, source.dialect);
    return source;
}

Error about_argument(Error error, const std::string& what, const std::string& text) {
    if (error.file.empty()) error.file = what;
    if (error.excerpt.empty() && text.find('\n') == std::string::npos) error.excerpt = text;
    if (error.line == 1) error.line = 0;  // an argument has only one line
    return error;
}

}  // namespace raylex::experiments
