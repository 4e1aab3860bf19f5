// Formulas of numbers, as cases write them: "0.5^k", "2*_pi*(1 - sqrt(1 - s^2))". muParser reads them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Numbers by name.
using Numbers = std::map<std::string, double>;

/// What one line of a case is about: all its numbers and words, constant or varied.
struct Setting {
    Numbers numbers;
    std::map<std::string, std::string> words;
    std::string text;  ///< of what varies: "g = 0.5, alpha = 1e-3"
};

/// Operators + - * / ^, functions sin, sqrt, exp, ln, abs, min, max ..., constants _pi and _e, doubles throughout.
/// An Error at `where` says what is wrong, and which numbers there are where the formula asks for another.
Result<double> evaluate(const std::string& formula, const Numbers& numbers, const SourceLocation& where);

/// The text with every ${...} replaced: by a word, or by the value of a formula with all its digits.
Result<std::string> fill_in(const std::string& text, const Setting& setting, const SourceLocation& where);

/// "max(1e-5, x/a) rel + 4 se" in its terms: cut at each " + " outside parentheses.
std::vector<std::string> terms_of(const std::string& sum);

}  // namespace raylex::experiments
