#include "transport/import/pbrt/parser.h"

#include <algorithm>

#include "transport/import/pbrt/parser_values.h"

namespace raylex::transport {

namespace {

/// The form of the arguments after a directive's word.
enum class Form : std::uint8_t {
    nothing,  // AttributeBegin
    numbers,  // Translate 1 2 3
    matrix,   // Transform [ 16 numbers ]
    word,     // ActiveTransform All
    name,     // NamedMaterial "x"
    typed,    // Shape "sphere" parameters
    texture,  // Texture "name" "float" "constant" parameters
    media,    // MediumInterface "inside" ["outside"]
    option    // Option "x" true, or "bool x" true
};

struct DirectiveRow {
    std::string_view name;
    Form form;
    std::size_t count;      ///< of numbers
    const char* arguments;  ///< for messages
};

// In the order of DirectiveId.
constexpr DirectiveRow table[] = {
    {"Accelerator", Form::typed, 0, "a type in quotes"},
    {"ActiveTransform", Form::word, 0, "StartTime, EndTime or All"},
    {"AreaLightSource", Form::typed, 0, "a type in quotes"},
    {"Attribute", Form::typed, 0, "a target in quotes"},
    {"AttributeBegin", Form::nothing, 0, ""},
    {"AttributeEnd", Form::nothing, 0, ""},
    {"Camera", Form::typed, 0, "a type in quotes"},
    {"ColorSpace", Form::name, 0, "a colour space in quotes"},
    {"ConcatTransform", Form::matrix, 16, "16 numbers in brackets"},
    {"CoordinateSystem", Form::name, 0, "a name in quotes"},
    {"CoordSysTransform", Form::name, 0, "a name in quotes"},
    {"Film", Form::typed, 0, "a type in quotes"},
    {"Identity", Form::nothing, 0, ""},
    {"Import", Form::name, 0, "a file name in quotes"},
    {"Include", Form::name, 0, "a file name in quotes"},
    {"Integrator", Form::typed, 0, "a type in quotes"},
    {"LightSource", Form::typed, 0, "a type in quotes"},
    {"LookAt", Form::numbers, 9, "9 numbers: eye, look, up"},
    {"MakeNamedMaterial", Form::typed, 0, "a name in quotes"},
    {"MakeNamedMedium", Form::typed, 0, "a name in quotes"},
    {"Material", Form::typed, 0, "a type in quotes"},
    {"MediumInterface", Form::media, 0, "a medium's name in quotes"},
    {"NamedMaterial", Form::name, 0, "a name in quotes"},
    {"ObjectBegin", Form::name, 0, "a name in quotes"},
    {"ObjectEnd", Form::nothing, 0, ""},
    {"ObjectInstance", Form::name, 0, "a name in quotes"},
    {"Option", Form::option, 0, "one parameter"},
    {"PixelFilter", Form::typed, 0, "a type in quotes"},
    {"ReverseOrientation", Form::nothing, 0, ""},
    {"Rotate", Form::numbers, 4, "4 numbers: degrees, axis"},
    {"Sampler", Form::typed, 0, "a type in quotes"},
    {"Scale", Form::numbers, 3, "3 numbers"},
    {"Shape", Form::typed, 0, "a type in quotes"},
    {"Texture", Form::texture, 0, "a name in quotes"},
    {"Transform", Form::matrix, 16, "16 numbers in brackets"},
    {"TransformBegin", Form::nothing, 0, ""},
    {"TransformEnd", Form::nothing, 0, ""},
    {"TransformTimes", Form::numbers, 2, "2 numbers: start, end"},
    {"Translate", Form::numbers, 3, "3 numbers"},
    {"WorldBegin", Form::nothing, 0, ""},
};
static_assert(std::size(table) == static_cast<std::size_t>(DirectiveId::world_begin) + 1);

Error unknown_directive(const Tokenizer& tokenizer, const Token& token) {
    if (token.kind != TokenKind::word)
        return tokenizer.error(token, "found " + describe(token) + "; expected a directive such as Shape or Material");
    std::vector<std::string> names;
    for (const DirectiveRow& row : table) names.emplace_back(row.name);
    std::string hint;
    if (token.text == "WorldEnd") {
        hint = "WorldEnd belongs to pbrt-v3; pbrt-v4 files end without it";
    } else if (token.text == "SurfaceIntegrator" || token.text == "Renderer" || token.text == "VolumeIntegrator") {
        hint = "this is a directive of an older pbrt; raylex reads pbrt-v4 files";
    } else if (const std::string near = nearest_name(token.text.substr(0, 40), names); !near.empty()) {
        hint = "did you mean " + near + "?";
    }
    return tokenizer.error(
        token, "unknown directive " + describe(token) + "; expected a directive such as Shape or Material", hint);
}

class DirectiveReader {
  public:
    DirectiveReader(Tokenizer& tokenizer, const DirectiveRow& row, Directive& directive)
        : tokenizer_(tokenizer), row_(row), directive_(directive) {}

    Status read() {
        switch (row_.form) {
            case Form::nothing:
                return success();
            case Form::numbers:
                return read_numbers();
            case Form::matrix:
                return read_matrix();
            case Form::word:
                return read_word();
            case Form::name:
                return read_string(row_.arguments);
            case Form::typed:
                return read_strings({row_.arguments}, true);
            case Form::texture:
                return read_strings({row_.arguments, "the texture's value type, \"float\" or \"spectrum\"",
                                     "the texture's type in quotes"},
                                    true);
            case Form::media:
                return read_media();
            case Form::option:
                return read_option();
        }
        return success();
    }

  private:
    Status read_numbers() {
        for (std::size_t i = 0; i < row_.count; ++i) {
            const Result<Token> token = tokenizer_.next();
            if (!token) return token.error();
            const Result<double> value =
                parse_number(tokenizer_, *token,
                             "number " + std::to_string(i + 1) + " of " + std::to_string(row_.count) + " after " +
                                 std::string(row_.name) + " (" + row_.arguments + ")");
            if (!value) return value.error();
            directive_.numbers[i] = *value;
        }
        return success();
    }

    Status expect(TokenKind kind, const char* shown) {
        const Result<Token> token = tokenizer_.next();
        if (!token) return token.error();
        if (token->kind != kind)
            return tokenizer_.error(*token, "found " + describe(*token) + "; expected " + shown + ": " +
                                                std::string(row_.name) + " takes " + row_.arguments);
        return success();
    }

    Status read_matrix() {
        if (Status status = expect(TokenKind::open_bracket, "'['"); !status) return status;
        if (Status status = read_numbers(); !status) return status;
        return expect(TokenKind::close_bracket, "']'");
    }

    Status read_word() {
        const Result<Token> token = tokenizer_.next();
        if (!token) return token.error();
        if (token->kind != TokenKind::word) return missing(*token, row_.arguments);
        directive_.strings.emplace_back(token->text);
        directive_.string_locations.push_back(tokenizer_.location(*token));
        return success();
    }

    Status read_string(const char* expected) {
        const Result<Token> token = tokenizer_.next();
        if (!token) return token.error();
        if (token->kind != TokenKind::string) return missing(*token, expected);
        Result<std::string> value = unescape(tokenizer_, *token);
        if (!value) return value.error();
        directive_.strings.push_back(std::move(*value));
        directive_.string_locations.push_back(tokenizer_.location(*token));
        return success();
    }

    Error missing(const Token& token, const char* expected) const {
        return tokenizer_.error(
            token, "found " + describe(token) + "; expected " + expected + " after " + std::string(row_.name));
    }

    Status read_strings(std::initializer_list<const char*> expected, bool parameters) {
        for (const char* what : expected)
            if (Status status = read_string(what); !status) return status;
        return parameters ? parse_parameters(tokenizer_, directive_.parameters, directive_.warnings) : success();
    }

    Status read_media() {
        if (Status status = read_string(row_.arguments); !status) return status;
        const Result<Token> token = tokenizer_.next();
        if (!token) return token.error();
        tokenizer_.push_back(*token);
        if (token->kind == TokenKind::string) return read_string(row_.arguments);
        directive_.strings.push_back(directive_.strings.front());  // one name stands for both sides
        directive_.string_locations.push_back(directive_.string_locations.front());
        return success();
    }

    Status read_option() {
        const Result<Token> first = tokenizer_.next();
        if (!first) return first.error();
        const bool plain =
            first->kind == TokenKind::string && first->text.find_first_of(" \t") == std::string_view::npos;
        if (plain) return parse_option(tokenizer_, *first, directive_.parameters);
        tokenizer_.push_back(*first);
        if (Status status = parse_parameters(tokenizer_, directive_.parameters, directive_.warnings); !status)
            return status;
        if (directive_.parameters.parameters.size() == 1) return success();
        const Result<Token> token = tokenizer_.next();
        if (!token) return token.error();
        return directive_.parameters.parameters.empty()
                   ? missing(*token, "one parameter, such as \"bool disablepixeljitter\" true,")
                   : tokenizer_.error(*token, "several parameters after Option; expected one");
    }

    Tokenizer& tokenizer_;
    const DirectiveRow& row_;
    Directive& directive_;
};

}  // namespace

Result<std::optional<Directive>> parse_directive(Tokenizer& tokenizer) {
    const Result<Token> token = tokenizer.next();
    if (!token) return token.error();
    if (token->kind == TokenKind::end) return std::optional<Directive>();
    const auto* row =
        std::find_if(std::begin(table), std::end(table), [&](const DirectiveRow& r) { return token->text == r.name; });
    if (token->kind != TokenKind::word || row == std::end(table)) return unknown_directive(tokenizer, *token);
    Directive directive;
    directive.id = static_cast<DirectiveId>(row - std::begin(table));
    directive.name = row->name;
    directive.location = tokenizer.location(*token);
    directive.parameters.location = directive.location;
    if (Status status = DirectiveReader(tokenizer, *row, directive).read(); !status) return status.error();
    return std::optional<Directive>(std::move(directive));
}

bool takes_parameters(const Directive& directive) {
    const Form form = table[static_cast<std::size_t>(directive.id)].form;
    return form == Form::typed || form == Form::texture;
}

Status parse_more_parameters(Tokenizer& tokenizer, Directive& directive) {
    return parse_parameters(tokenizer, directive.parameters, directive.warnings);
}

}  // namespace raylex::transport
