// Formulas of numbers in cases: "0.5^k", "2*_pi*(1 - sqrt(1 - s^2))". muParser evaluates them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Numbers by name.
using Numbers = std::map<std::string, double>;

/// All numbers and words of one line of a case, constant or varied.
struct Setting {
    Numbers numbers;
    std::map<std::string, std::string> words;
    std::string text;  ///< text of the varied values: "g = 0.5, alpha = 1e-3"
};

/// Evaluates a formula in double: operators + - * / ^, functions sin, sqrt, exp, ln, abs, min, max ..., constants _pi
/// and _e. An Error at `where` describes the mistake; for an unknown number it lists the known ones.
Result<double> evaluate(const std::string& formula, const Numbers& numbers, const SourceLocation& where);

/// Returns the text with every ${...} replaced: by a word, by the word that a word names (${*kind}), or by the value of
/// a formula with all digits.
Result<std::string> fill_in(const std::string& text, const Setting& setting, const SourceLocation& where);

/// Splits a sum such as "max(1e-5, x/a) rel + 4 se" into terms, at each " + " outside parentheses.
std::vector<std::string> terms_of(const std::string& sum);

}  // namespace raylex::experiments
