#include "transport/import/pbrt/parser_values.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

#include "lpe/input/budgets.h"

namespace raylex::transport {

namespace {

enum class ValueKind : std::uint8_t { number, string, boolean, either };

struct TypeRow {
    const char* name;
    ParameterType type;
    ValueKind kind;
    std::size_t group;  ///< numbers per item
};

constexpr TypeRow type_table[] = {
    {"bool", ParameterType::boolean, ValueKind::boolean, 1},
    {"integer", ParameterType::integer, ValueKind::number, 1},
    {"float", ParameterType::real, ValueKind::number, 1},
    {"string", ParameterType::string, ValueKind::string, 1},
    {"rgb", ParameterType::rgb, ValueKind::number, 3},
    {"blackbody", ParameterType::blackbody, ValueKind::number, 1},
    {"spectrum", ParameterType::spectrum, ValueKind::either, 1},
    {"point2", ParameterType::point2, ValueKind::number, 2},
    {"vector2", ParameterType::vector2, ValueKind::number, 2},
    {"point3", ParameterType::point3, ValueKind::number, 3},
    {"vector3", ParameterType::vector3, ValueKind::number, 3},
    {"normal", ParameterType::normal, ValueKind::number, 3},
    {"texture", ParameterType::texture, ValueKind::string, 1},
};

const TypeRow* find_type(std::string_view name) {
    for (const TypeRow& row : type_table)
        if (name == row.name) return &row;
    return nullptr;
}

Error unknown_type(const Tokenizer& tokenizer, const Token& token, const std::string& type) {
    std::vector<std::string> names;
    std::string list;
    for (const TypeRow& row : type_table) {
        names.emplace_back(row.name);
        list += std::string(list.empty() ? "" : ", ") + row.name;
    }
    // Spellings of pbrt-v3 that pbrt-v4 does not read.
    const std::string near = type == "point"     ? "point3"
                             : type == "vector"  ? "vector3"
                             : type == "normal3" ? "normal"
                             : type == "color"   ? "rgb"
                                                 : nearest_name(type, names);
    return tokenizer.error(token, "unknown parameter type '" + type + "'; expected one of " + list,
                           near.empty() ? "" : "did you mean '" + near + "'?");
}

/// Splits "type name" at blanks.
struct Declaration {
    std::string type, name;
    bool more = false;  ///< a third word
};

Declaration split_declaration(std::string_view text) {
    Declaration declaration;
    std::string* const parts[] = {&declaration.type, &declaration.name};
    std::size_t part = 0;
    for (std::size_t i = 0; i < text.size();) {
        if (text[i] == ' ' || text[i] == '\t') {
            ++i;
            continue;
        }
        std::size_t stop = i;
        while (stop < text.size() && text[stop] != ' ' && text[stop] != '\t') ++stop;
        if (part == 2) return declaration.more = true, declaration;
        *parts[part++] = text.substr(i, stop - i);
        i = stop;
    }
    return declaration;
}

bool plain_number(std::string_view text, double& value) {
    const auto [stop, status] = std::from_chars(text.data(), text.data() + text.size(), value);
    return status == std::errc() && stop == text.data() + text.size() && std::isfinite(value);
}

/// Reads the values of one parameter, which its messages name.
class ValueReader {
  public:
    ValueReader(const Tokenizer& tokenizer, const TypeRow& row, Parameter& parameter)
        : tokenizer_(tokenizer), row_(row), parameter_(parameter) {}

    Status add(const Token& token) {
        if (token.kind == TokenKind::string) return add_string(token);
        if (token.kind != TokenKind::word)
            return tokenizer_.error(token, "found " + describe(token) + "; expected " + expected());
        if (row_.kind == ValueKind::boolean) return add_boolean(token);
        if (row_.kind == ValueKind::string || !parameter_.strings.empty())
            return tokenizer_.error(token, "found " + describe(token) + "; expected " + expected() + " in quotes");
        return add_number(token);
    }

    /// Adds the numbers that follow each other, up to the first that add() has to check.
    void add_numbers(Tokenizer& tokenizer) {
        if (row_.kind != ValueKind::number && (row_.kind != ValueKind::either || !parameter_.strings.empty())) return;
        if (parameter_.numbers.empty()) parameter_.numbers.reserve(tokenizer.words_in_list());
        tokenizer.take_numbers(parameter_.numbers,
                               [integers = parameter_.type == ParameterType::integer](double number) {
                                   return in_range(number) && (!integers || is_int32(number));
                               });
    }

    Status finish(const Token& declaration) const {
        const std::size_t count = parameter_.numbers.size() + parameter_.strings.size() + parameter_.booleans.size();
        const std::string shown = std::string("'").append(row_.name).append(" ").append(parameter_.name).append("'");
        if (count == 0) return tokenizer_.error(declaration, shown + " has no values; expected at least one");
        if (parameter_.numbers.size() % row_.group != 0)
            return tokenizer_.error(declaration, shown + " has " + std::to_string(parameter_.numbers.size()) +
                                                     " numbers; expected a multiple of " + std::to_string(row_.group));
        return success();
    }

    [[nodiscard]] std::string expected() const {
        const char* what = row_.kind == ValueKind::boolean                                 ? "true or false"
                           : row_.kind == ValueKind::string || !parameter_.strings.empty() ? "a string"
                           : parameter_.type == ParameterType::integer                     ? "an integer"
                                                                                           : "a number";
        return std::string(what) + " for '" + row_.name + " " + parameter_.name + "'";
    }

  private:
    Status add_string(const Token& token) {
        const bool allowed =
            row_.kind == ValueKind::string || (row_.kind == ValueKind::either && parameter_.numbers.empty());
        if (!allowed) {
            const bool quoted_boolean =
                row_.kind == ValueKind::boolean && (token.text == "true" || token.text == "false");
            return tokenizer_.error(token, "found " + describe(token) + "; expected " + expected(),
                                    quoted_boolean ? "pbrt-v4 writes booleans without quotes" : "");
        }
        Result<std::string> value = unescape(tokenizer_, token);
        if (!value) return value.error();
        parameter_.strings.push_back(std::move(*value));
        return success();
    }

    Status add_boolean(const Token& token) {
        if (token.text != "true" && token.text != "false")
            return tokenizer_.error(token, "found " + describe(token) + "; expected " + expected());
        parameter_.booleans.push_back(token.text == "true" ? 1 : 0);
        return success();
    }

    Status add_number(const Token& token) {
        double number = 0;
        if (!plain_number(token.text, number)) {
            if (is_broken_normal(token.text)) {  // the readers of normals repair and count them
                parameter_.numbers.push_back(std::numeric_limits<double>::quiet_NaN());
                return success();
            }
            const Result<double> value = parse_number(tokenizer_, token, expected());
            if (!value) {
                Error error = value.error();
                if (is_vertex()) error.message += ", at vertex " + std::to_string(parameter_.numbers.size() / 3);
                return error;
            }
            number = *value;
        }
        if (!in_range(number)) {
            Error error = tokenizer_.error(
                token, "found " + describe(token) + ", beyond the range of float; expected " + expected());
            if (is_vertex()) error.message += ", at vertex " + std::to_string(parameter_.numbers.size() / 3);
            return error;
        }
        if (parameter_.type == ParameterType::integer && !is_int32(number))
            return tokenizer_.error(token, "found " + describe(token) + "; expected " + expected() + " of 32 bits");
        parameter_.numbers.push_back(number);
        return success();
    }

    /// All later code uses float, where a value beyond its range would become infinite silently.
    static bool in_range(double number) {
        return std::abs(number) <= static_cast<double>(std::numeric_limits<float>::max());
    }
    static bool is_int32(double number) {
        return number == std::floor(number) && number >= std::numeric_limits<std::int32_t>::min() &&
               number <= std::numeric_limits<std::int32_t>::max();
    }
    [[nodiscard]] bool is_vertex() const { return row_.group == 3 && parameter_.name == "P"; }
    [[nodiscard]] bool is_broken_normal(std::string_view text) const {
        if (parameter_.type != ParameterType::normal || parameter_.name != "N") return false;
        double value = 0;
        const auto [stop, status] = std::from_chars(text.data(), text.data() + text.size(), value);
        return status == std::errc() && stop == text.data() + text.size() && !std::isfinite(value);
    }

    const Tokenizer& tokenizer_;
    const TypeRow& row_;
    Parameter& parameter_;
};

Status parse_values(Tokenizer& tokenizer, const Token& declaration, const TypeRow& row, Parameter& parameter) {
    ValueReader reader(tokenizer, row, parameter);
    Result<Token> token = tokenizer.next();
    if (!token) return token.error();
    if (token->kind == TokenKind::open_bracket) {
        const Token open = *token;
        while (true) {
            reader.add_numbers(tokenizer);
            token = tokenizer.next();
            if (!token) return token.error();
            if (token->kind == TokenKind::close_bracket) break;
            if (token->kind == TokenKind::end)
                return tokenizer.error(
                    open, "'[' is never closed; expected ']' after the values of '" + parameter.name + "'");
            if (Status status = reader.add(*token); !status) return status;
        }
    } else if (Status status = reader.add(*token); !status) {
        return status;
    }
    return reader.finish(declaration);
}

void keep_last(ParameterSet& set, Parameter parameter, std::vector<Error>& warnings) {
    for (Parameter& earlier : set.parameters) {
        if (earlier.name != parameter.name) continue;
        warnings.push_back(
            error_at(parameter.location, "parameter '" + parameter.name + "' is given twice; the last value is used"));
        earlier = std::move(parameter);
        return;
    }
    set.parameters.push_back(std::move(parameter));
}

}  // namespace

Result<double> parse_number(const Tokenizer& tokenizer, const Token& token, const std::string& expected) {
    const auto failure = [&](const std::string& what) {
        return tokenizer.error(token, "found " + describe(token) + what + "; expected " + expected);
    };
    if (token.kind != TokenKind::word) return failure("");
    const char* begin = token.text.data();
    const char* const end = begin + token.text.size();
    if (*begin == '+' && end - begin > 1 && begin[1] != '-') ++begin;
    double value = 0;
    const auto [stop, status] = std::from_chars(begin, end, value);
    if (status == std::errc::invalid_argument || stop != end) return failure("");
    if (status == std::errc::result_out_of_range) {
        // A number too small for double becomes 0; one that is too large is an error. The sign of the exponent decides.
        const bool tiny =
            token.text.find("e-") != std::string_view::npos || token.text.find("E-") != std::string_view::npos;
        if (!tiny) return failure(", too large for a double");
        return 0.0;
    }
    if (!std::isfinite(value)) return failure(", not finite");
    return value;
}

Status parse_parameters(Tokenizer& tokenizer, ParameterSet& set, std::vector<Error>& warnings) {
    for (std::uint64_t count = 0;; ++count) {
        const Result<Token> token = tokenizer.next();
        if (!token) return token.error();
        if (token->kind != TokenKind::string) {
            tokenizer.push_back(*token);
            return success();
        }
        if (count >= budget(Budget::parameters)) {
            const SourceLocation where = tokenizer.location(*token);
            return over_budget(Budget::parameters, "the directive has too many parameters", where.file, where.line,
                               where.column);
        }
        const Declaration declaration = split_declaration(token->text);
        if (declaration.type.empty() || declaration.name.empty())
            return tokenizer.error(*token, "found " + describe(*token) + "; expected a parameter, \"type name\"");
        if (declaration.more)  // pbrt ignores it
            warnings.push_back(tokenizer.error(*token, "the text after type and name in " + describe(*token) +
                                                           " is ignored; expected a parameter, \"type name\""));
        const TypeRow* row = find_type(declaration.type);
        if (row == nullptr) return unknown_type(tokenizer, *token, declaration.type);
        Parameter parameter;
        parameter.name = declaration.name;
        parameter.type = row->type;
        parameter.location = tokenizer.location(*token);
        if (Status status = parse_values(tokenizer, *token, *row, parameter); !status) return status;
        keep_last(set, std::move(parameter), warnings);
    }
}

Status parse_option(Tokenizer& tokenizer, const Token& name, ParameterSet& set) {
    Parameter parameter;
    for (const char c : name.text)
        if (c != '-' && c != '_') parameter.name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    parameter.location = tokenizer.location(name);
    const Result<Token> token = tokenizer.next();
    if (!token) return token.error();
    const bool truth = token->kind == TokenKind::word && (token->text == "true" || token->text == "false");
    parameter.type = token->kind == TokenKind::string ? ParameterType::string
                     : truth                          ? ParameterType::boolean
                                                      : ParameterType::real;
    if (token->kind == TokenKind::string) {
        Result<std::string> value = unescape(tokenizer, *token);
        if (!value) return value.error();
        parameter.strings.push_back(std::move(*value));
    } else if (truth) {
        parameter.booleans.push_back(token->text == "true" ? 1 : 0);
    } else {
        const Result<double> value =
            parse_number(tokenizer, *token, "true, false, a number or a string for option '" + parameter.name + "'");
        if (!value) return value.error();
        parameter.numbers.push_back(*value);
    }
    set.parameters.push_back(std::move(parameter));
    return success();
}

}  // namespace raylex::transport
