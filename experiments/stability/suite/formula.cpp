#include "experiments/stability/suite/formula.h"

#include <muParser.h>

#include <cstdio>

namespace raylex::experiments {

Result<double> evaluate(const std::string& formula, const Numbers& numbers, const SourceLocation& where) {
    try {
        mu::Parser parser;
        for (const auto& [name, value] : numbers) parser.DefineConst(name, value);
        parser.SetExpr(formula);
        return parser.Eval();
    } catch (const mu::Parser::exception_type& error) {
        std::string known;
        for (const auto& [name, value] : numbers) known += (known.empty() ? "" : ", ") + name;
        return error_at(where, "'" + formula + "' is not a formula: " + error.GetMsg(),
                        known.empty() ? "the case has no numbers" : "numbers of the case: " + known);
    }
}

Result<std::string> fill_in(const std::string& text, const Setting& setting, const SourceLocation& where) {
    std::string filled;
    std::size_t at = 0;
    for (std::size_t open; (open = text.find("${", at)) != std::string::npos;) {
        const std::size_t close = text.find('}', open);
        if (close == std::string::npos) return error_at(where, "'${' without '}'; expected ${NAME} or ${FORMULA}");
        filled += text.substr(at, open - at);
        const std::string inner = text.substr(open + 2, close - open - 2);
        const auto named = setting.words.find(inner.substr(inner.starts_with('*') ? 1 : 0));
        const auto word =
            inner.starts_with('*') && named != setting.words.end() ? setting.words.find(named->second) : named;
        if (word != setting.words.end()) {
            filled += word->second;
        } else {
            auto value = evaluate(inner, setting.numbers, where);
            if (!value) return value.error();
            char digits[40];
            std::snprintf(digits, sizeof digits, "%.17g", *value);
            filled += digits;
        }
        at = close + 1;
    }
    return filled + text.substr(at);
}

std::vector<std::string> terms_of(const std::string& sum) {
    std::vector<std::string> terms(1);
    int depth = 0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
        if (sum[i] == '(') ++depth;
        if (sum[i] == ')') --depth;
        if (depth == 0 && sum.compare(i, 3, " + ") == 0) {
            terms.emplace_back();
            i += 2;
        } else {
            terms.back() += sum[i];
        }
    }
    return terms;
}

}  // namespace raylex::experiments
