#include "lpe/language/extensions.h"

#include <algorithm>

namespace raylex::lpe {

namespace {

/// The end of the label that is opened at `at`; whether it is more than plain text is said in `plain`.
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

}  // namespace

std::vector<std::string> extensions_in(std::string_view expression) {
    std::vector<std::string> found;
    const auto add = [&found](const std::string& each) {
        if (!each.empty() && std::find(found.begin(), found.end(), each) == found.end()) { found.push_back(each); }
    };
    for (std::size_t i = 0; i < expression.size(); ++i) {
        if (expression[i] == '\'') {
            bool plain = true;
            i = label_end(expression, i, plain);
            add(plain ? "" : "a glob in a label");
            continue;
        }
        add(extension_at(expression, i));
        if (expression[i] == '#') { i = std::min(expression.find('\n', i), expression.size()); }
    }
    return found;
}

bool names_volume(std::string_view expression) {
    const std::vector<std::string> found = extensions_in(expression);
    return std::find(found.begin(), found.end(), "V") != found.end();
}

}  // namespace raylex::lpe
