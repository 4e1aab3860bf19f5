// What was measured against what is expected.
#pragma once

#include <string>

#include "experiments/stability/probe.h"
#include "experiments/stability/suite/stability_case.h"

namespace raylex::experiments {

enum class LineVerdict { holds, fails, died, not_applicable };

/// One line of the table.
struct LineResult {
    std::string family, name, setting;  ///< setting: of what varies, and the integrator where there are several
    std::vector<int> rows;
    LineVerdict verdict = LineVerdict::fails;
    double measured = 0, expected = 0;
    double error = 0;    ///< how far the measured lies on the wrong side; for equality its distance
    double allowed = 0;  ///< what `tolerance` comes to
    double standard_error = 0, ulp = 0;
    std::string tolerance, note;
    double seconds = 0;  ///< wall

    /// "2.1 se", "12 ulp", "3e-07": the error in the unit that its tolerance is mostly made of.
    [[nodiscard]] std::string error_text() const;
};

/// Fills in all but what a line is about. Errors: formulas that do not evaluate, an expectation that neither the case
/// nor the probe has.
Status judge(const StabilityCase& what, const Setting& setting, const ProbeResult& result, LineResult& line);

}  // namespace raylex::experiments
