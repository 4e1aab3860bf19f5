// The parameter lists of directives: "type name" followed by one value or a bracketed list of values.
#pragma once

#include "display/services/parameters.h"
#include "transport/import/tokenizer.h"

namespace raylex::transport {

/// A finite number from a word; infinite, NaN and other words are Errors that end in "expected <expected>".
Result<double> parse_number(const Tokenizer& tokenizer, const Token& token, const std::string& expected);

/// All parameters that follow, up to the next directive. A name given twice keeps its last value and adds a warning.
Status parse_parameters(Tokenizer& tokenizer, ParameterSet& set, std::vector<Error>& warnings);

}  // namespace raylex::transport
