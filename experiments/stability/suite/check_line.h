// Compares measured with expected values.
#pragma once

#include <string>

#include "experiments/stability/probe.h"
#include "experiments/stability/suite/stability_case.h"

namespace raylex::experiments {

enum class LineState { holds, fails, died, not_applicable };

/// One line of the table.
struct LineResult {
    std::string family, name, setting;  ///< `setting`: the varied values, and the integrator if there are several
    std::vector<int> rows;
    LineState result = LineState::fails;
    double measured = 0, expected = 0;
    double error = 0;    ///< distance on the wrong side of the expected value; for equality the absolute distance
    double allowed = 0;  ///< value of `tolerance`
    double standard_error = 0, ulp = 0;
    std::string tolerance, note;
    double seconds = 0;  ///< wall time

    /// Returns the error in the unit of the largest term of its tolerance: "2.1 se", "12 ulp", "3e-07".
    [[nodiscard]] std::string error_text() const;
};

/// Fills in everything except the line's identity. Errors: an invalid formula, or an expected value that neither the
/// case nor the probe has.
Status run_checks(const StabilityCase& what, const Setting& setting, const ProbeResult& result, LineResult& line);

}  // namespace raylex::experiments
