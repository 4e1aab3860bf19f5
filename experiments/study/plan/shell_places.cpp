#include "experiments/study/plan/shell_places.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

namespace raylex::experiments {
namespace {

/// Returns whether the value has no special meaning for a shell in any context: bare, in any quotes, in arithmetic, in
/// a here document.
bool is_inert(const std::string& value) {
    return !value.empty() && value.front() != '-' && std::all_of(value.begin(), value.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
               std::string_view("_./:,+@%=-").find(c) != std::string_view::npos;
    });
}

/// Returns whether the program takes a script as an argument: sh -c, bash -lc, python3 -c, perl -e.
bool is_interpreter(const std::string& name) {
    return name.ends_with("sh") || name.starts_with("python") || name.starts_with("perl") || name.starts_with("ruby") ||
           name.starts_with("node") || name.starts_with("lua");
}

/// Returns the part of a command that another shell reads, which would interpret the inserted values; empty if there is
/// none.
std::string other_shell(const std::string& command) {
    if (command.find("<<") != std::string::npos) return "a here document";
    std::string word, before;
    for (std::size_t i = 0; i <= command.size(); ++i) {
        const char c = i < command.size() ? command[i] : ' ';
        if (std::string_view(" \t\n;&|(){}`'\"").find(c) == std::string_view::npos) {
            if (c != '\\') word += c;
            continue;
        }
        if (word.empty()) continue;
        const std::string name = word.substr(word.rfind('/') + 1);
        if (name == "eval" || name == "ssh" || name == "su") return name;
        const bool is_option = word.size() >= 2 && word[0] == '-' && word[1] != '-';
        if (is_option && is_interpreter(before) && (word.back() == 'c' || word.back() == 'e'))
            return before + " " + word;
        if (!is_option) before = name;
        word.clear();
    }
    return {};
}

enum class Quote : char { none, single_quotes, double_quotes, substitution, backquotes };

/// Follows the quotes of a line through nested $(...) and `...`.
class QuoteTracker {
  public:
    [[nodiscard]] Quote now() const { return nested_.back(); }

    /// Steps past command[at]. Returns the number of characters that form one unit for the shell.
    std::size_t step(const std::string& command, std::size_t at) {
        const char c = command[at];
        const bool is_code = now() != Quote::single_quotes && now() != Quote::double_quotes;
        if (now() == Quote::single_quotes) {
            if (c == '\'') nested_.pop_back();
            return 1;
        }
        if (c == '\\') return 2;
        if (c == '`') toggle(Quote::backquotes);
        else if (c == '$' && at + 1 < command.size() && command[at + 1] == '(') {
            nested_.push_back(Quote::substitution);
            return 2;
        } else if (c == '"') toggle(Quote::double_quotes);
        else if (is_code && c == '\'') nested_.push_back(Quote::single_quotes);
        else if (is_code && c == '(') nested_.push_back(Quote::substitution);
        else if (c == ')' && now() == Quote::substitution) nested_.pop_back();
        else if (is_code && c == '#' && (at == 0 || std::isspace(static_cast<unsigned char>(command[at - 1])) != 0)) {
            const std::size_t end = command.find('\n', at);
            return (end == std::string::npos ? command.size() : end) - at;
        }
        return 1;
    }

  private:
    void toggle(Quote kind) {
        if (now() == kind) nested_.pop_back();
        else nested_.push_back(kind);
    }
    std::vector<Quote> nested_{Quote::none};
};

/// Returns the variable for a value, quoted so that the value stays one word.
std::string quoted_variable(const std::string& variable, Quote around) {
    const std::string expansion = "${" + variable + "}";
    if (around == Quote::double_quotes) return expansion;
    return around == Quote::single_quotes ? "'\"" + expansion + "\"'" : "\"" + expansion + "\"";
}

}  // namespace

std::string place_variable(const std::string& name) {
    std::string variable = "RAYLEX_";
    for (const char c : name)
        variable += std::isalnum(static_cast<unsigned char>(c)) != 0
                        ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
                        : '_';
    return variable;
}

bool has_place(const std::string& command, const std::string& name) {
    if (command.find("{" + name + "}") != std::string::npos) return true;
    const std::string variable = place_variable(name);
    for (std::size_t at = 0; (at = command.find(variable, at)) != std::string::npos; at += variable.size()) {
        const char next = at + variable.size() < command.size() ? command[at + variable.size()] : ' ';
        if (next != '_' && std::isalnum(static_cast<unsigned char>(next)) == 0) return true;
    }
    return false;
}

Result<ShellCommand> fill_command(const std::string& command, const NamedValues& places, const SourceLocation& where) {
    ShellCommand filled;
    for (const auto& [name, value] : places) filled.environment.emplace_back(place_variable(name), value);
    const std::string handed = other_shell(command);
    QuoteTracker quotes;
    for (std::size_t at = 0; at < command.size();) {
        const auto place = std::find_if(places.begin(), places.end(), [&](const auto& each) {
            return command.compare(at, each.first.size() + 2, "{" + each.first + "}") == 0;
        });
        if (place == places.end() || (at > 0 && command[at - 1] == '$')) {
            const std::size_t length = std::min(quotes.step(command, at), command.size() - at);
            filled.text.append(command, at, length);
            at += length;
            continue;
        }
        at += place->first.size() + 2;
        if (is_inert(place->second)) {
            filled.text += place->second;
            continue;
        }
        const std::string variable = place_variable(place->first);
        if (!handed.empty())
            return error_at(where,
                            "{" + place->first + "} is '" + place->second + "' here, but the command has " + handed +
                                ", which would interpret it as code; expected a name of letters, digits and _./:,+@%=-",
                            "write \"$" + variable + "\" for the inner shell instead of {" + place->first +
                                "}, or rename the file");
        filled.text += quoted_variable(variable, quotes.now());
    }
    return filled;
}

}  // namespace raylex::experiments
