// Finds the source position of each character of a TOML string. toml++ gives a string's value and its beginning, so
// this code reads the text again (TOML 1.0, section String) to follow escapes.
#include <algorithm>

#include "experiments/job/text/toml_table.h"

namespace raylex::experiments {
namespace {

void append_utf8(std::string& text, std::uint32_t code_point) {
    const auto byte = [&](std::uint32_t value) { text += static_cast<char>(value); };
    if (code_point < 0x80) {
        byte(code_point);
    } else if (code_point < 0x800) {
        byte(0xC0U | code_point >> 6);
        byte(0x80U | (code_point & 0x3FU));
    } else if (code_point < 0x10000) {
        byte(0xE0U | code_point >> 12);
        byte(0x80U | (code_point >> 6 & 0x3FU));
        byte(0x80U | (code_point & 0x3FU));
    } else {
        byte(0xF0U | code_point >> 18);
        byte(0x80U | (code_point >> 12 & 0x3FU));
        byte(0x80U | (code_point >> 6 & 0x3FU));
        byte(0x80U | (code_point & 0x3FU));
    }
}

/// Reads one string, starting at its opening quote.
class StringFollower {
  public:
    StringFollower(const std::shared_ptr<const lpe::TextFile>& file, std::size_t opening) : file_(file), at_(opening) {}

    std::shared_ptr<const lpe::SourceMap> run(const std::string& value) {
        const std::string& text = file_->text;
        if (at_ >= text.size() || (text[at_] != '"' && text[at_] != '\'')) return nullptr;
        const char quote = text[at_];
        const bool triple = text.compare(at_, 3, std::string(3, quote)) == 0 && value.size() > 0;
        at_ += triple ? 3 : 1;
        if (triple && at_ < text.size() && text[at_] == '\r') ++at_;
        if (triple && at_ < text.size() && text[at_] == '\n') ++at_;
        while (decoded_.size() < value.size() && at_ < text.size()) {
            if (quote == '"' && text[at_] == '\\') {
                if (!take_escape()) return nullptr;
            } else {
                place();
                decoded_ += text[at_++];
            }
        }
        if (decoded_ != value) return nullptr;
        return std::make_shared<const lpe::SourceMap>(std::move(map_));
    }

  private:
    /// Records the source position of the next decoded character.
    void place() {
        const auto& spans = map_.spans;
        if (!spans.empty() && spans.back().position + (decoded_.size() - spans.back().offset) == at_) return;
        map_.spans.push_back({decoded_.size(), file_, at_, {}});
    }

    bool take_escape() {
        const std::string& text = file_->text;
        const char c = at_ + 1 < text.size() ? text[at_ + 1] : '\0';
        if (c == '\n' || c == '\r' || c == ' ' || c == '\t') {  // the end of a line and the blanks after it
            at_ = std::min(text.find_first_not_of(" \t\r\n", at_ + 1), text.size());
            return true;
        }
        place();
        if (c == 'u' || c == 'U') {
            const std::size_t digits = c == 'u' ? 4 : 8;
            std::uint32_t code_point = 0;
            for (std::size_t i = at_ + 2; i < at_ + 2 + digits; ++i) {
                const char digit = i < text.size() ? static_cast<char>(text[i] | 0x20) : '\0';
                const bool decimal = digit >= '0' && digit <= '9', letter = digit >= 'a' && digit <= 'f';
                if (!decimal && !letter) return false;
                code_point = code_point * 16 + static_cast<std::uint32_t>(decimal ? digit - '0' : digit - 'a' + 10);
            }
            append_utf8(decoded_, code_point);
            at_ += 2 + digits;
            return true;
        }
        constexpr std::string_view names = "btnfr\"\\", values = "\b\t\n\f\r\"\\";
        const std::size_t known = names.find(c);
        if (known == std::string_view::npos) return false;
        decoded_ += values[known];
        at_ += 2;
        return true;
    }

    std::shared_ptr<const lpe::TextFile> file_;
    std::size_t at_;
    std::string decoded_;
    lpe::SourceMap map_;
};

}  // namespace

std::shared_ptr<const lpe::SourceMap> TomlSource::string_map(const toml::node& node) const {
    const auto* value = node.as_string();
    const SourceLocation where = location(node);
    if (value == nullptr || where.line < 1 || static_cast<std::size_t>(where.line) > lines_.size()) return nullptr;
    std::size_t begin = 0;
    for (int line = 1; line < where.line; ++line) begin = text_->text.find('\n', begin) + 1;
    return StringFollower(text_, begin + static_cast<std::size_t>(where.column) - 1).run(value->get());
}

}  // namespace raylex::experiments
