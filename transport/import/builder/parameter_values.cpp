#include "transport/import/builder/parameter_values.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>

namespace raylex::transport {

namespace {

std::size_t numbers_of_one(ParameterType type) {
    switch (type) {
        case ParameterType::rgb:
        case ParameterType::point3:
        case ParameterType::vector3:
        case ParameterType::normal:
            return 3;
        case ParameterType::point2:
        case ParameterType::vector2:
            return 2;
        default:
            return 1;
    }
}

std::string shortest(double number) {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), number);
    return {text.data(), end.ptr};
}

Status check_numbers(const Parameter& parameter) {
    const std::vector<double>& numbers = parameter.numbers;
    const auto refused = [&](std::size_t i, const std::string& what) {
        const std::string which = numbers.size() > 1 ? "value " + std::to_string(i) + " of parameter '" : "parameter '";
        return error_at(parameter.location, which + parameter.name + "' is " + what);
    };
    // Public meshes contain such normals; their readers compute others.
    const bool repaired = parameter.type == ParameterType::normal && parameter.name == "N";
    const bool integers = parameter.type == ParameterType::integer;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const double number = numbers[i];
        if (std::abs(number) <= static_cast<double>(std::numeric_limits<float>::max())) {
            using Integer = std::numeric_limits<std::int32_t>;
            if (integers && !(number == std::floor(number) && number >= Integer::min() && number <= Integer::max()))
                return refused(i, shortest(number) + "; expected an integer of 32 bits");
            continue;
        }
        if (repaired) continue;
        if (std::isfinite(number)) return refused(i, "beyond the range of float; expected less than 3.4e38");
        return refused(i, std::string(std::isnan(number) ? "not a number" : "infinite") + "; expected a finite number");
    }
    const std::size_t one = numbers_of_one(parameter.type);
    if (numbers.size() % one == 0) return success();
    return error_at(parameter.location, "parameter '" + parameter.name + "' has " + std::to_string(numbers.size()) +
                                            " numbers; expected " + std::to_string(one) + ", or a multiple, for " +
                                            type_name(parameter.type));
}

}  // namespace

Status check_values(const Parameter& parameter) {
    const bool numbers = !parameter.numbers.empty(), strings = !parameter.strings.empty(),
               booleans = !parameter.booleans.empty();
    bool fits = numbers && !strings && !booleans;
    const char* expected = "numbers";
    switch (parameter.type) {
        case ParameterType::boolean:
            fits = booleans && !strings && !numbers;
            expected = "true or false";
            break;
        case ParameterType::string:
        case ParameterType::texture:
            fits = strings && !booleans && !numbers;
            expected = "text";
            break;
        case ParameterType::spectrum:
            fits = (strings != numbers) && !booleans;
            expected = "a name, or wavelengths and values";
            break;
        default:
            break;
    }
    if (!fits)
        return error_at(parameter.location,
                        "parameter '" + parameter.name + "' of type " + type_name(parameter.type) +
                            (numbers || strings || booleans ? " has values of another kind" : " has no values") +
                            "; expected " + expected);
    return check_numbers(parameter);
}

}  // namespace raylex::transport
