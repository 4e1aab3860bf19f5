#include "transport/files/tokenizer.h"

#include <utility>

namespace raylex::transport {

void Tokenizer::skip_blanks() {
    for (; at_ < text_.size(); ++at_) {
        const char c = text_[at_];
        if (c == '\n') {
            ++line_;
            line_start_ = at_ + 1;
        } else if (c == '#') {
            at_ = end_of_comment(at_) - 1;
        } else if (!is_blank(c)) {
            return;
        }
    }
}

Result<Token> Tokenizer::next() {
    if (std::exchange(has_pushed_, false)) return pushed_;
    skip_blanks();
    Token token;
    token.line = line_;
    token.column = static_cast<int>(at_ - line_start_) + 1;
    if (at_ == text_.size()) return token;
    const char first = text_[at_];
    if (first == '"') return string_token(token);
    std::size_t stop = at_ + 1;
    if (first == '[' || first == ']') {
        token.kind = first == '[' ? TokenKind::open_bracket : TokenKind::close_bracket;
    } else {
        token.kind = TokenKind::word;
        while (stop < text_.size() && !ends_word(text_[stop])) ++stop;
    }
    token.text = text_.substr(at_, stop - at_);
    at_ = stop;
    return token;
}

std::size_t Tokenizer::words_in_list() const {
    std::size_t words = 0;
    bool between = true;
    for (std::size_t i = at_; i < text_.size() && text_[i] != ']' && text_[i] != '"'; ++i) {
        const bool comment = text_[i] == '#';
        if (comment) i = end_of_comment(i) - 1;
        const bool blank = comment || is_blank(text_[i]);
        words += between && !blank ? 1 : 0;
        between = blank;
    }
    return words;
}

Result<Token> Tokenizer::string_token(Token token) {
    token.kind = TokenKind::string;
    for (std::size_t stop = at_ + 1; stop < text_.size() && text_[stop] != '\n'; ++stop) {
        if (text_[stop] == '\\') {
            token.escaped = true;
            ++stop;
            if (stop < text_.size() && text_[stop] == '\n') break;
        } else if (text_[stop] == '"') {
            token.text = text_.substr(at_ + 1, stop - at_ - 1);
            at_ = stop + 1;
            return token;
        }
    }
    return error(token, "string is not closed; expected '\"' before the end of the line");
}

Error Tokenizer::error(const Token& at, std::string message, std::string hint) const {
    Error result = error_at(location(at), std::move(message), std::move(hint));
    result.excerpt = excerpt_of(text_, at.line);
    return result;
}

Result<std::string> unescape(const Tokenizer& tokenizer, const Token& token) {
    if (!token.escaped) return std::string(token.text);
    std::string result;
    for (std::size_t i = 0; i < token.text.size(); ++i) {
        char c = token.text[i];
        if (c == '\\' && i + 1 < token.text.size()) {
            constexpr std::string_view letters = "bfnrt\\'\"", meanings = "\b\f\n\r\t\\'\"";
            const std::size_t which = letters.find(token.text[++i]);
            if (which == std::string_view::npos)
                return tokenizer.error(token, std::string("unknown escape '\\") + token.text[i] +
                                                  "' in a string; expected one of \\b \\f \\n \\r \\t \\\\ \\' \\\"");
            c = meanings[which];
        }
        result += c;
    }
    return result;
}

std::string describe(const Token& token) {
    switch (token.kind) {
        case TokenKind::end:
            return "the end of the file";
        case TokenKind::open_bracket:
            return "'['";
        case TokenKind::close_bracket:
            return "']'";
        case TokenKind::word:
        case TokenKind::string:
            break;
    }
    constexpr std::size_t most = 40;
    std::string shown;
    for (const char c : token.text.substr(0, most)) {
        const auto byte = static_cast<unsigned char>(c);
        shown += byte < 0x20 || byte == 0x7f ? '?' : c;
    }
    if (token.text.size() > most) shown += "...";
    return token.kind == TokenKind::string ? "string \"" + shown + "\"" : "'" + shown + "'";
}

std::string excerpt_of(std::string_view text, int line) {
    for (int skipped = 1; skipped < line; ++skipped) {
        const std::size_t newline = text.find('\n');
        if (newline == std::string_view::npos) return {};
        text.remove_prefix(newline + 1);
    }
    constexpr std::size_t most = 160;
    std::string_view shown = text.substr(0, text.find('\n'));
    if (!shown.empty() && shown.back() == '\r') shown.remove_suffix(1);
    const bool cut = shown.size() > most;
    std::string excerpt(shown.substr(0, most));
    for (char& c : excerpt)
        if (c != '\t' && static_cast<unsigned char>(c) < 0x20) c = '?';
    return cut ? excerpt + " ..." : excerpt;
}

}  // namespace raylex::transport
