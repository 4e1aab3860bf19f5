#include "lpe/language/names.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "lpe/failure.h"
#include "lpe/language/glob.h"
#include "lpe/language/source_map.h"
#include "lpe/language/source_text.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

// Sources: RenderMan documentation, "Light Path Expressions" (rmanwiki.pixar.com, REN21 to REN26): the table of
// built-in names, then the basic channels. `subsurface` is in both with different expressions; the built-in name takes
// precedence.
constexpr std::array<NamedExpression, 16> builtin_table{{
    {"diffuse", "CD<L.>"},
    {"specular", "CS<L.>"},
    {"emission", "CO"},
    {"indirectdiffuse", "(C<RD>[DS]+<L.>)|(C<RD>[DS]*O)"},
    {"indirectspecular", "(C<RS>[DS]+<L.>)|(C<RS>[DS]*O)"},
    {"subsurface", "(C<TD>[DS]+<L.>)|(C<TD>[DS]*O)"},
    {"refraction", "(C<T[S]>[DS]+<L.>)|(C<T[S]>[DS]*O)"},
    {"shadowcollector", "shadows;C[<.D'collector'><.S'collector'>]<L.>"},
    {"reflectioncollector", "C<RS'collector'>([DS]+<L.>)|([DS]*O)"},
    {"beauty", "C.*[<L.>O]"},
    {"emissive", "C[<L.>O]"},
    {"directDiffuse", "C<RD>[<L.>O]"},
    {"indirectDiffuse", "C<RD>.+[<L.>O]"},
    {"directSpecular", "C<RS>[<L.>O]"},
    {"indirectSpecular", "C<RS>.+[<L.>O]"},
    {"transmissive", "C<TS>.*[<L.>O]"},
}};

bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/// The end of the name that begins at `begin`, or `begin` when there is no name.
std::size_t name_end(std::string_view text, std::size_t begin) {
    std::size_t end = begin;
    while (end < text.size() && (is_letter(text[end]) || (end > begin && is_digit(text[end])))) { ++end; }
    return end;
}

bool is_name(std::string_view text) {
    return !text.empty() && name_end(text, 0) == text.size();
}

/// Returns whether the name consists of event letters and numbers only: CDL, CS2O.
bool reads_as_expression(std::string_view name) {
    return name.find_first_not_of("CLOBVRTDSGU0123456789") == std::string_view::npos;
}

/// Two adjacent lower-case letters: a typo in an expression does not look so, a mistyped name does.
bool looks_like_word(std::string_view name) {
    const auto small = [](char c) { return c >= 'a' && c <= 'z'; };
    return std::adjacent_find(name.begin(), name.end(), [&](char a, char b) { return small(a) && small(b); }) !=
           name.end();
}

std::size_t skip_blank(std::string_view text, std::size_t at) {
    while (at < text.size()) {
        if (text[at] == '#') {
            at = std::min(text.find('\n', at), text.size());
        } else if (is_blank(text[at])) {
            ++at;
        } else {
            break;
        }
    }
    return at;
}

/// The end of the quoted label that begins at `begin`.
std::size_t quote_end(std::string_view text, std::size_t begin) {
    for (std::size_t at = begin + 1; at < text.size(); ++at) {
        if (text[at] == '\\') {
            ++at;
        } else if (text[at] == '\'') {
            return at + 1;
        }
    }
    return text.size();
}

/// The positions after 'lpe:' and after the prefixes.
struct Head {
    std::size_t mark_end = 0;    // after 'lpe:'
    std::size_t body_begin = 0;  // after the last ';'
    std::string_view first_prefix;
};

Head read_head(std::string_view text) {
    Head head;
    std::size_t at = skip_blank(text, 0);
    for (;;) {
        const std::size_t end = name_end(text, at);
        if (end == at || end >= text.size() || (text[end] != ';' && text[end] != ':')) { break; }
        const std::string_view word = text.substr(at, end - at);
        if (text[end] == ':' && (word != "lpe" || head.body_begin != 0)) {
            break;  // the parser reports the error
        }
        if (text[end] == ':') {
            head.mark_end = end + 1;
        } else if (head.first_prefix.empty()) {
            head.first_prefix = word;
        }
        head.body_begin = end + 1;
        at = skip_blank(text, end + 1);
    }
    return head;
}

/// The name if the text after 'lpe:' and prefixes is only a name; otherwise empty.
std::string_view lone_name(std::string_view text) {
    const std::size_t begin = skip_blank(text, read_head(text).body_begin);
    const std::size_t end = name_end(text, begin);
    return end > begin && skip_blank(text, end) == text.size() ? text.substr(begin, end - begin) : std::string_view();
}

/// A name with its light group: "beauty_key" is the name "beauty" with the group "key".
struct Resolved {
    ChannelSource definition;
    std::string group;
    std::string via;
};

class Expander {
  public:
    Expander(const ChannelSource& source, const MacroTable& macros) : macros_(macros) {
        expansion_.source = source;
        expansion_.source.expression.clear();
        auto map = std::make_shared<SourceMap>();
        map_ = map.get();
        expansion_.source.map = std::move(map);
    }

    Expansion run(const ChannelSource& source) {
        append_whole(source, {}, {});
        return std::move(expansion_);
    }

  private:
    [[nodiscard]] static std::shared_ptr<const TextFile> file_of(const ChannelSource& source) {
        // Without a map the text is contiguous, perhaps in a file that is not loaded. Padding with blank lines and
        // columns gives errors the right position.
        std::string padding(static_cast<std::size_t>(std::max(source.origin_line - 1, 0)), '\n');
        padding.append(static_cast<std::size_t>(std::max(source.origin_column - 1, 0)), ' ');
        const std::string name =
            source.origin.empty() && !source.name.empty() ? "channel '" + source.name + "'" : source.origin;
        return std::make_shared<const TextFile>(TextFile{name, padding + source.expression, source.origin_line > 0});
    }

    [[nodiscard]] static std::shared_ptr<const SourceMap> map_of(const ChannelSource& source) {
        if (source.map && !source.map->spans.empty()) { return source.map; }
        auto map = std::make_shared<SourceMap>();
        auto file = file_of(source);
        const std::size_t position = file->text.size() - source.expression.size();
        map->spans.push_back({0, std::move(file), position, {}});
        return map;
    }

    /// The current input of the expansion: a text, its map, its light group and the macro that it is part of.
    struct Reading {
        std::string_view text;
        std::shared_ptr<const SourceMap> map;
        std::string group, via;
    };

    /// Appends bytes [begin, end) of the text with their positions.
    void copy(const Reading& from, std::size_t begin, std::size_t end) {
        if (begin >= end) { return; }
        std::string& out = expansion_.source.expression;
        if (out.size() + (end - begin) > limits::text_bytes) {
            fail_at(from, begin,
                    "the expression has more than " + std::to_string(limits::text_bytes) +
                        " bytes once its names are replaced; expected a shorter one");
        }
        mark(from, begin);
        const auto& spans = from.map->spans;
        for (const SourceMap::Span& span : spans) {
            if (span.offset > begin && span.offset < end) {
                SourceMap::Span moved = span;
                moved.offset = out.size() + (span.offset - begin);
                moved.via = from.via.empty() ? span.via : from.via;
                map_->spans.push_back(std::move(moved));
            }
        }
        out.append(from.text.substr(begin, end - begin));
    }

    /// Sets the position of the next appended byte to byte `at` of the text.
    void mark(const Reading& from, std::size_t at) {
        SourceMap::Span span = from.map->span_at(at);
        span.position += at - span.offset;
        span.offset = expansion_.source.expression.size();
        span.via = from.via.empty() ? span.via : from.via;
        if (!map_->spans.empty() && map_->spans.back().offset == span.offset) {
            map_->spans.back() = std::move(span);
        } else {
            map_->spans.push_back(std::move(span));
        }
    }

    void insert(const Reading& from, std::size_t at, std::string_view text) {
        mark(from, at);
        expansion_.source.expression.append(text);
    }

    [[noreturn]] static void fail_at(const Reading& from, std::size_t at, std::string message, std::string hint = {}) {
        ChannelSource source;
        source.expression = std::string(from.text);
        source.map = from.map;
        SourceText(source).fail_at(at, std::move(message), std::move(hint));
    }

    /// Appends a whole channel: 'lpe:', prefixes, then a name or an expression.
    void append_whole(const ChannelSource& source, const std::string& group, const std::string& via) {
        const std::string_view text = source.expression;
        const Reading reading{text, map_of(source), group, via};
        const Head head = read_head(text);
        const std::size_t begin = skip_blank(text, head.body_begin);
        if (const std::string_view name = lone_name(text); !name.empty()) {
            if (std::optional<Resolved> known = resolve(name)) {
                copy(reading, via.empty() ? 0 : head.mark_end, begin);
                note_group(*known, name, group);
                enter(reading, begin, name);
                append_whole(known->definition, known->group.empty() ? group : known->group, known->via);
                open_.pop_back();
                return;
            }
            if (looks_like_word(name)) { fail_unknown(reading, begin, name); }
        }
        copy(reading, via.empty() ? 0 : head.mark_end, head.body_begin);
        append_body(reading, head.body_begin);
    }

    /// Appends an expression without prefixes, and replaces each `$name`.
    void append_body(const Reading& from, std::size_t begin) {
        const std::string_view text = from.text;
        std::size_t copied = begin;
        for (std::size_t at = begin; at < text.size();) {
            if (text[at] == '\'') {
                at = quote_end(text, at);
            } else if (text[at] == '#') {
                at = std::min(text.find('\n', at), text.size());
            } else if (text[at] == '<' && !from.group.empty() && light_end(text, at) != at) {
                copy(from, copied, at);
                insert(from, at, "<L." + quoted_label(from.group) + ">");
                at = copied = light_end(text, at);
            } else if (text[at] == '$') {
                copy(from, copied, at);
                at = copied = append_name(from, at);
            } else {
                ++at;
            }
        }
        copy(from, copied, text.size());
    }

    /// Appends the definition of `$name` or `${name}` at byte `at`; returns the end of the name.
    std::size_t append_name(const Reading& from, std::size_t at) {
        const bool braces = at + 1 < from.text.size() && from.text[at + 1] == '{';
        const std::size_t begin = at + (braces ? 2 : 1);
        const std::size_t end = name_end(from.text, begin);
        const std::string_view name = from.text.substr(begin, end - begin);
        if (name.empty()) { fail_at(from, begin, "expected a name after '$', as in $myDiffuse or ${myDiffuse}"); }
        if (braces && (end >= from.text.size() || from.text[end] != '}')) {
            fail_at(from, end, "expected '}' after the name '" + std::string(name) + "'");
        }
        const std::optional<Resolved> known = resolve(name);
        if (!known) { fail_unknown(from, begin, name); }
        const Head head = read_head(known->definition.expression);
        if (!head.first_prefix.empty()) {
            fail_at(from, begin,
                    "'" + std::string(name) + "' has the prefix '" + std::string(head.first_prefix) +
                        "', so it must be the whole channel; expected a name without prefixes here");
        }
        note_group(*known, name, from.group);
        enter(from, begin, name);
        insert(from, at, "(");
        append_whole(known->definition, known->group.empty() ? from.group : known->group, known->via);
        insert(from, at, ")");
        open_.pop_back();
        return end + (braces ? 1 : 0);
    }

    void enter(const Reading& from, std::size_t at, std::string_view name) {
        const auto again = std::find(open_.begin(), open_.end(), name);
        if (again != open_.end()) {
            std::string circle;
            for (auto it = again; it != open_.end(); ++it) { circle += *it + " -> "; }
            fail_at(from, at, "the macro '" + std::string(name) + "' uses itself: " + circle + std::string(name));
        }
        if (open_.size() >= limits::macro_depth) {
            fail_at(from, at, "macros use one another more than " + std::to_string(limits::macro_depth) + " deep");
        }
        open_.emplace_back(name);
    }

    [[nodiscard]] std::optional<ChannelSource> definition_of(std::string_view name) const {
        if (const ChannelSource* macro = macros_.find(name)) { return *macro; }
        for (const NamedExpression& entry : builtin_names()) {
            if (entry.name == name) {
                ChannelSource source;
                source.expression = entry.expression;
                source.origin = "built-in name '" + std::string(name) + "'";
                return source;
            }
        }
        return std::nullopt;
    }

    [[nodiscard]] std::optional<Resolved> resolve(std::string_view name) const {
        const std::string via = "in the macro '" + std::string(name) + "'";
        if (std::optional<ChannelSource> whole = definition_of(name)) { return Resolved{std::move(*whole), {}, via}; }
        for (std::size_t bar = name.rfind('_'); bar != std::string_view::npos && bar > 0;
             bar = name.rfind('_', bar - 1)) {
            std::optional<ChannelSource> stem =
                bar + 1 < name.size() ? definition_of(name.substr(0, bar)) : std::nullopt;
            if (stem) { return Resolved{std::move(*stem), std::string(name.substr(bar + 1)), via}; }
        }
        return std::nullopt;
    }

    [[noreturn]] void fail_unknown(const Reading& from, std::size_t at, std::string_view name) const {
        std::vector<std::string_view> known;
        for (const ChannelSource& macro : macros_.list()) { known.push_back(macro.name); }
        for (const NamedExpression& entry : builtin_names()) { known.push_back(entry.name); }
        const std::string near = nearest(name, known.data(), known.size());
        std::string list;
        for (const std::string_view each : known) { list += (list.empty() ? "" : ", ") + std::string(each); }
        fail_at(from, at, "unknown name '" + std::string(name) + "'; expected an expression, or one of: " + list,
                near.empty() ? "labels are quoted, as in <RD'floor'>" : "did you mean '" + near + "'?");
    }

    /// Records a warning if a light group has no effect.
    void note_group(const Resolved& known, std::string_view name, const std::string& group) {
        if (!known.group.empty() && !has_lights(known.definition.expression)) {
            expansion_.warnings.push_back("'" + std::string(name) + "': no <L.> in '" + known.definition.expression +
                                          "', so the light group '" + known.group + "' changes nothing");
        } else if (!known.group.empty() && !group.empty() && known.group != group) {
            expansion_.warnings.push_back("'" + std::string(name) + "' keeps its own light group '" + known.group +
                                          "'");
        }
    }

    /// The end of `<L.>` at byte `at`, with optional blanks; `at` when the text differs.
    static std::size_t light_end(std::string_view text, std::size_t at) {
        std::size_t end = at;
        for (const char wanted : {'<', 'L', '.', '>'}) {
            end = skip_blank(text, end);
            if (end >= text.size() || text[end] != wanted) { return at; }
            ++end;
        }
        return end;
    }

    static bool has_lights(std::string_view text) {
        for (std::size_t at = 0; at < text.size();) {
            if (text[at] == '\'') {
                at = quote_end(text, at);
            } else if (text[at] == '$' || (text[at] == '<' && light_end(text, at) != at)) {
                return true;
            } else {
                ++at;
            }
        }
        return !name_alone(text).empty();
    }

    const MacroTable& macros_;
    Expansion expansion_;
    SourceMap* map_ = nullptr;
    std::vector<std::string> open_;  // names under expansion, outermost first
};

/// Returns whether the text can contain a name; most expressions contain none.
bool may_have_names(std::string_view text) {
    if (text.find('$') != std::string_view::npos) { return true; }
    return !lone_name(text).empty();
}

}  // namespace

std::string_view name_alone(std::string_view text) {
    const std::string_view name = lone_name(text);
    if (name.empty() || reads_as_expression(name)) { return {}; }
    return text.substr(static_cast<std::size_t>(name.data() - text.data()));
}

std::span<const NamedExpression> builtin_names() {
    return builtin_table;
}

Status MacroTable::add(ChannelSource definition) {
    return guarded([&] {
        const auto refuse = [&](std::string message, std::string hint = {}) {
            Error error;
            error.message = std::move(message);
            error.hint = std::move(hint);
            throw Failure{SourceText::whole_error(definition, std::move(error))};
        };
        if (!is_name(definition.name)) {
            refuse("'" + definition.name +
                   "' cannot be the name of a macro; expected letters, digits and _, a letter or _ first");
        }
        if (reads_as_expression(definition.name)) {
            refuse("the macro name '" + definition.name +
                   "' reads as an expression; expected a name with another letter in it");
        }
        if (skip_blank(definition.expression, 0) == definition.expression.size()) {
            refuse("the macro '" + definition.name + "' is empty; expected an expression");
        }
        const auto [place, fresh] = index_.emplace(definition.name, list_.size());
        if (!fresh) {
            refuse("the macro '" + definition.name + "' is defined twice; expected one definition",
                   list_[place->second].origin.empty() ? "" : "the first one is in " + list_[place->second].origin);
        }
        list_.push_back(std::move(definition));
        return std::monostate{};
    });
}

const ChannelSource* MacroTable::find(std::string_view name) const {
    const auto found = index_.find(name);
    return found == index_.end() ? nullptr : &list_[found->second];
}

Result<Expansion> expand_names(const ChannelSource& source, const MacroTable& macros) {
    return guarded([&]() -> Expansion {
        if (source.dialect != Dialect::renderman || !source.rest_of.empty() || !may_have_names(source.expression)) {
            return {source, {}};
        }
        return Expander(source, macros).run(source);
    });
}

}  // namespace raylex::lpe
