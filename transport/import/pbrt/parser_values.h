// The parameter lists of directives: "type name" followed by one value or a bracketed list of values.
#pragma once

#include "display/services/parameters.h"
#include "transport/files/tokenizer.h"

namespace raylex::transport {

/// Parses a word as a finite number. Other words, infinity and NaN are Errors that end in "expected <expected>".
Result<double> parse_number(const Tokenizer& tokenizer, const Token& token, const std::string& expected);

/// Parses all parameters up to the next directive. A name given twice keeps its last value and adds a warning.
Status parse_parameters(Tokenizer& tokenizer, ParameterSet& set, std::vector<Error>& warnings);

/// Parses the value of the option `name`, which has no type: one value, which determines the type. Like pbrt, it
/// ignores letter case, '-' and '_' in such names.
Status parse_option(Tokenizer& tokenizer, const Token& name, ParameterSet& set);

}  // namespace raylex::transport
