// Quantiles for intervals and tests, by Boost.Math. They are in one file because its headers are slow to compile.
#pragma once

#include <cstdint>

namespace raylex::experiments {

/// Returns x with P(X <= x) = p for the normal distribution, 0 < p < 1.
double normal_quantile(double p);
/// Returns a quantile of Student's t with `degrees` > 0 degrees of freedom, integer or not. Beyond 1e9 it is the normal
/// quantile.
double student_t_quantile(double p, double degrees);
/// Returns P(|T| >= |t|) for Student's t.
double student_t_two_sided(double t, double degrees);

/// Returns the shift, in standard errors, at which a two-sided t test of level `alpha` rejects with probability
/// `power`. It solves the noncentral t distribution, so it is exact for normal data; for many degrees of freedom it is
/// (z_(alpha/2) + z_power).
double detectable_shift(double alpha, double power, double degrees);

/// Returns the level of each of `tests` independent tests at which all together have level `alpha` (Sidak): 1 - (1 -
/// alpha)^(1/tests).
double sidak_level(double alpha, double tests);
/// Returns the smallest of `tests` p-values corrected by Sidak's formula.
double sidak_adjusted(double p, double tests);

/// Returns 64 random bits as a function of three counters (two rounds of the SplitMix64 finaliser each), independent of
/// the place and order of calls.
std::uint64_t counter_bits(std::uint64_t seed, std::uint64_t stream, std::uint64_t index);

}  // namespace raylex::experiments
