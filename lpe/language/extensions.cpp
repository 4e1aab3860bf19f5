#include "lpe/language/extensions.h"

#include <algorithm>
#include <utility>

#include "lpe/failure.h"
#include "lpe/language/names.h"
#include "lpe/language/prefixes.h"
#include "lpe/language/source_text.h"

namespace raylex::lpe {

namespace {

struct Extension {
    std::string what;
    std::size_t offset;
};

/// Returns the end of the label that opens at `at`; clears `plain` if the label contains wildcards or escapes.
std::size_t label_end(std::string_view text, std::size_t at, bool& plain) {
    std::size_t i = at + 1;
    for (; i < text.size() && text[i] != '\''; ++i) {
        plain = plain && std::string_view("*?\\").find(text[i]) == std::string_view::npos;
        i += text[i] == '\\' ? 1 : 0;
    }
    return i;
}

std::string extension_at(std::string_view text, std::size_t at) {
    switch (text[at]) {
        case 'B':
        case 'V':
        case 'G':
        case '?':
        case '&':
        case '!':
        case '-':
        case '$':
            return std::string(1, text[at]);
        case ' ':
        case '\t':
        case '\r':
        case '\n':
            return "a blank";
        case '#':
            return "a comment";
        case '{': {
            const std::string_view count = text.substr(at, text.find('}', at) - at);
            return count.find(',') != std::string_view::npos ? "{n,m}" : "";
        }
        default:
            return "";
    }
}

/// The prefix that ends before `at`, if it is one of raylex's extensions.
std::string prefix_before(std::string_view text, std::size_t at) {
    const std::size_t before = text.substr(0, at).find_last_of(":; \t\r\n");
    const std::string_view word = text.substr(before + 1, at - before - 1);
    return word == "unweighted" || technique_prefix(word) ? std::string(word) + ";" : "";
}

std::vector<Extension> find_extensions(std::string_view expression) {
    std::vector<Extension> found;
    const auto add = [&found](const std::string& what, std::size_t offset) {
        const auto same = [&what](const Extension& each) { return each.what == what; };
        if (!what.empty() && std::none_of(found.begin(), found.end(), same)) { found.push_back({what, offset}); }
    };
    const std::size_t end = expression.size() - name_alone(expression).size();  // letters of a name are not events
    for (std::size_t i = 0; i < end; ++i) {
        const std::size_t begin = i;
        if (expression[i] == '\'') {
            bool plain = true;
            i = label_end(expression, i, plain);
            add(plain ? "" : "a glob in a label", begin);
            continue;
        }
        add(expression[i] == ';' ? prefix_before(expression, i) : extension_at(expression, i), begin);
        if (expression[i] == '#') { i = std::min(expression.find('\n', i), expression.size()); }
    }
    return found;
}

}  // namespace

std::vector<std::string> extensions_in(std::string_view expression) {
    std::vector<std::string> found;
    for (Extension& each : find_extensions(expression)) { found.push_back(std::move(each.what)); }
    return found;
}

bool names_volume(std::string_view expression) {
    const std::vector<std::string> found = extensions_in(expression);
    return std::find(found.begin(), found.end(), "V") != found.end();
}

Status renderman_reads(const ChannelSource& source, bool without_blanks) {
    return guarded([&] {
        std::vector<Extension> found = find_extensions(source.expression);
        if (without_blanks) {
            std::erase_if(found,
                          [](const Extension& each) { return each.what == "a blank" || each.what == "a comment"; });
        }
        if (source.dialect != Dialect::renderman || found.empty()) { return std::monostate{}; }
        std::string list;
        for (const Extension& each : found) {
            const std::string text = each.what.size() == 1 ? "'" + each.what + "'" : each.what;
            list += (list.empty() ? "" : ", ") + text;
        }
        const std::string who = source.name.empty() ? "the expression" : "'" + source.name + "'";
        std::string hint = found.front().what == "G" ? "S is every specular lobe there, glossy or not; " : "";
        hint += found.front().what == "V" ? "--no-volume leaves scattering in media out; " : "";
        SourceText(source).fail_at(
            found.front().offset,
            who + " has " + list + ", which RenderMan does not support; expected " + "RenderMan's own language",
            hint + "--for raylex allows raylex's extensions");
    });
}

}  // namespace raylex::lpe
