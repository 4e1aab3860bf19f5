// Splits the text of a pbrt scene into tokens: words, quoted strings and brackets; '#' starts a comment.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::transport {

enum class TokenKind : std::uint8_t { word, string, open_bracket, close_bracket, end };

struct Token {
    TokenKind kind = TokenKind::end;
    std::string_view text;     ///< as written; for a string: the text between the quotes, escapes not yet replaced
    bool escaped = false;      ///< the token is a string that contains a backslash
    int line = 1, column = 1;  ///< of its first byte
};

class Tokenizer {
  public:
    /// `text` and `file` must outlive the tokenizer.
    Tokenizer(std::string_view text, const std::string& file) : text_(text), file_(file) {}

    /// Returns the next token; at the end of the text, TokenKind::end each time. Error: a string that is not closed.
    Result<Token> next();
    /// Appends the numbers that follow to `numbers`, up to the first word that std::from_chars does not read as a
    /// number or that `accept(value)` refuses; next() returns that word. This reads lists of millions of numbers
    /// without a Token for each.
    template <class Accept>
    void take_numbers(std::vector<double>& numbers, const Accept& accept);
    /// The number of words before the next ']' or string: the expected length of a list of numbers. It stops there, so
    /// that the scanned text is read next or is an error: a file is scanned at most twice.
    [[nodiscard]] std::size_t words_in_list() const;
    /// Makes next() return `token` once more.
    void push_back(const Token& token) { pushed_ = token, has_pushed_ = true; }

    [[nodiscard]] Error error(const Token& at, std::string message, std::string hint = {}) const;
    [[nodiscard]] SourceLocation location(const Token& token) const { return {file_, token.line, token.column}; }
    [[nodiscard]] const std::string& file() const { return file_; }

  private:
    void skip_blanks();
    Result<Token> string_token(Token token);
    [[nodiscard]] static constexpr bool is_blank(char c) {
        return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
    }
    [[nodiscard]] static constexpr bool ends_word(char c) {
        return is_blank(c) || c == '"' || c == '[' || c == ']' || c == '#';
    }
    /// The position after the comment that begins at `at`; old Macintosh files end lines by "\r".
    [[nodiscard]] std::size_t end_of_comment(std::size_t at) const {
        return std::min(text_.find_first_of("\r\n", at), text_.size());
    }

    std::string_view text_;
    const std::string& file_;
    std::size_t at_ = 0, line_start_ = 0;
    int line_ = 1;
    Token pushed_;
    bool has_pushed_ = false;
};

template <class Accept>
void Tokenizer::take_numbers(std::vector<double>& numbers, const Accept& accept) {
    if (has_pushed_) return;
    const char* const end = text_.data() + text_.size();
    while (true) {
        skip_blanks();
        const char* const begin = text_.data() + at_;
        double value = 0;
        const auto [stop, status] = std::from_chars(begin, end, value);
        if (status != std::errc() || (stop != end && !ends_word(*stop)) || !accept(value)) return;
        numbers.push_back(value);
        at_ += static_cast<std::size_t>(stop - begin);
    }
}

/// The string of a token. Escapes are those of JSON: \b \f \n \r \t \\ \' \"; any other is an Error of `tokenizer`.
Result<std::string> unescape(const Tokenizer& tokenizer, const Token& token);

/// A token for a message: in quotes, at most 40 bytes, unprintable bytes as '?'.
std::string describe(const Token& token);

/// Line `line` (from 1) of `text` for an Error's excerpt, cut to a length that a terminal shows.
std::string excerpt_of(std::string_view text, int line);

}  // namespace raylex::transport
