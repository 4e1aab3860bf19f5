// RIB: a sequence of requests, each a word followed by numbers, strings and arrays. Source: "The RenderMan Interface",
// version 3.2, appendix C (syntax of RIB requests): '#' comments, strings with C escapes; a backslash at the end of a
// line continues a string.
//
//     DisplayChannel "color directDiffuse" "string source" ["color lpe:C<RD>[<L.>O]"] "string filter" "gaussian"
//     DisplayChannel "color lpe:diffuse"
//     Option "lpe" "string diffuse2" ["Diffuse,HairDiffuse"]
#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "lpe/channels/channel_file.h"
#include "lpe/channels/file_text.h"
#include "lpe/language/source_text.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

bool is_white(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v';
}
bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

// The words that this reader uses. RIB has many more, so only a near miss of one of these is reported as a typo.
constexpr std::array<std::string_view, 2> requests{"DisplayChannel", "Option"};
constexpr std::array<std::string_view, 3> display_channel_parameters{"source", "statistics", "filter"};
constexpr std::array<std::string_view, 10> display_channel_types{"color",  "float",  "integer", "point",  "vector",
                                                                 "normal", "string", "matrix",  "hpoint", "mpoint"};

/// Splits "varying color name" into type and name.
std::pair<std::string, std::string> split_declaration(std::string_view text) {
    while (!text.empty() && is_white(text.back())) { text.remove_suffix(1); }
    const std::size_t blank = text.find_last_of(" \t");
    if (blank == std::string_view::npos) { return {"color", std::string(text)}; }
    std::string_view type = text.substr(0, blank);
    while (!type.empty() && is_white(type.back())) { type.remove_suffix(1); }
    return {std::string(type), std::string(text.substr(blank + 1))};
}

struct Value {
    std::size_t begin = 0, end = 0;  // in the file
    bool is_string = false;          // a single string, alone or in brackets
    MappedText string;
};

class RibReader {
  public:
    RibReader(std::string_view text, const std::string& origin) : in_(text, origin) {}

    ChannelFile run() {
        for (skip_blank(); !in_.at_end(); skip_blank()) {
            if (!is_letter(in_.peek())) {
                in_.fail_at(in_.position(),
                            "found " + in_.describe(in_.position()) + "; expected a request such as DisplayChannel",
                            in_.position() == 0 ? "convert binary or compressed RIB with 'catrib -ascii'" : "");
            }
            const std::size_t begin = in_.position();
            const std::string comment = std::exchange(comment_, {});
            const std::string_view request = take_word();
            if (request == "DisplayChannel") {
                read_display_channel(begin, comment);
            } else if (request == "Option") {
                read_option();
            } else {
                note_misspelt(begin, "request", request, requests);
            }
            skip_arguments();
        }
        return in_.return_or_throw(std::move(file_));
    }

  private:
    void note_misspelt(std::size_t begin, const std::string& what, std::string_view word,
                       std::span<const std::string_view> known) {
        const std::string near = nearest(word, known.data(), known.size());
        if (near.empty() || near == word) { return; }
        in_.note(begin, "unknown " + what + " '" + std::string(word) + "'", "did you mean '" + near + "'?");
    }

    /// Skips blanks and comments; collects comment lines for the request that directly follows them.
    void skip_blank() {
        int newlines = 0;
        while (!in_.at_end()) {
            if (in_.peek() == '#') {
                const bool own_line = in_.position() == 0 || newlines > 0 || !comment_.empty();
                const bool structured = in_.starts_with("##");  // ##RenderMan RIB and other hints to tools
                std::string_view line = in_.take_line().substr(1);
                if (own_line && !structured) {
                    line.remove_prefix(line.starts_with(' ') ? 1 : 0);
                    comment_ += (comment_.empty() ? "" : "\n") + std::string(line);
                }
                newlines = 1;
            } else if (is_white(in_.peek())) {
                newlines += in_.peek() == '\n' ? 1 : 0;
                if (newlines > 1) {
                    comment_.clear();  // a blank line separates the comment from what follows
                }
                in_.move_to(in_.position() + 1);
            } else {
                return;
            }
        }
    }

    std::string_view take_word() {
        const std::size_t begin = in_.position();
        while (is_letter(in_.peek()) || (in_.peek() >= '0' && in_.peek() <= '9') || in_.peek() == ':' ||
               in_.peek() == '.') {
            in_.move_to(in_.position() + 1);
        }
        return in_.text().substr(begin, in_.position() - begin);
    }

    MappedText take_string() {
        const std::size_t opening = in_.position();
        MappedText text;
        text.start(opening + 1);
        for (std::size_t at = opening + 1; at < in_.text().size();) {
            const char c = in_.text()[at];
            if (c == '"') {
                in_.move_to(at + 1);
                return text;
            }
            if (c == '\\') {
                at = take_escape(text, at);
            } else {
                text.append(c, at++);
            }
        }
        in_.fail_at(opening, "the string is not closed; expected a second '\"'");
    }

    /// Decodes the escape at `at` and returns the position after it.
    std::size_t take_escape(MappedText& text, std::size_t at) {
        const std::string_view all = in_.text();
        if (at + 1 >= all.size()) { return at + 1; }
        const char c = all[at + 1];
        if (c == '\n') { return at + 2; }
        if (c == '\r') { return at + (at + 2 < all.size() && all[at + 2] == '\n' ? 3 : 2); }
        if (c >= '0' && c <= '7') {
            int value = 0;
            std::size_t end = at + 1;
            while (end < all.size() && end < at + 4 && all[end] >= '0' && all[end] <= '7') {
                value = value * 8 + (all[end++] - '0');
            }
            text.append(static_cast<char>(value), at);
            return end;
        }
        constexpr std::string_view names = "nrtbf", values = "\n\r\t\b\f";
        const std::size_t known = names.find(c);
        text.append(known == std::string_view::npos ? c : values[known], known == std::string_view::npos ? at + 1 : at);
        return at + 2;
    }

    /// Reads a number, a string or an array of them.
    Value take_value() {
        Value value;
        value.begin = in_.position();
        if (in_.peek() == '"') {
            value.string = take_string();
            value.is_string = true;
        } else if (in_.peek() == '[') {
            take_array(value);
        } else {
            take_number();
        }
        value.end = in_.position();
        return value;
    }

    void take_array(Value& value) {
        const std::size_t opening = in_.position();
        in_.move_to(opening + 1);
        std::size_t strings = 0, others = 0;
        for (skip_blank(); in_.peek() != ']' || in_.at_end(); skip_blank()) {
            if (in_.at_end()) { in_.fail_at(opening, "the array is not closed; expected ']'"); }
            if (in_.peek() == '"') {
                MappedText string = take_string();
                if (++strings == 1) { value.string = std::move(string); }
            } else {
                take_number();
                ++others;
            }
        }
        in_.move_to(in_.position() + 1);
        value.is_string = strings == 1 && others == 0;
    }

    void take_number() {
        const std::size_t begin = in_.position();
        while (std::string_view("+-.0123456789eE").find(in_.peek()) != std::string_view::npos && in_.peek() != '\0') {
            in_.move_to(in_.position() + 1);
        }
        if (in_.position() == begin) {
            in_.fail_at(begin,
                        "found " + in_.describe(begin) + "; expected a number, a string in double quotes or an array");
        }
    }

    [[nodiscard]] bool at_argument() {
        skip_blank();
        return !in_.at_end() && !is_letter(in_.peek());
    }

    void skip_arguments() {
        while (at_argument()) { take_value(); }
    }

    /// Reads a list without commas: "declaration" value "declaration" value ...
    template <class Take>
    void take_parameters(Take&& take) {
        while (at_argument()) {
            if (in_.peek() != '"') {
                in_.fail_at(in_.position(), "found " + in_.describe(in_.position()) +
                                                "; expected a parameter such as \"string source\" or the next request");
            }
            const std::size_t begin = in_.position();
            const MappedText declaration = take_string();
            if (!at_argument()) {
                in_.fail_at(begin, "the parameter '" + declaration.text() + "' has no value; expected one after it");
            }
            take(begin, declaration, take_value());
        }
    }

    /// Keeps a parameter other than the source.
    void keep_parameter(std::size_t begin, const MappedText& declaration, const Value& value, FileChannel& channel) {
        const std::string parameter = split_declaration(declaration.text()).second;
        if (parameter == "statistics" && value.is_string && !value.string.text().empty()) {
            in_.note_unless_known(value.begin, parameter, value.string.text(), statistics_names);
        }
        note_misspelt(begin, "parameter", parameter, display_channel_parameters);
        channel.parameters.emplace_back(in_.text().substr(begin, value.end - begin));
    }

    /// For a channel named by its expression, such as "color lpe:CD<L.>", returns where the expression begins, or npos.
    static std::size_t name_by_expression(const std::string& declared, FileChannel& channel, std::string& name) {
        const std::size_t offset = expression_offset(declared);
        if (offset == std::string::npos) { return offset; }
        name = declared.substr(offset - 4);
        const std::string_view before = std::string_view(declared).substr(0, offset - 4);
        channel.type = before.find_first_not_of(' ') == std::string_view::npos
                           ? "color"
                           : std::string(before.substr(0, before.find_last_not_of(" \t") + 1));
        return offset;
    }

    void read_display_channel(std::size_t request, const std::string& comment) {
        if (!at_argument() || in_.peek() != '"') {
            in_.fail_at(request, "DisplayChannel has no name; expected \"color name\" after it");
        }
        const std::size_t name_begin = in_.position();
        const MappedText declared = take_string();
        FileChannel channel;
        MappedText expression;
        std::size_t offset = std::string_view::npos;
        std::string name;
        bool has_source = false;
        std::tie(channel.type, name) = split_declaration(declared.text());
        const std::string_view type = std::string_view(channel.type).substr(channel.type.rfind(' ') + 1);
        note_misspelt(name_begin, "type", type.substr(0, type.find_first_of("[0123456789")), display_channel_types);
        take_parameters([&](std::size_t begin, const MappedText& declaration, Value value) {
            if (split_declaration(declaration.text()).second != "source") {
                keep_parameter(begin, declaration, value, channel);
                return;
            }
            if (std::exchange(has_source, true)) {
                in_.note(begin, "channel '" + name + "' has a second source; expected one");
                return;
            }
            if (!value.is_string) {
                in_.note(value.begin,
                         "the source of channel '" + name + "' is not a string; expected [\"color lpe:...\"]");
                return;
            }
            offset = expression_offset(value.string.text());
            if (offset == std::string_view::npos) {
                channel.parameters.emplace_back(in_.text().substr(begin, value.end - begin));
            }
            expression = std::move(value.string);
        });
        if (offset == std::string_view::npos && expression.text().empty()) {
            offset = name_by_expression(declared.text(), channel, name);
            if (offset != std::string_view::npos) { expression = declared; }
        }
        count(request);
        if (offset == std::string_view::npos) {
            const std::string source = split_declaration(expression.text()).second;
            channel.source = in_.source(name, declared);
            channel.source.expression = source.empty() ? name : source;
            channel.comment = comment;
            file_.other_channels.push_back(std::move(channel));
            return;
        }
        if (offset >= expression.text().size()) {
            in_.note(expression.position(offset),
                     "channel '" + name + "' has an empty expression; expected one after 'lpe:'");
            return;
        }
        if (name.empty()) {
            in_.note(name_begin, "DisplayChannel has an empty name; expected \"color name\"");
            return;
        }
        channel.source = in_.source(name, expression, offset);
        channel.comment = comment;
        file_.channels.push_back(std::move(channel));
    }

    /// Reads Option "lpe" "string diffuse2" ["Diffuse,HairDiffuse"].
    void read_option() {
        if (!at_argument() || in_.peek() != '"' || take_string().text() != "lpe") { return; }
        take_parameters([&](std::size_t begin, const MappedText& declaration, const Value& value) {
            const std::string slot = split_declaration(declaration.text()).second;
            if (!value.is_string) {
                file_.warnings.push_back(in_.origin() + ":" + std::to_string(in_.line_of(begin)) +
                                         ": the option lpe:" + slot + " is not a string; it is ignored");
                return;
            }
            count(begin);
            const std::size_t at = value.string.position(0);
            file_.lobe_options.push_back({slot, value.string.text(), in_.origin(), in_.line_of(at), in_.column_of(at)});
        });
    }

    void count(std::size_t at) {
        if (++found_ > limits::file_channels) {
            in_.fail_at(at,
                        "the file has more than " + std::to_string(limits::file_channels) + " channels and options");
        }
    }

    FileText in_;
    ChannelFile file_;
    std::string comment_;
    std::size_t found_ = 0;
};

}  // namespace

ChannelFile parse_rib(std::string_view text, const std::string& origin) {
    return RibReader(text, origin).run();
}

}  // namespace raylex::lpe
