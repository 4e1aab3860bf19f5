#include "experiments/study/analysis/distributions.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/non_central_t.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "display/services/split_mix.h"

namespace raylex::experiments {
namespace {

// Out-of-range arguments give infinities and NaN, which a table shows, instead of exceptions, which would end a report.
using Policy =
    boost::math::policies::policy<boost::math::policies::domain_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::pole_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::overflow_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::evaluation_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::promote_double<false>>;
using Normal = boost::math::normal_distribution<double, Policy>;
using StudentT = boost::math::students_t_distribution<double, Policy>;
using ChiSquared = boost::math::chi_squared_distribution<double, Policy>;
using NoncentralT = boost::math::non_central_t_distribution<double, Policy>;

constexpr double normal_from = 1e9;  // degrees from which t and normal quantiles agree to 1e-8 for all p used here

}  // namespace

double normal_quantile(double p) {
    return boost::math::quantile(Normal(), p);
}

double student_t_quantile(double p, double degrees) {
    if (!(degrees < normal_from)) return normal_quantile(p);
    return boost::math::quantile(StudentT(degrees), p);
}

double student_t_two_sided(double t, double degrees) {
    if (!(degrees < normal_from)) return std::erfc(std::abs(t) / std::sqrt(2.0));
    return 2 * boost::math::cdf(boost::math::complement(StudentT(degrees), std::abs(t)));
}

double detectable_shift(double alpha, double power, double degrees) {
    const double critical = -student_t_quantile(alpha / 2, degrees);
    // Above this number of degrees, the noncentral series is slow and the normal shift is exact to 1e-3 of a standard
    // error.
    if (degrees > 2000) return critical + normal_quantile(power);
    // With one or two degrees of freedom, the critical value can be in the millions. Next to such a shift the
    // numerator's own noise, 1, is negligible: T is shift / sqrt(chi^2 / degrees), with relative error 1 / critical.
    // The series would overflow 32 bits.
    if (critical > 1000) return critical * std::sqrt(boost::math::quantile(ChiSquared(degrees), power) / degrees);
    double low = 0, high = 2 * critical + 10;
    while (1 - boost::math::cdf(NoncentralT(degrees, high), critical) < power) high *= 2;
    for (int i = 0; i < 60 && high - low > 1e-9 * high; ++i) {
        const double middle = (low + high) / 2;
        (1 - boost::math::cdf(NoncentralT(degrees, middle), critical) < power ? low : high) = middle;
    }
    return high;
}

double sidak_level(double alpha, double tests) {
    return -std::expm1(std::log1p(-alpha) / tests);
}

double sidak_adjusted(double p, double tests) {
    return p >= 1 ? 1 : -std::expm1(tests * std::log1p(-p));
}

std::uint64_t counter_bits(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
    const auto mixed = [](std::uint64_t x) { return mix_bits(x + golden_gamma); };
    return mixed(mixed(mixed(seed) ^ stream) ^ index);
}

}  // namespace raylex::experiments
