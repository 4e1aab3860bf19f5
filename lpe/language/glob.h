// Label globs: '*' stands for any text, '?' for one UTF-8 character, '\' takes the next byte as it is.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace raylex::lpe {

[[nodiscard]] bool glob_matches(std::string_view glob, std::string_view label);

/// Whether the text has a '*', '?' or '\' that makes it a glob rather than a name.
[[nodiscard]] bool is_glob(std::string_view text);

/// The label as expressions of `renderman` write it: 'floor', with a backslash before quotes, '*', '?' and '\'.
[[nodiscard]] std::string quoted_label(std::string_view label);

/// One kind of label that none of `names` equals: which globs match it, and the shortest label of that kind.
struct LabelKind {
    std::vector<bool> globs_matched;
    std::string example;
};

/// Every combination of globs that some label not among `names` realises, exactly. Throws Failure when the globs are
/// too many to combine.
[[nodiscard]] std::vector<LabelKind> label_kinds(const std::vector<std::string>& globs,
                                                 const std::vector<std::string>& names);

}  // namespace raylex::lpe
