#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "lpe/channels/channel_file.h"
#include "lpe/channels/file_text.h"
#include "lpe/channels/lobe_slots.h"
#include "lpe/failure.h"
#include "lpe/language/source_text.h"

namespace raylex::lpe {

namespace {

[[noreturn]] void refuse(const ChannelSource& source, std::string message, std::string hint = {}) {
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    throw Failure{SourceText::whole_error(source, std::move(error))};
}

/// Replaces a line break inside an expression by a blank, and drops comments: formats of one line support neither.
/// RenderMan's language does not support blanks either.
std::string one_line(const ChannelSource& source, Reader reader) {
    std::string result;
    bool quote = false;
    for (std::size_t i = 0; i < source.expression.size(); ++i) {
        const char c = source.expression[i];
        quote = quote != (c == '\'' && (i == 0 || source.expression[i - 1] != '\\'));
        if (c == '#' && !quote && source.dialect == Dialect::renderman) {
            i = std::min(source.expression.find('\n', i), source.expression.size() - 1);
            continue;
        }
        const bool blank = c == '\n' || c == '\r' || c == ' ' || c == '\t';
        if (blank && !quote && reader == Reader::renderman) { continue; }
        result += c == '\n' || c == '\r' ? ' ' : c;
    }
    while (!result.empty() && result.back() == ' ') { result.pop_back(); }
    if (result.find_first_not_of(" \t") == std::string::npos) {
        refuse(source, "channel '" + source.name + "' contains only blanks and comments; expected an expression",
               "write a .toml or .usda file");
    }
    return result;
}

/// Adds the prefix "lpe:" to a text that already begins with one, because readers remove one.
std::string marked(const std::string& text) {
    return expression_offset(text) == std::string_view::npos ? text : "lpe:" + text;
}

void require_renderman(const ChannelSource& source, const char* format) {
    if (source.dialect != Dialect::renderman) {
        refuse(source,
               "channel '" + source.name + "' is in the osl dialect; " + format + " stores renderman expressions",
               "write a .toml or .usda file");
    }
}

class Writer {
  public:
    Writer(const ChannelFile& file, std::vector<std::string>& warnings, Reader reader)
        : file_(file), warnings_(warnings), reader_(reader) {}

    std::string rib() {
        std::string text = "##RenderMan RIB\nversion 3.04\n";
        for (const LobeOption& option : file_.lobe_options) {
            text += "Option \"lpe\" " + quoted("string " + option.slot) + " [" + quoted(option.names) + "]\n";
        }
        for (const FileChannel& channel : file_.channels) {
            require_renderman(channel.source, "RIB");
            const bool declared = channel.type.find("color3f") == std::string::npos;
            text += commented(channel.comment, "#");
            text += "DisplayChannel " + quoted((declared ? channel.type : "color") + " " + channel.source.name) +
                    " \"string source\" [" + quoted("color lpe:" + expression_of(channel.source)) + "]";
            for (const std::string& parameter : kept(channel, true)) { text += " " + parameter; }
            text += "\n";
        }
        for (const FileChannel& channel : file_.other_channels) {
            std::vector<std::string> parameters = kept(channel, true);
            const bool has_source = std::any_of(parameters.begin(), parameters.end(), [](const std::string& each) {
                // As in the reader, the last word of the declaration is the parameter's name, whatever its type.
                const std::string_view declared = std::string_view(each).substr(0, each.find('"', 1));
                return declared == "\"source" || declared.ends_with(" source") || declared.ends_with("\tsource");
            });
            if (!has_source && channel.source.expression != channel.source.name) {
                parameters.push_back("\"string source\" [" + quoted(channel.source.expression) + "]");
            }
            const std::string type = channel.type.substr(0, channel.type.find_first_of("0123456789"));
            text += commented(channel.comment, "#") + "DisplayChannel " + quoted(type + " " + channel.source.name);
            for (const std::string& parameter : parameters) { text += " " + parameter; }
            text += "\n";
        }
        finish("RIB");
        return text;
    }

    std::string ini() {
        std::string text;
        for (const LobeOption& option : file_.lobe_options) {
            if ((option.slot + option.names).find_first_of("\r\n") != std::string::npos || option.names.ends_with('\\'))
                throw Failure{
                    Error{"the option lpe:" + option.slot +
                              " contains a line end, or a backslash before one; expected neither: rendermn.ini has "
                              "one option a line",
                          option.origin,
                          option.line,
                          option.column,
                          {},
                          {}}};
            text += "/prman/lpe/" + option.slot + "  " + option.names + "\n";
        }
        const auto add = [&](const ChannelSource& source) {
            require_renderman(source, "rendermn.ini");
            MacroTable probe;
            if (Status usable = probe.add(source); !usable) { throw Failure{usable.error()}; }
            const std::string line = marked(expression_of(source));
            if (line.ends_with('\\')) {
                refuse(source,
                       "channel '" + source.name + "' ends in a backslash, which continues a line of rendermn.ini",
                       "write a .toml or .usda file");
            }
            text += "/prman/lpe/macro/" + source.name + "  " + line + "\n";
        };
        for (const ChannelSource& macro : file_.macros) { add(macro); }
        for (const FileChannel& channel : file_.channels) {
            for (const std::string& parameter : channel.parameters) { leave_out(channel, parameter, lost_); }
            if (!statistics_of(channel).empty()) {  // as a macro its expression would count as light
                spreads_ += (spreads_.empty() ? "'" : ", '") + channel.source.name + "'";
                continue;
            }
            text += commented(channel.comment, "#");
            add(channel.source);
        }
        finish("rendermn.ini");
        return text;
    }

    std::string usda() {
        std::string text =
            "#usda 1.0\n(\n    defaultPrim = \"Render\"\n)\n\ndef Scope \"Render\"\n{\n    def Scope \"Vars\"\n    {\n";
        bool first = true;
        for (const FileChannel& channel : file_.channels) {
            text += first ? "" : "\n";
            first = false;
            const std::string prim = prim_name(channel.source.name);
            text += commented(channel.comment, "        #");
            text += "        def RenderVar \"" + prim + "\"" +
                    (channel.prim_metadata.empty() ? "" : " " + channel.prim_metadata) + "\n        {\n";
            const bool usd_type = channel.type.find(' ') == std::string::npos && channel.type != "color";
            text += "            uniform token dataType = " + quoted(usd_type ? channel.type : "color3f") + "\n";
            text += "            uniform string sourceName = " + quoted(marked(expression_of(channel.source, false))) +
                    "\n";
            text += "            uniform token sourceType = \"lpe\"\n";
            const std::vector<std::string> parameters = kept(channel, false);
            const bool has_name = std::any_of(parameters.begin(), parameters.end(), [](const std::string& each) {
                return each.find("driver:parameters:aov:name") != std::string::npos;
            });
            if (prim != channel.source.name && !has_name) {
                text += "            token driver:parameters:aov:name = " + quoted(channel.source.name) + "\n";
            }
            for (const std::string& parameter : parameters) { text += "            " + parameter + "\n"; }
            text += "        }\n";
        }
        text += "    }\n}\n";
        for (const LobeOption& option : file_.lobe_options) {
            warnings_.push_back(option.origin + ":" + std::to_string(option.line) +
                                ": USD has no place for the lobe slot '" + option.slot + "'; it is omitted");
        }
        finish("USD");
        return text;
    }

  private:
    /// The expression as text. Throws Failure if the file is for RenderMan and RenderMan does not support the
    /// expression.
    [[nodiscard]] std::string expression_of(const ChannelSource& source, bool of_one_line = true) const {
        const bool own = reader_ == Reader::renderman && source.dialect == Dialect::renderman;
        if (Status readable = renderman_reads(source, true); own && !readable) { throw Failure{readable.error()}; }
        const std::string text = own || of_one_line ? one_line(source, reader_) : source.expression;
        return text.starts_with("lpe:") ? text.substr(4) : text;  // the caller writes the format's own prefix
    }

    /// The parameters in this format's notation: RIB's begin with a quote, USD's do not. Both formats have statistics.
    std::vector<std::string> kept(const FileChannel& channel, bool rib) {
        std::vector<std::string> result;
        const std::string statistics = statistics_of(channel);
        for (const std::string& parameter : channel.parameters) {
            if (parameter.starts_with('"') == rib) {
                result.push_back(parameter);
            } else if (!statistics.empty() && parameter.find("statistics") != std::string::npos) {
                result.push_back(rib ? "\"string statistics\" [\"" + statistics + "\"]"
                                     : "string driver:parameters:aov:statistics = \"" + statistics + "\"");
            } else {
                leave_out(channel, parameter, lost_);
            }
        }
        return result;
    }

    /// A prim name: letters, digits and _, unique among the channels.
    std::string prim_name(const std::string& name) {
        std::string prim;
        for (const char c : name) {
            const bool fits = c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
            prim += fits ? c : '_';
        }
        if (prim.empty() || (prim.front() >= '0' && prim.front() <= '9')) { prim.insert(0, "_"); }
        const std::string stem = prim;
        for (int k = 2; !prims_.insert(prim).second; ++k) { prim = stem + "_" + std::to_string(k); }
        return prim;
    }

    void finish(const std::string& format) {
        if (!lost_.empty()) {
            warnings_.push_back(
                format + " has no place for parameters of channels, which are left out: " + left_out_text(lost_));
        }
        if (!spreads_.empty()) {
            warnings_.push_back(format + " has no statistics; channels of them are left out: " + spreads_);
        }
        std::string others;
        for (const FileChannel& each : file_.other_channels) {
            if (format != "RIB") { others += (others.empty() ? "'" : ", '") + each.source.name + "'"; }
        }
        if (!others.empty()) {
            warnings_.push_back(format +
                                " is written with expressions alone; channels without one are left out: " + others);
        }
    }

    const ChannelFile& file_;
    std::vector<std::string>& warnings_;
    Reader reader_;
    std::set<std::string> prims_;
    LeftOut lost_;
    std::string spreads_;  // channels of statistics that the format cannot store
};

}  // namespace

Result<std::string> write_channel_file(const ChannelFile& file, ChannelFormat format,
                                       std::vector<std::string>& warnings, Reader reader) {
    return guarded([&]() -> std::string {
        Writer writer(file, warnings, reader);
        switch (format) {
            case ChannelFormat::rib:
                return writer.rib();
            case ChannelFormat::usda:
                return writer.usda();
            case ChannelFormat::ini:
                break;
        }
        return writer.ini();
    });
}

}  // namespace raylex::lpe
