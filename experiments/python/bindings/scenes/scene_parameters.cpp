#include "experiments/python/bindings/scenes/scene_parameters.h"

#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "transport/color/spectral_data.h"
#include "transport/import/known_types.h"

namespace raylex::python {

SourceLocation caller() {
    const py::object frame = py::module_::import("sys").attr("_getframe")();
    return {py::str(frame.attr("f_code").attr("co_filename")), frame.attr("f_lineno").cast<int>(), 0};
}

void fail_here(std::string message, std::string hint) {
    throw Failure{error_at(caller(), std::move(message), std::move(hint))};
}

namespace {

std::string class_of(const py::handle& value) {
    return py::str(py::type::handle_of(value).attr("__name__"));
}

}  // namespace

std::string shown(const py::handle& value) {
    constexpr std::size_t most = 40;
    std::string text = py::repr(value);
    for (char& c : text)
        if (c == '\n') c = ' ';
    if (text.size() > most) text = text.substr(0, most) + "...";
    return value.is_none() ? text : text + " (" + class_of(value) + ")";
}

namespace {

constexpr std::array<std::pair<const char*, ParameterType>, 13> type_words{{{"bool", ParameterType::boolean},
                                                                            {"integer", ParameterType::integer},
                                                                            {"float", ParameterType::real},
                                                                            {"string", ParameterType::string},
                                                                            {"rgb", ParameterType::rgb},
                                                                            {"blackbody", ParameterType::blackbody},
                                                                            {"spectrum", ParameterType::spectrum},
                                                                            {"point2", ParameterType::point2},
                                                                            {"vector2", ParameterType::vector2},
                                                                            {"point3", ParameterType::point3},
                                                                            {"vector3", ParameterType::vector3},
                                                                            {"normal", ParameterType::normal},
                                                                            {"texture", ParameterType::texture}}};

ParameterType type_of_word(const std::string& word, const std::string& name) {
    std::string list;
    for (const auto& [known, type] : type_words) {
        if (word == known) return type;
        list += std::string(list.empty() ? "" : ", ") + known;
    }
    fail_here("parameter '" + name + "' has the type '" + word + "'; expected one of " + list);
}

/// Returns the value as a NumPy array, or nothing.
py::array as_array(const py::handle& value) {
    py::array array = py::array::ensure(value);
    if (!array) PyErr_Clear();
    return array;
}

bool is_list_of_text(const py::handle& value) {
    if (py::isinstance<py::array>(value)) return py::reinterpret_borrow<py::array>(value).dtype().kind() == 'U';
    if ((!py::isinstance<py::list>(value) && !py::isinstance<py::tuple>(value)) || py::len(value) == 0) return false;
    for (const py::handle each : value)
        if (!py::isinstance<py::str>(each)) return false;
    return true;
}

/// Returns the type of numbers without an explicit type: pbrt's if known, else the type of the numbers.
ParameterType type_of_numbers(const py::array& numbers, std::optional<ParameterType> known) {
    const bool whole = numbers.dtype().kind() != 'f';
    const bool triple = numbers.ndim() == 1 && numbers.size() == 3;
    switch (known.value_or(ParameterType::string)) {
        case ParameterType::point2:
        case ParameterType::vector2:
        case ParameterType::point3:
        case ParameterType::vector3:
        case ParameterType::normal:
        case ParameterType::blackbody:
            return *known;
        case ParameterType::integer:
        case ParameterType::real:
            return whole ? ParameterType::integer : ParameterType::real;
        case ParameterType::rgb:
            if (numbers.size() > 0 && numbers.size() % 3 == 0) return ParameterType::rgb;
            break;
        default:
            break;
    }
    if (triple) return ParameterType::rgb;
    return whole && numbers.ndim() == 0 ? ParameterType::integer : ParameterType::real;
}

class ParameterMaker {
  public:
    ParameterMaker(transport::EntityKind kind, const std::string& type)
        : kind_(kind), type_(type), location_(caller()) {
        set_.location = location_;
    }

    void add(const py::handle& key, py::handle value) {
        if (!py::isinstance<py::str>(key)) fail_here("a parameter name is " + shown(key) + "; expected a str");
        Parameter parameter;
        parameter.name = key.cast<std::string>();
        parameter.location = location_;
        for (const Parameter& other : set_.parameters)
            if (other.name == parameter.name)
                fail_here("parameter '" + parameter.name +
                          "' is given in `parameters` and as a keyword; expected only one");
        std::optional<ParameterType> said;
        const std::optional<ParameterType> known = transport::known_type(kind_, type_, parameter.name);
        if (is_typed(value, known)) {
            said = type_of_word(value[py::int_(0)].cast<std::string>(), parameter.name);
            const py::object rest = value[py::int_(1)];
            fill(parameter, rest, said, known);
        } else {
            fill(parameter, value, said, known);
        }
        set_.parameters.push_back(std::move(parameter));
    }
    ParameterSet take() { return std::move(set_); }

  private:
    /// Returns whether the value is typed, such as ("float", 2). A tuple of two strings is a list of strings unless the
    /// first is the name of a type: ("red", "blue").
    static bool is_typed(const py::handle& value, std::optional<ParameterType> known) {
        if (!py::isinstance<py::tuple>(value) || py::len(value) != 2) return false;
        const py::object first = value[py::int_(0)], second = value[py::int_(1)];
        if (!py::isinstance<py::str>(first)) return false;
        const std::string word = first.cast<std::string>();
        for (const auto& [name, type] : type_words)
            if (word == name) return true;
        return !(py::isinstance<py::str>(second) && known == ParameterType::string);
    }

    static void fill(Parameter& parameter, const py::handle& value, std::optional<ParameterType> said,
                     std::optional<ParameterType> known) {
        const bool list = is_list_of_text(value);
        if (list || py::isinstance<py::str>(value)) {
            if (list)
                for (const py::handle each : value) parameter.strings.push_back(py::str(each));
            else parameter.strings = {value.cast<std::string>()};
            parameter.type = said ? *said : type_of_text(parameter, value, known);
            const bool fits = parameter.type == ParameterType::string || parameter.type == ParameterType::texture ||
                              parameter.type == ParameterType::spectrum;
            if (!fits) fail_type(parameter, value);
            return;
        }
        const py::array array = value.is_none() ? py::array() : as_array(value);
        const char kind = value.is_none() || !array ? 'O' : array.dtype().kind();
        if (kind == 'b') {
            parameter.type = said.value_or(ParameterType::boolean);
            if (parameter.type != ParameterType::boolean) fail_type(parameter, value);
            for (const py::handle each : array.attr("ravel")().attr("tolist")())
                parameter.booleans.push_back(static_cast<std::uint8_t>(each.cast<bool>()));
            return;
        }
        if (kind != 'i' && kind != 'u' && kind != 'f')
            fail_here("parameter '" + parameter.name + "' is " + shown(value) +
                          "; expected a bool, int, float or str, a list of str, or an array of numbers",
                      value.is_none() ? "omitted parameters have pbrt-v4's defaults" : "");
        if (array.size() == 0) fail_here("parameter '" + parameter.name + "' has no values; expected at least one");
        parameter.type = said.value_or(type_of_numbers(array, known));
        if (parameter.type == ParameterType::boolean || parameter.type == ParameterType::string ||
            parameter.type == ParameterType::texture)
            fail_type(parameter, value);
        const Array<double> numbers = array_of<double>(array, "parameter '" + parameter.name + "'");
        parameter.numbers.assign(numbers.data(), numbers.data() + numbers.size());
        // 5.0 is as good as 5. Other values are rejected here, not when they are read.
        if (said || known != ParameterType::integer) return;
        parameter.type = ParameterType::integer;
        for (const double number : parameter.numbers)
            if (number != std::floor(number))
                fail_here("parameter '" + parameter.name + "' is " + shown(value) + "; expected integers");
    }

    /// Returns the type of text without an explicit type. Error: the parameter is known to be numeric.
    static ParameterType type_of_text(const Parameter& parameter, const py::handle& value,
                                      std::optional<ParameterType> known) {
        if (known == ParameterType::texture || known == ParameterType::spectrum) return *known;
        if (known != ParameterType::real && known != ParameterType::rgb) return ParameterType::string;
        transport::VisibleSpectrum spectrum{};
        const std::string& text = parameter.strings.front();
        if (transport::find_named_spectrum(text, spectrum)) return ParameterType::spectrum;
        fail_here("parameter '" + parameter.name + "' is " + shown(value) + "; expected " +
                      (known == ParameterType::real ? "a number" : "a colour"),
                  "('texture', '" + text + "') is the texture of that name");
    }

    [[noreturn]] static void fail_type(const Parameter& parameter, const py::handle& value) {
        const char* expected = parameter.type == ParameterType::boolean   ? "True or False"
                               : parameter.type == ParameterType::string  ? "a str or a list of str"
                               : parameter.type == ParameterType::texture ? "the texture's name"
                                                                          : "numbers";
        fail_here("parameter '" + parameter.name + "' of type " + type_name(parameter.type) + " is " + shown(value) +
                  "; expected " + expected);
    }

    transport::EntityKind kind_;
    const std::string& type_;
    SourceLocation location_;
    ParameterSet set_;
};

/// Returns real numbers as an array of T. Errors name the actual type.
template <class T>
Array<T> numbers_of(const py::object& object, const std::string& what) {
    const py::array array = as_array(object);
    const char kind = array ? array.dtype().kind() : 'O';
    if (array && (kind == 'b' || kind == 'c'))
        fail_here(what + " is an array of " + std::string(py::str(array.dtype())) + "; expected real numbers");
    if (object.is_none() || (kind != 'i' && kind != 'u' && kind != 'f'))
        fail_here(what + " is " + shown(object) + ", which is not an array of numbers; expected a NumPy array");
    return array_of<T>(array, what);
}

}  // namespace

transport::SceneParameters parameters_of(transport::EntityKind kind, const std::string& type,
                                         const py::object& parameters, const py::kwargs& keywords) {
    ParameterMaker maker(kind, type);
    if (!parameters.is_none()) {
        if (!py::isinstance<py::dict>(parameters))
            fail_here("'parameters' is " + shown(parameters) + "; expected a dict of parameters by name");
        for (const auto& [name, value] : py::reinterpret_borrow<py::dict>(parameters)) maker.add(name, value);
    }
    for (const auto& [name, value] : keywords) maker.add(name, value);
    return maker.take();
}

transport::Transform transform_of(const py::object& object, const char* what) {
    if (object.is_none()) return {};
    const Array<double> array = numbers_of<double>(object, what);
    check_shape_here(array, 4, 4, what);
    transport::Matrix4 matrix{};
    for (std::size_t i = 0; i < 16; ++i) {
        matrix[i / 4][i % 4] = array.data()[i];
        if (!std::isfinite(array.data()[i]))
            fail_here(std::string(what) + " has " + std::to_string(array.data()[i]) + "; expected finite numbers");
    }
    const transport::Transform transform(matrix);
    if (!transform.invertible())
        fail_here(std::string(what) + " has no inverse; expected a transform that does not flatten space");
    return transform;
}

std::optional<transport::Transform> transform_or_none(const py::object& object, const char* what) {
    if (object.is_none()) return std::nullopt;
    return transform_of(object, what);
}

std::vector<transport::StoredVec3> triples(const py::object& object, const std::string& what) {
    const Array<float> array = numbers_of<float>(object, what);
    check_shape_here(array, static_cast<std::size_t>(array.ndim() > 0 ? array.shape(0) : 0), 3, what);
    std::vector<transport::StoredVec3> values(static_cast<std::size_t>(array.shape(0)));
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = {array.data()[3 * i], array.data()[3 * i + 1], array.data()[3 * i + 2]};
    return values;
}

std::vector<transport::StoredVec2> pairs(const py::object& object, const std::string& what) {
    const Array<float> array = numbers_of<float>(object, what);
    check_shape_here(array, static_cast<std::size_t>(array.ndim() > 0 ? array.shape(0) : 0), 2, what);
    std::vector<transport::StoredVec2> values(static_cast<std::size_t>(array.shape(0)));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = {array.data()[2 * i], array.data()[2 * i + 1]};
    return values;
}

Array<double> indices_of(const py::object& object, const std::string& what, std::size_t end, const std::string& of) {
    Array<double> indices = numbers_of<double>(object, what);
    for (py::ssize_t i = 0; i < indices.size(); ++i) {
        const double index = indices.data()[i];
        if (index >= 0 && index < static_cast<double>(end) && index == std::floor(index)) continue;
        const bool whole = index == std::floor(index) && std::isfinite(index);
        const std::string text = whole ? py::str(py::int_(py::float_(index))) : py::repr(py::float_(index));
        if (!whole) fail_here(what + " has " + text + "; expected integers");
        fail_here(what + " has " + text + ", and there are " + std::to_string(end) + " " + of + "; expected " +
                  (end > 0 ? "0 to " + std::to_string(end - 1) : "none"));
    }
    return indices;
}

}  // namespace raylex::python
