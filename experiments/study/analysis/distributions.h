// Quantiles that intervals and tests need, from Boost.Math, kept behind one file: its headers are slow to compile.
#pragma once

#include <cstdint>

namespace raylex::experiments {

/// x with P(X <= x) = p, 0 < p < 1.
double normal_quantile(double p);
/// Student's t with `degrees` > 0 degrees of freedom, whole or not. Beyond 1e9 it is the normal distribution.
double student_t_quantile(double p, double degrees);
/// P(|T| >= |t|).
double student_t_two_sided(double t, double degrees);

/// The shift, in standard errors, at which a two-sided t test of level `alpha` rejects with probability `power`: solved
/// on the noncentral t distribution, so exact for normal data; (z_(alpha/2) + z_power) for many degrees of freedom.
double detectable_shift(double alpha, double power, double degrees);

/// The level for each of `tests` independent tests at which all together have level `alpha` (Sidak): 1 - (1 -
/// alpha)^(1/tests).
double sidak_level(double alpha, double tests);
/// The other way: what the smallest of `tests` p-values is worth.
double sidak_adjusted(double p, double tests);

/// 64 random bits that are a function of three counters (two rounds of the SplitMix64 finaliser each): the same
/// wherever and in whatever order they are asked for.
std::uint64_t counter_bits(std::uint64_t seed, std::uint64_t stream, std::uint64_t index);

}  // namespace raylex::experiments
