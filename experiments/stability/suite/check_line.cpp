#include "experiments/stability/suite/check_line.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "experiments/program/console.h"
#include "experiments/study/analysis/distributions.h"

namespace raylex::experiments {
namespace {

/// Returns the unit in the last place of a float of this size, at least that of the smallest normal float, because
/// denormals are flushed.
double float_ulp(double value) {
    const auto size = static_cast<float>(std::abs(value));
    if (!std::isfinite(size) || size < 0x1p-126f) return 0x1p-149;
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(size) + 1u) - double(size);
}

/// Returns how many standard errors with few degrees of freedom are as rare as `normal` standard errors with many.
double student_quantile(double normal, double degrees) {
    if (degrees <= 0) return normal;
    const double p = std::erfc(normal / std::sqrt(2.0));
    return student_t_quantile(1 - 0.5 * std::max(p, 1e-300), degrees);
}

struct Unit {
    std::string name;  ///< suffix of the term: " se"; empty: a plain number
    double size;
};

/// Returns the value of one term of a tolerance; stores the unit of the largest term in `line`.
Result<double> allowed_by(const std::string& term, const StabilityCase& what, const Setting& setting,
                          const ProbeResult& result, const LineResult& line) {
    for (const Unit& unit : {Unit{" se", result.standard_error}, Unit{" ulp", line.ulp},
                             Unit{" rel", std::abs(line.expected)}, Unit{"", 1}}) {
        if (!term.ends_with(unit.name)) continue;
        const std::string formula = term.substr(0, term.size() - unit.name.size());
        auto factor = evaluate(formula, setting.numbers, what.tolerance.location);
        if (!factor) return factor.error();
        if (unit.name == " se") return student_quantile(*factor, result.degrees) * unit.size;
        return *factor * unit.size;
    }
    return 0.0;
}

double error_of(Comparison comparison, double measured, double expected) {
    if (std::isnan(measured) || std::isnan(expected)) return NAN;
    if (comparison == Comparison::at_most) return std::max(0.0, measured - expected);
    if (comparison == Comparison::at_least) return std::max(0.0, expected - measured);
    return measured == expected ? 0 : std::abs(measured - expected);
}

}  // namespace

std::string LineResult::error_text() const {
    if (result == LineState::died || result == LineState::not_applicable) return "";
    if (tolerance.find(" se") != std::string::npos && standard_error > 0)
        return number_text(error / standard_error) + " se";
    if (tolerance.find(" ulp") != std::string::npos && ulp > 0) return number_text(error / ulp) + " ulp";
    if (tolerance.find(" rel") != std::string::npos && expected != 0)
        return number_text(error / std::abs(expected)) + " rel";
    return number_text(error);
}

Status run_checks(const StabilityCase& what, const Setting& setting, const ProbeResult& result, LineResult& line) {
    line.measured = result.measured;
    line.standard_error = result.standard_error;
    line.note = result.note;
    line.tolerance = what.tolerance.text;
    if (!what.expected.empty()) {
        auto expected = evaluate(what.expected.text, setting.numbers, what.expected.location);
        if (!expected) return expected.error();
        line.expected = *expected;
    } else if (result.expected) {
        line.expected = *result.expected;
    } else {
        return error_at(what.location, "no expected value; expected a formula 'expected' in the case");
    }
    line.ulp = result.ulp > 0 ? result.ulp : float_ulp(line.expected);
    if (!what.ulp_of.empty()) {
        auto size = evaluate(what.ulp_of.text, setting.numbers, what.ulp_of.location);
        if (!size) return size.error();
        line.ulp = float_ulp(*size);
    }
    line.allowed = 0;
    if (what.tolerance.text != "exact")
        for (const std::string& term : terms_of(what.tolerance.text)) {
            auto allowed = allowed_by(term, what, setting, result, line);
            if (!allowed) return allowed.error();
            line.allowed += *allowed;
        }
    line.error = error_of(what.comparison, line.measured, line.expected);
    line.result = line.error <= line.allowed ? LineState::holds : LineState::fails;  // NaN fails
    return success();
}

}  // namespace raylex::experiments
