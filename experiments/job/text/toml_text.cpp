#include "experiments/job/text/toml_text.h"

#include <algorithm>
#include <vector>

namespace raylex::experiments {

namespace {

/// Measures the nesting depth of brackets, braces and dotted keys without parsing. The dot of a number counts like that
/// of a key, but adds at most one, far below any useful budget.
class DepthMeter {
  public:
    explicit DepthMeter(std::string_view text) : text_(text) {}

    /// Returns the position where the depth exceeds `most`, or npos.
    std::size_t exceeds(std::size_t most) {
        while (at_ < text_.size()) {
            const std::size_t here = at_;
            step();
            if (enclosing_ + dots_ > most) return here;
        }
        return std::string_view::npos;
    }

  private:
    void step() {
        const char c = text_[at_];
        if (c == '"' || c == '\'') return string();
        if (c == '#') return comment();
        ++at_;
        if (c == '.') {
            ++dots_;
        } else if (c == '[' || c == '{') {
            open_.push_back(1 + dots_);
            enclosing_ += open_.back();
            dots_ = 0;
        } else if ((c == ']' || c == '}') && !open_.empty()) {
            enclosing_ -= open_.back();
            open_.pop_back();
            dots_ = 0;
        } else if (c == ',' || c == '\n') {
            dots_ = 0;
        }
    }
    void comment() { at_ = std::min(text_.find('\n', at_), text_.size()); }
    void string() {
        const char quote = text_[at_];
        const bool triple = text_.substr(at_, 3) == std::string(3, quote);
        const std::string_view end = triple ? text_.substr(at_, 3) : text_.substr(at_, 1);
        for (at_ += end.size(); at_ < text_.size(); ++at_) {
            if (quote == '"' && text_[at_] == '\\') ++at_;
            else if (!triple && text_[at_] == '\n') return;
            else if (text_.substr(at_, end.size()) == end) {
                at_ += end.size();
                return;
            }
        }
        at_ = text_.size();
    }

    std::string_view text_;
    std::size_t at_ = 0, dots_ = 0, enclosing_ = 0;
    std::vector<std::size_t> open_;  ///< depth of each open bracket: itself and the dots of its key
};

}  // namespace

Result<std::string> read_toml_file(const std::string& path, NamedBy by, const std::string& expected) {
    return read_input(path, by, expected, Budget::toml_bytes);
}

Status check_toml_depth(std::string_view text, const std::string& path) {
    const std::size_t at = DepthMeter(text).exceeds(budget(Budget::toml_depth));
    if (at == std::string_view::npos) return success();
    const std::string_view before = text.substr(0, at);
    const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    const auto line = static_cast<int>(1 + std::count(before.begin(), before.end(), '\n'));
    return over_budget(Budget::toml_depth, "tables and arrays nested too deeply", path, line,
                       static_cast<int>(at - line_start) + 1);
}

Result<toml::table> parse_toml(std::string_view text, const std::string& path) {
    if (Status shallow = check_toml_depth(text, path); !shallow) return shallow.error();
    try {
        return toml::parse(text, std::string_view(path));
    } catch (const toml::parse_error& error) {
        TomlSource source(path, text);
        source.fail(source.location(error.source()), "this is not valid TOML: " + std::string(error.description()));
        return *source.error();
    }
}

}  // namespace raylex::experiments
