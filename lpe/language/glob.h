// Label globs: '*' matches any text, '?' matches one UTF-8 character, '\' makes the next byte literal.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace raylex::lpe {

[[nodiscard]] bool glob_matches(std::string_view glob, std::string_view label);

/// Returns whether the text contains '*', '?' or '\', so that it is a glob and not a name.
[[nodiscard]] bool is_glob(std::string_view text);

/// The label in the notation of `renderman`: 'floor', with a backslash before quotes, '*', '?' and '\'.
[[nodiscard]] std::string quoted_label(std::string_view label);

/// A kind of label outside `names`: the globs that match it, and the shortest label of the kind.
struct LabelKind {
    std::vector<bool> globs_matched;
    std::string example;
};

/// All combinations of globs that some label outside `names` matches. Throws Failure when the globs have too many
/// combinations.
[[nodiscard]] std::vector<LabelKind> label_kinds(const std::vector<std::string>& globs,
                                                 const std::vector<std::string>& names);

}  // namespace raylex::lpe
