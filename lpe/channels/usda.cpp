// USD ASCII: the RenderVar prims of a layer. Source: OpenUSD documentation, "UsdRender" (RenderVar: dataType,
// sourceName, sourceType) and the layout of .usda files; no USD library is needed. Prims can be nested in any others
// and in variants. Layers are not composed, so the reader uses only the content of this file.
//
//     def RenderVar "directDiffuse"
//     {
//         uniform token dataType = "color3f"
//         uniform string sourceName = "C<RD>[<L.>O]"
//         uniform token sourceType = "lpe"
//     }
#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lpe/channels/channel_file.h"
#include "lpe/channels/file_text.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

bool is_name_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || (static_cast<unsigned char>(c) & 0x80U) != 0;
}
bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

int hexadecimal(char c) {
    if (is_digit(c)) { return c - '0'; }
    const char small = static_cast<char>(c | 0x20);
    return small >= 'a' && small <= 'f' ? small - 'a' + 10 : -1;
}

struct StringAttribute {
    MappedText text;
    bool is_string = false;
    std::size_t begin = 0;
};

/// A prim whose closing brace has not been read.
struct Prim {
    bool prims_inside = true;  ///< false inside a variantSet, which contains variants
    bool render_var = false, untyped = false;
    std::string name;
    std::size_t begin = 0;
    FileChannel channel;
    std::optional<StringAttribute> data_type, source_name, source_type, aov_name;
};

class UsdaReader {
  public:
    UsdaReader(std::string_view text, const std::string& origin) : in_(text, origin) {}

    ChannelFile run() {
        if (in_.starts_with("#usda")) {
            in_.take_line();
        } else {
            in_.fail_at(0, "the file does not begin with '#usda 1.0'",
                        in_.starts_with("PXR-USDC") ? "this is binary USD; convert it with 'usdcat -o file.usda'" : "");
        }
        skip_blank();
        if (in_.peek() == '(') { skip_balanced(); }
        for (skip_blank(); !in_.at_end(); skip_blank()) { read_statement(); }
        if (!open_.empty()) {
            in_.fail_at(open_.back().begin, "the prim '" + open_.back().name + "' is not closed; expected '}'");
        }
        return in_.return_or_throw(std::move(file_));
    }

  private:
    // ---- characters -----------------------------------------------------------------------------------------------

    /// Skips blanks and comments; without `lines`, only to the end of the statement: a line end or ';'.
    void skip_blank(bool lines = true) {
        while (!in_.at_end()) {
            const char c = in_.peek();
            if ((c == '\n' || c == ';') && !lines) { return; }
            if (c == '#' || in_.starts_with("//")) {
                take_comment();
            } else if (in_.starts_with("/*")) {
                const std::size_t end = in_.text().find("*/", in_.position() + 2);
                if (end == std::string_view::npos) {
                    in_.fail_at(in_.position(), "the comment is not closed; expected '*/'");
                }
                in_.move_to(end + 2);
            } else if (c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ';') {
                if (c == '\n' && ++newlines_ > 1) { comment_.clear(); }
                in_.move_to(in_.position() + 1);
            } else {
                return;
            }
        }
    }

    /// Keeps the line end, so that it also ends a statement.
    void take_comment() {
        const std::size_t begin = in_.position() + (in_.peek() == '#' ? 1 : 2);
        const std::size_t end = std::min(in_.text().find('\n', begin), in_.text().size());
        std::string_view line = in_.text().substr(begin, end - begin);
        if (newlines_ > 0) {
            line.remove_prefix(line.starts_with(' ') ? 1 : 0);
            line.remove_suffix(line.ends_with('\r') ? 1 : 0);
            comment_ += (comment_.empty() ? "" : "\n") + std::string(line);
        }
        newlines_ = 0;
        in_.move_to(end);
    }

    std::string_view take_word() {
        const std::size_t begin = in_.position();
        while (is_name_letter(in_.peek()) || is_digit(in_.peek()) || in_.peek() == ':' || in_.peek() == '.') {
            in_.move_to(in_.position() + 1);
        }
        newlines_ = 0;
        return in_.text().substr(begin, in_.position() - begin);
    }

    MappedText take_string() {
        const std::size_t opening = in_.position();
        const char quote = in_.peek();
        const bool triple = in_.peek(1) == quote && in_.peek(2) == quote;
        const std::string_view all = in_.text();
        const std::string closing(triple ? 3 : 1, quote);
        MappedText text;
        text.start(opening + closing.size());
        for (std::size_t at = opening + closing.size(); at < all.size();) {
            if (all.substr(at).starts_with(closing)) {
                in_.move_to(at + closing.size());
                newlines_ = 0;
                return text;
            }
            if (all[at] == '\n' && !triple) { break; }
            if (all[at] == '\\' && at + 1 < all.size()) {
                at = take_escape(text, at);
            } else {
                text.append(all[at], at);
                ++at;
            }
        }
        in_.fail_at(opening, "the string is not closed; expected " + closing);
    }

    /// Decodes \n \t \xHH \ooo; any other escaped byte stands for itself.
    std::size_t take_escape(MappedText& text, std::size_t at) {
        const std::string_view all = in_.text();
        const char c = all[at + 1];
        constexpr std::string_view names = "abfnrtv", values = "\a\b\f\n\r\t\v";
        if (const std::size_t known = names.find(c); known != std::string_view::npos) {
            text.append(values[known], at);
            return at + 2;
        }
        if (c == 'x' || (c >= '0' && c <= '7')) {
            const bool hex = c == 'x';
            std::size_t end = at + (hex ? 2 : 1);
            const std::size_t longest = end + (hex ? 2 : 3);
            int value = 0;
            while (end < all.size() && end < longest && hexadecimal(all[end]) >= 0 && (hex || all[end] <= '7')) {
                value = value * (hex ? 16 : 8) + hexadecimal(all[end++]);
            }
            text.append(static_cast<char>(value), at);
            return end;
        }
        text.append(c, at + 1);
        return at + 2;
    }

    /// Skips one value, or one pair of brackets with its content.
    void skip_balanced() {
        const std::size_t begin = in_.position();
        std::string open;
        do {
            skip_blank();
            const char c = in_.peek();
            if (in_.at_end()) { in_.fail_at(begin, "the '" + std::string(1, in_.text()[begin]) + "' is not closed"); }
            if (c == '(' || c == '[' || c == '{') {
                if (open.size() >= limits::file_nesting) {
                    in_.fail_at(in_.position(),
                                "brackets are nested deeper than " + std::to_string(limits::file_nesting));
                }
                open += c == '(' ? ')' : c == '[' ? ']' : '}';
                in_.move_to(in_.position() + 1);
            } else if (c == ')' || c == ']' || c == '}') {
                if (open.empty() || open.back() != c) {
                    in_.fail_at(in_.position(), "found " + in_.describe(in_.position()) + "; expected '" +
                                                    (open.empty() ? "a value" : std::string(1, open.back())) + "'");
                }
                open.pop_back();
                in_.move_to(in_.position() + 1);
            } else {
                skip_token();
            }
        } while (!open.empty());
        newlines_ = 0;
    }

    /// Skips a string, an asset path @...@, a prim path <...>, a word, a number or a single byte.
    void skip_token() {
        const char c = in_.peek();
        const std::size_t begin = in_.position();
        if (c == '"' || c == '\'') {
            take_string();
        } else if (c == '@') {
            const std::string closing = in_.starts_with("@@@") ? "@@@" : "@";
            const std::size_t end = in_.text().find(closing, begin + closing.size());
            if (end == std::string_view::npos) {
                in_.fail_at(begin, "the asset path is not closed; expected " + closing);
            }
            in_.move_to(end + closing.size());
        } else if (c == '<') {
            const std::size_t end = in_.text().find_first_of(">\n", begin);
            if (end == std::string_view::npos || in_.text()[end] == '\n') {
                in_.fail_at(begin, "the path is not closed; expected '>'");
            }
            in_.move_to(end + 1);
        } else if (is_name_letter(c)) {
            take_word();
        } else if (is_digit(c) || c == '-' || c == '+' || c == '.') {
            while (is_name_letter(in_.peek()) || is_digit(in_.peek()) ||
                   std::string_view("+-.").find(in_.peek()) != std::string_view::npos) {
                in_.move_to(in_.position() + 1);
            }
        } else {
            in_.move_to(begin + 1);
        }
    }

    // ---- statements -----------------------------------------------------------------------------------------------

    void read_statement() {
        const std::size_t begin = in_.position();
        const std::string comment = std::exchange(comment_, {});
        if (in_.peek() == '}') {
            close_prim();
            return;
        }
        if (!open_.empty() && !open_.back().prims_inside) {
            open_variant(begin);
            return;
        }
        if (!is_name_letter(in_.peek())) {
            in_.fail_at(begin,
                        "found " + in_.describe(begin) + "; expected a prim (def, over, class), an attribute or '}'");
        }
        const std::string_view word = take_word();
        if (word == "def" || word == "over" || word == "class") {
            open_prim(begin, comment);
        } else if (word == "variantSet") {
            skip_blank();
            open_.push_back(make_prim(begin));
            open_.back().prims_inside = false;
            if (in_.peek() == '"' || in_.peek() == '\'') { open_.back().name = take_string().text(); }
            expect('=');
            expect('{');
        } else {
            read_attribute(begin);
        }
    }

    void expect(char c) {
        skip_blank();
        if (in_.peek() != c || in_.at_end()) {
            in_.fail_at(in_.position(),
                        "found " + in_.describe(in_.position()) + "; expected '" + std::string(1, c) + "'");
        }
        in_.move_to(in_.position() + 1);
        newlines_ = 0;
    }

    Prim make_prim(std::size_t begin) {
        if (open_.size() >= limits::file_nesting) {
            in_.fail_at(begin, "prims are nested deeper than " + std::to_string(limits::file_nesting));
        }
        Prim prim;
        prim.begin = begin;
        return prim;
    }

    /// Reads: def Type "name" ( metadata ) {
    void open_prim(std::size_t begin, const std::string& comment) {
        Prim prim = make_prim(begin);
        skip_blank();
        if (is_name_letter(in_.peek())) {
            prim.render_var = take_word() == "RenderVar";
            skip_blank();
        } else {
            prim.untyped = true;
        }
        if (in_.peek() != '"' && in_.peek() != '\'') {
            in_.fail_at(in_.position(),
                        "found " + in_.describe(in_.position()) + "; expected the prim's name in quotes");
        }
        prim.name = take_string().text();
        skip_blank();
        if (in_.peek() == '(') {
            const std::size_t opening = in_.position();
            skip_balanced();
            prim.channel.prim_metadata = in_.text().substr(opening, in_.position() - opening);
        }
        expect('{');
        prim.channel.comment = comment;
        open_.push_back(std::move(prim));
    }

    /// Reads, inside a variantSet: "name" ( metadata ) {
    void open_variant(std::size_t begin) {
        if (in_.peek() != '"' && in_.peek() != '\'') {
            in_.fail_at(begin, "found " + in_.describe(begin) + "; expected the variant's name in quotes or '}'");
        }
        Prim variant = make_prim(begin);
        variant.name = take_string().text();
        skip_blank();
        if (in_.peek() == '(') { skip_balanced(); }
        expect('{');
        open_.push_back(std::move(variant));
    }

    /// Reads, to the end of the line: [custom] [uniform] type name [= value] [( metadata )]
    void read_attribute(std::size_t begin) {
        std::string_view name;
        for (skip_blank(false); is_name_letter(in_.peek()) || in_.peek() == '['; skip_blank(false)) {
            if (in_.peek() == '[') {
                skip_balanced();  // float[] name
                continue;
            }
            name = take_word();
        }
        StringAttribute value;
        if (in_.peek() == '=') {
            in_.move_to(in_.position() + 1);
            skip_blank();
            value.begin = in_.position();
            if (in_.peek() == '"' || in_.peek() == '\'') {
                value.text = take_string();
                value.is_string = true;
            } else if (!in_.at_end()) {
                skip_balanced();
            }
        }
        std::size_t end = in_.position();
        skip_blank(false);
        if (in_.peek() == '(') {
            skip_balanced();
            end = in_.position();
            skip_blank(false);
        }
        if (!in_.at_end() && in_.peek() != '\n' && in_.peek() != ';' && in_.peek() != '}') {
            in_.fail_at(in_.position(),
                        "found " + in_.describe(in_.position()) + "; expected the end of the statement");
        }
        if (!open_.empty() && (open_.back().render_var || open_.back().untyped)) {
            keep_attribute(name, std::move(value), in_.text().substr(begin, end - begin));
        }
    }

    void keep_attribute(std::string_view name, StringAttribute value, std::string_view statement) {
        Prim& prim = open_.back();
        if (name == "dataType" && value.is_string) {
            prim.data_type = std::move(value);
        } else if (name == "sourceName") {
            prim.source_name = std::move(value);
        } else if (name == "sourceType" && value.is_string) {
            prim.source_type = std::move(value);
        } else {
            if (name == "driver:parameters:aov:name" && value.is_string) { prim.aov_name = value; }
            if (name.ends_with(":statistics") && value.is_string && !value.text.text().empty()) {
                in_.note_unless_known(value.begin, "statistics", value.text.text(), statistics_names);
            }
            prim.channel.parameters.emplace_back(statement);
        }
    }

    void close_prim() {
        if (open_.empty()) { in_.fail_at(in_.position(), "found '}' without an open prim"); }
        in_.move_to(in_.position() + 1);
        newlines_ = 0;
        Prim prim = std::move(open_.back());
        open_.pop_back();
        const bool says_lpe = prim.source_type && prim.source_type->text.text() == "lpe";
        if (prim.render_var || (prim.untyped && says_lpe)) { add_channel(std::move(prim), says_lpe); }
    }

    void add_channel(Prim prim, bool says_lpe) {
        // RenderMan's delegate also accepts sourceName = "lpe:..." without a sourceType.
        const bool named_so = prim.source_name && prim.source_name->is_string &&
                              expression_offset(prim.source_name->text.text()) != std::string_view::npos;
        if (!says_lpe && !named_so) {
            FileChannel& other = file_.other_channels.emplace_back(std::move(prim.channel));
            other.source.name = other.source.expression = prim.name;
            if (prim.source_name) { other.source = in_.source(prim.name, prim.source_name->text); }
            return;
        }
        if (!prim.source_name) {
            in_.note(prim.begin, "RenderVar '" + prim.name +
                                     "' has sourceType \"lpe\" but no sourceName; expected string "
                                     "sourceName = \"C...\"");
            return;
        }
        if (!prim.source_name->is_string) {
            in_.note(prim.source_name->begin, "the sourceName of RenderVar '" + prim.name +
                                                  "' is not a string; expected an expression in quotes");
            return;
        }
        if (++found_ > limits::file_channels) {
            in_.fail_at(prim.begin, "the file has more than " + std::to_string(limits::file_channels) + " channels");
        }
        const std::size_t offset = named_so ? expression_offset(prim.source_name->text.text()) : 0;
        if (offset >= prim.source_name->text.text().size()) {
            in_.note(prim.source_name->begin,
                     "the sourceName of RenderVar '" + prim.name + "' is empty; expected an expression");
            return;
        }
        FileChannel channel = std::move(prim.channel);
        const bool renamed = prim.aov_name && !prim.aov_name->text.text().empty();
        channel.source = in_.source(renamed ? prim.aov_name->text.text() : prim.name, prim.source_name->text, offset);
        channel.type = prim.data_type ? prim.data_type->text.text() : "color3f";
        file_.channels.push_back(std::move(channel));
    }

    FileText in_;
    ChannelFile file_;
    std::vector<Prim> open_;
    std::string comment_;
    int newlines_ = 1;
    std::size_t found_ = 0;
};

}  // namespace

ChannelFile parse_usda(std::string_view text, const std::string& origin) {
    return UsdaReader(text, origin).run();
}

}  // namespace raylex::lpe
