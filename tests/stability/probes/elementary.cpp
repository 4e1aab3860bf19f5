// raylex's elementary functions for any argument, compared with the C library in long double.
#include <cmath>

#include "display/services/elementary.h"
#include "tests/stability/probes/probes.h"

namespace raylex::experiments {
namespace {

struct Function {
    const char* name;
    float (*single)(float, float);
    double (*whole)(double, double);
    long double (*reference)(long double, long double);
};

#define RAYLEX_ONE(function)                                         \
    Function {                                                       \
#function, [](float x, float) { return elementary::function(x); }, \
            [](double x, double) { return elementary::function(x); },     \
            [](long double x, long double) { return std::function(x); } \
    }
#define RAYLEX_TWO(function)                                                 \
    Function {                                                               \
#function, [](float x, float y) { return elementary::function(x, y); },    \
            [](double x, double y) { return elementary::function(x, y); },        \
            [](long double x, long double y) { return std::function(x, y); } \
    }

constexpr Function functions[] = {RAYLEX_ONE(sin),   RAYLEX_ONE(cos),   RAYLEX_ONE(tan),  RAYLEX_ONE(exp),
                                  RAYLEX_ONE(exp2),  RAYLEX_ONE(expm1), RAYLEX_ONE(log),  RAYLEX_ONE(log2),
                                  RAYLEX_ONE(log1p), RAYLEX_ONE(atan),  RAYLEX_ONE(asin), RAYLEX_ONE(acos),
                                  RAYLEX_TWO(atan2), RAYLEX_TWO(pow),   RAYLEX_TWO(hypot)};

#undef RAYLEX_ONE
#undef RAYLEX_TWO

Result<ProbeResult> value_of(const ProbeInput& input) {
    const std::string name = input.word("function"), precision = input.word("precision", "float");
    const double x = input.number("x"), y = input.number("y", 0);
    if (Status given = input.status(); !given) return given.error();
    for (const Function& f : functions) {
        if (name != f.name) continue;
        ProbeResult result;
        if (precision == "double") {
            result.measured = f.whole(x, y);
            result.expected = static_cast<double>(f.reference(x, y));
            result.ulp = std::nextafter(std::abs(*result.expected), INFINITY) - std::abs(*result.expected);
            return result;
        }
        const auto narrow_x = static_cast<float>(x), narrow_y = static_cast<float>(y);
        result.measured = f.single(narrow_x, narrow_y);
        const auto exact = static_cast<double>(f.reference(narrow_x, narrow_y));
        // Beyond float's largest number the result is infinity.
        result.expected = std::isinf(static_cast<float>(exact)) ? std::copysign(INFINITY, exact) : exact;
        return result;
    }
    std::string known;
    for (const Function& f : functions) known += std::string(known.empty() ? "" : ", ") + f.name;
    return error_at(input.where(), "no function '" + name + "'; expected one of " + known);
}

}  // namespace

std::span<const NamedProbe> elementary_probes() {
    static constexpr NamedProbe table[] = {
        {"elementary_function",
         "value of raylex's elementary function; function, x, y (of atan2, pow and hypot), precision (float or "
         "double)",
         value_of}};
    return table;
}

}  // namespace raylex::experiments
