// Code that can affect an image calls no function whose bits depend on the processor: the test searches the sources.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "tests/support/paths.h"

namespace {

namespace fs = std::filesystem;

/// Files that can use these names, and the reason.
const std::pair<const char*, const char*> exempt[] = {
    {"display/services/elementary.h", "replaces them"},
    {"display/services/elementary.cpp", "replaces them"},
};

/// Functions that C libraries select by processor, or whose last bits depend on the version.
const std::set<std::string>& forbidden_functions() {
    static const std::set<std::string> all = [] {
        std::set<std::string> names = {"sincos",         "sincosf",      "pow10",    "exp10",
                                       "riemann_zeta",   "cyl_bessel_j", "beta",     "legendre",
                                       "assoc_legendre", "ellint_1",     "ellint_2", "expint"};
        for (const char* name : {"sin",   "cos",   "tan",   "asin",  "acos",  "atan", "atan2", "sinh",   "cosh",
                                 "tanh",  "asinh", "acosh", "atanh", "exp",   "exp2", "expm1", "log",    "log2",
                                 "log10", "log1p", "pow",   "cbrt",  "hypot", "erf",  "erfc",  "tgamma", "lgamma"})
            for (const char* suffix : {"", "f", "l"}) names.insert(name + std::string(suffix));
        return names;
    }();
    return all;
}

/// Types and headers that use them internally.
const std::set<std::string> forbidden_names = {"normal_distribution",
                                               "lognormal_distribution",
                                               "exponential_distribution",
                                               "gamma_distribution",
                                               "poisson_distribution",
                                               "complex",
                                               "valarray"};

bool in_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// The code without comments and without the contents of literals.
std::string code_of(const std::string& text) {
    std::string code;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text.compare(i, 2, "//") == 0) {
            i = std::min(text.find('\n', i), text.size() - 1);
            code += '\n';
        } else if (text.compare(i, 2, "/*") == 0) {
            const std::size_t end = text.find("*/", i + 2);
            i = end == std::string::npos ? text.size() : end + 1;
        } else if (text[i] == '\'' && (i == 0 || !in_word(text[i - 1]))) {  // otherwise it separates digits
            i += text.compare(i + 1, 1, "\\") == 0 ? 3 : 2;
        } else if (text[i] == '"') {
            const bool raw = i > 0 && text[i - 1] == 'R';
            if (raw) {
                const std::string closing = ")" + text.substr(i + 1, text.find('(', i) - i - 1) + "\"";
                i = text.find(closing, i) + closing.size() - 1;
            } else {
                for (++i; i < text.size() && text[i] != '"'; ++i)
                    if (text[i] == '\\') ++i;
            }
            code += "\"\"";
        } else {
            code += text[i];
        }
    }
    return code;
}

/// Returns whether the word at `begin` is a call, or a name from std or the global namespace.
bool is_library_name(const std::string& code, std::size_t begin, std::size_t end) {
    std::size_t before = begin;
    while (before > 0 && std::isspace(static_cast<unsigned char>(code[before - 1])) != 0) --before;
    if (before >= 2 && code.compare(before - 2, 2, "::") == 0) {
        std::size_t owner = before - 2;
        while (owner > 0 && in_word(code[owner - 1])) --owner;
        const std::string name = code.substr(owner, before - 2 - owner);
        return name.empty() || name == "std";
    }
    const bool member =
        before > 0 && (code[before - 1] == '.' || (before > 1 && code.compare(before - 2, 2, "->") == 0));
    while (end < code.size() && std::isspace(static_cast<unsigned char>(code[end])) != 0) ++end;
    return !member && end < code.size() && code[end] == '(';
}

/// Approximations whose digits depend on the manufacturer (rcpps, rsqrtps), and compilers' names of the functions.
bool is_forbidden_builtin(const std::string& word) {
    const std::string builtin = "__builtin_";
    if (word.starts_with(builtin)) return forbidden_functions().count(word.substr(builtin.size())) != 0;
    return word.starts_with("_mm") &&
           (word.find("_rcp") != std::string::npos || word.find("_rsqrt") != std::string::npos);
}

/// The first forbidden name in the text, or "".
std::string forbidden_name(const std::string& text) {
    const std::string code = code_of(text);
    for (std::size_t i = 0; i < code.size();) {
        if (!in_word(code[i])) {
            ++i;
            continue;
        }
        const std::size_t begin = i;
        while (i < code.size() && in_word(code[i])) ++i;
        const std::string word = code.substr(begin, i - begin);
        if (forbidden_functions().count(word) != 0 && is_library_name(code, begin, i)) return word;
        if (forbidden_names.count(word) != 0 || is_forbidden_builtin(word)) return word;
    }
    return {};
}

}  // namespace

TEST_CASE("no source that affects images uses a function that depends on the processor", "[layout]") {
    const fs::path root = raylex::test::source_dir();
    std::size_t files = 0, exempted = 0;
    for (const char* top : {"lpe", "display", "geoaovs", "transport"}) {
        for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".h" && extension != ".cpp" && extension != ".in") continue;
            const std::string file = fs::relative(entry.path(), root).string();
            if (file.find("/bench/") != std::string::npos) continue;
            ++files;
            std::ifstream in(entry.path());
            const std::string text{std::istreambuf_iterator<char>(in), {}};
            if (std::any_of(std::begin(exempt), std::end(exempt), [&](const auto& e) { return file == e.first; })) {
                ++exempted;
                continue;
            }
            INFO(file << ": call elementary:: instead (display/services/elementary.h)");
            CHECK(forbidden_name(text) == "");
        }
    }
    CHECK(files > 250);
    CHECK(exempted == std::size(exempt));
}

TEST_CASE("the search finds every way of naming such a function", "[layout]") {
    for (const char* text :
         {"x = std::sin(y);", "using std::pow;", "f(&std::exp);", "x = sinf(y);", "x = ::log(y);",
          "auto f = std :: cos;", "std::normal_distribution<float> n;", "#include <complex>", "x = __builtin_sin(y);",
          "y = _mm_rcp_ps(x);", "y = _mm256_rsqrt_ps(x);", "c = '\"'; x = sin(y);", "atan2 (a, b)"})
        CHECK(forbidden_name(text) != "");
    for (const char* text :
         {"x = elementary::sin(y);", "// std::sin(x)", "say(\"sin(x)\");", "stats.log(x);", "double exp = 1;",
          "entry->log(x)", "R\"(std::sin(x))\"", "x = std::sqrt(y);", "using elementary::exp;", "Table::exp(x)"})
        CHECK(forbidden_name(text) == "");
}
