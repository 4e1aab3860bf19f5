// rendermn.ini: lines "/path value". The reader uses lines below /prman/lpe and ignores all others. Source: RenderMan
// documentation, "Light Path Expressions", sections LPE Macro and Per-Lobe LPEs.
//
//     /prman/lpe/macro/myDiffuse    CD<L.>
//     /prman/lpe/specular6          Fuzz,HairSpecularGLINTS
#include <algorithm>
#include <string>
#include <utility>

#include "lpe/channels/channel_file.h"
#include "lpe/channels/file_text.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

bool is_blank_of_line(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

class IniReader {
  public:
    IniReader(std::string_view text, const std::string& origin) : in_(text, origin) {}

    ChannelFile run() {
        while (!in_.at_end()) {
            skip_blank();
            if (in_.starts_with(root)) {
                read_entry();
            } else {
                in_.take_line();
            }
        }
        return in_.return_or_throw(std::move(file_));
    }

  private:
    static constexpr std::string_view root = "/prman/lpe/", macro = "macro/";

    void skip_blank() {
        while (is_blank_of_line(in_.peek())) { in_.move_to(in_.position() + 1); }
    }

    void read_entry() {
        const std::size_t begin = in_.position();
        std::size_t end = begin;
        while (end < in_.text().size() && !is_blank_of_line(in_.text()[end]) && in_.text()[end] != '\n') { ++end; }
        const std::string_view path = in_.text().substr(begin + root.size(), end - begin - root.size());
        in_.move_to(end);
        const MappedText value = take_value();
        if (++found_ > limits::file_channels) {
            in_.fail_at(begin,
                        "the file has more than " + std::to_string(limits::file_channels) + " macros and options");
        }
        if (path.starts_with(macro)) {
            add_macro(begin, path.substr(macro.size()), value);
        } else if (path.find('/') != std::string_view::npos) {
            in_.note(begin, "unknown entry '" + std::string(root) + std::string(path) +
                                "'; expected /prman/lpe/macro/NAME, or a slot such as /prman/lpe/specular2");
        } else {
            const std::size_t at = value.position(0);
            file_.lobe_options.push_back(
                {std::string(path), value.text(), in_.origin(), in_.line_of(at), in_.column_of(at)});
        }
    }

    void add_macro(std::size_t begin, std::string_view name, const MappedText& value) {
        if (value.text().empty()) {
            in_.note(begin, "the macro '" + std::string(name) + "' has no expression; expected one after its name");
            return;
        }
        const std::size_t offset = expression_offset(value.text());
        ChannelSource source = in_.source(std::string(name), value, offset == std::string_view::npos ? 0 : offset);
        file_.macros.push_back(std::move(source));
    }

    /// Returns the rest of the line without surrounding blanks; a backslash at the end of a line continues it. '#'
    /// begins a comment only after a blank and outside quotes.
    MappedText take_value() {
        skip_blank();
        MappedText value;
        value.start(in_.position());
        std::size_t kept = 0;  // length without trailing blanks
        MappedText whole = value;
        const std::string_view all = in_.text();
        bool quoted = false;
        std::size_t at = in_.position();
        for (; at < all.size() && all[at] != '\n'; ++at) {
            if (all[at] == '\\' && (all.substr(at + 1).starts_with("\n") || all.substr(at + 1).starts_with("\r\n"))) {
                at += all[at + 1] == '\n' ? 1 : 2;
                continue;
            }
            quoted = quoted != (all[at] == '\'');
            if (all[at] == '#' && !quoted && at > 0 && is_blank_of_line(all[at - 1])) {
                at = std::min(all.find('\n', at), all.size());
                break;
            }
            whole.append(all[at], at);
            kept = is_blank_of_line(all[at]) ? kept : whole.text().size();
        }
        in_.move_to(std::min(at + 1, all.size()));
        for (std::size_t i = 0; i < kept; ++i) { value.append(whole.text()[i], whole.position(i)); }
        return value;
    }

    FileText in_;
    ChannelFile file_;
    std::size_t found_ = 0;
};

}  // namespace

ChannelFile parse_ini(std::string_view text, const std::string& origin) {
    return IniReader(text, origin).run();
}

}  // namespace raylex::lpe
