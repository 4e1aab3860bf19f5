// Probes measure numbers that no image shows, for cases of raylex's own tests (tests/stability).
//
// A probe measures one number for the parameters of a case. It runs on one thread, with denormals flushed as in a
// render; several may run at once. The program raylex has no probes: tests register theirs.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "display/services/registry.h"
#include "experiments/stability/suite/formula.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// The parameters of a probe: the numbers and words of a case's line.
class ProbeInput {
  public:
    ProbeInput(const Setting& setting, SourceLocation where) : setting_(setting), where_(std::move(where)) {}

    /// Returns a required number. A missing number is 0, and status() then returns an Error that names it.
    [[nodiscard]] double number(const std::string& name) const;
    [[nodiscard]] double number(const std::string& name, double fallback) const;
    [[nodiscard]] std::string word(const std::string& name) const;
    [[nodiscard]] std::string word(const std::string& name, const std::string& fallback) const;
    /// Returns an Error for the first missing parameter, or success.
    [[nodiscard]] Status status() const;
    /// The location for errors about a parameter's value.
    [[nodiscard]] const SourceLocation& where() const { return where_; }

  private:
    const Setting& setting_;
    SourceLocation where_;
    mutable std::string missing_;
};

struct ProbeResult {
    double measured = 0;
    std::optional<double> expected{};  ///< by the probe's own reference: double precision, or a closed form
    double standard_error = 0;         ///< 0: no sampling noise
    double degrees = 0;                ///< degrees of freedom of the standard error; 0: many
    double ulp = 0;                    ///< unit of tolerances in ulp; 0: that of a float at |expected|
    std::string note{};                ///< further information about the measurement
};

using Probe = Result<ProbeResult> (*)(const ProbeInput&);

/// One row of a file's table of probes.
struct NamedProbe {
    const char* name;
    const char* help;  ///< one line: the measured quantity, and the parameters with units
    Probe probe;
};

/// The registered probes by name.
Registry<Probe>& probe_registry();

}  // namespace raylex::experiments
