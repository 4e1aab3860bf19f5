#include "experiments/job/channels/likely_mistakes.h"

#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "lpe/algebra/proofs/check.h"

namespace raylex::experiments {
namespace {

/// Splits an expression into its prefixes ("lpe:", "noclamp;") and the rest.
std::pair<std::string, std::string> parts_of(const std::string& expression) {
    std::size_t begin = expression.rfind(';');
    begin = begin == std::string::npos ? 0 : begin + 1;
    if (expression.compare(begin, 4, "lpe:") == 0) begin += 4;
    return {expression.substr(0, begin), expression.substr(begin)};
}

/// Returns the expression with each top-level alternative in parentheses, because '|' binds tighter than sequence.
std::string parenthesised(const std::string& text) {
    std::string result = "(";
    int depth = 0;
    bool quoted = false, several = false;
    for (const char c : text) {
        quoted = quoted != (c == '\'');
        if (!quoted) depth += c == '(' || c == '[' || c == '<' ? 1 : c == ')' || c == ']' || c == '>' ? -1 : 0;
        const bool parts = c == '|' && depth == 0 && !quoted;
        several = several || parts;
        result += parts ? ")|(" : std::string(1, c);
    }
    return several ? result + ")" : text;
}

/// Replaces L'key' by <L.'key'>, the syntax of other labelled events. Not done by std::regex, which recurses for each
/// character within quotes and would exceed the stack for long expressions (lpe/limits.h).
std::string labelled_lights(std::string_view text) {
    constexpr auto none = std::string_view::npos;
    std::string result;
    for (std::size_t at = 0; at < text.size();) {
        const bool light = (text[at] == 'L' || text[at] == 'B' || text[at] == 'O') && text.substr(at + 1, 1) == "'";
        const std::size_t close = light ? text.find('\'', at + 2) : none;
        if (close == none) {
            result += text[at++];
            continue;
        }
        result += '<' + std::string(1, text[at]) + '.' + std::string(text.substr(at + 1, close - at)) + '>';
        at = close + 1;
    }
    return result;
}

}  // namespace

std::string likely_mistake(const lpe::ChannelSource& channel, const lpe::PathStrings& words) {
    const auto [prefixes, text] = parts_of(channel.expression);
    struct Mistake {
        const char* what;
        std::string meant;
    };
    const std::string labelled = labelled_lights(text);
    const std::vector<Mistake> mistakes{
        {"it does not end at a light (L, B or O)", text + "L"},
        {"it does not begin at the camera (C)", "C" + text},
        {"it has neither the camera (C) nor a light (L, B or O)", "C" + text + "L"},
        {"a light's group belongs into its event", labelled},
        {"a light's group belongs into its event, and a path begins at the camera", "C" + labelled},
        {"'|' joins only the items directly before and after it", parenthesised(text)}};
    for (const Mistake& mistake : mistakes) {
        lpe::ChannelSource corrected;
        corrected.expression = prefixes + mistake.meant;
        corrected.dialect = channel.dialect;
        if (mistake.meant == text) continue;
        const auto word = lpe::find_path_string(corrected, words);
        if (word && *word) return std::string(mistake.what) + "; did you mean '" + corrected.expression + "'?";
    }
    return {};
}

}  // namespace raylex::experiments
