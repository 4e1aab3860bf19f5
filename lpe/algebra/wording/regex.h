// Builds regular expressions as texts, and simplifies them during construction.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lpe/language/event_classes.h"

namespace raylex::lpe {

struct Regex;
using RegexPtr = std::shared_ptr<const Regex>;

/// A language of words. Null is the empty language.
struct Regex {
    enum class Kind { epsilon, events, sequence, alternatives, repeat };
    static constexpr int unbounded = -1;

    Kind kind = Kind::epsilon;
    ClassSet events;
    std::vector<RegexPtr> parts;  // of a sequence or of alternatives; the single part of a repetition
    int min = 1, max = 1;
    std::string text;  // as written in a sequence; equal texts are equal languages
    bool nullable = false;
};

/// Builds simplified expressions and their texts. It sets `failed` when a set of events has no text, or when an
/// expression exceeds the length limit.
class RegexBuilder {
  public:
    /// `write` converts a set of events to one item, or returns nothing. Without `optional_mark`, X?Y is written Y|XY.
    RegexBuilder(std::function<std::optional<std::string>(const ClassSet&)> write, std::size_t longest,
                 bool optional_mark = true)
        : write_(std::move(write)), longest_(longest), optional_mark_(optional_mark) {}

    [[nodiscard]] bool failed() const { return failed_; }

    [[nodiscard]] RegexPtr epsilon();
    [[nodiscard]] RegexPtr events(ClassSet set);
    [[nodiscard]] RegexPtr sequence(const RegexPtr& a, const RegexPtr& b);
    [[nodiscard]] RegexPtr alternatives(const RegexPtr& a, const RegexPtr& b);
    [[nodiscard]] RegexPtr star(const RegexPtr& a);
    /// The text of a whole expression.
    [[nodiscard]] std::string text(const RegexPtr& regex) const;

  private:
    [[nodiscard]] RegexPtr finish(Regex regex);
    [[nodiscard]] RegexPtr repeat(const RegexPtr& part, int min, int max);
    [[nodiscard]] RegexPtr sequence_of(std::vector<RegexPtr> parts);
    [[nodiscard]] RegexPtr alternatives_of(std::vector<RegexPtr> parts);
    [[nodiscard]] bool merge(std::vector<RegexPtr>& parts);
    [[nodiscard]] RegexPtr merged(const RegexPtr& a, const RegexPtr& b);
    [[nodiscard]] RegexPtr factored(const RegexPtr& a, const RegexPtr& b, bool from_front);

    std::function<std::optional<std::string>(const ClassSet&)> write_;
    std::size_t longest_;
    bool optional_mark_;
    bool failed_ = false;
};

}  // namespace raylex::lpe
