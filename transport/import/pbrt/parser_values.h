// The parameter lists of directives: "type name" followed by one value or a bracketed list of values.
#pragma once

#include "display/services/parameters.h"
#include "transport/files/tokenizer.h"

namespace raylex::transport {

/// A finite number from a word; infinite, NaN and other words are Errors that end in "expected <expected>".
Result<double> parse_number(const Tokenizer& tokenizer, const Token& token, const std::string& expected);

/// All parameters that follow, up to the next directive. A name given twice keeps its last value and adds a warning.
Status parse_parameters(Tokenizer& tokenizer, ParameterSet& set, std::vector<Error>& warnings);

/// What stands between `name`, an option's without a type, and the next directive: one value, which says its type.
/// pbrt takes letter case, '-' and '_' of such names for nothing.
Status parse_option(Tokenizer& tokenizer, const Token& name, ParameterSet& set);

}  // namespace raylex::transport
