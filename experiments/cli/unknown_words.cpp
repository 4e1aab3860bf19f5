#include "experiments/cli/unknown_words.h"

#include <algorithm>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "display/services/parameters.h"
#include "lpe/algebra/wording/event_words.h"

namespace raylex::experiments {
namespace {

bool is_option(const std::string& word) {
    return word.size() > 1 && word.front() == '-' && word != "--";
}

/// Returns the option without its value: "--threads" for "--threads=4".
std::string option_name(const std::string& word) {
    return word.substr(0, word.find('='));
}

std::vector<std::string> subcommand_names(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::App* each : command.get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(each->get_name());
    return names;
}

/// Returns the option most similar to `name`, or an empty string. Dashes are not compared: a shared dash would make any
/// two one-letter options similar.
std::string nearest_option(const CLI::App& command, const std::string& name) {
    std::vector<std::string> known;
    for (const CLI::Option* option : command.get_options())
        known.insert(known.end(), option->get_lnames().begin(), option->get_lnames().end());
    const std::string near = nearest_name(name.substr(std::min(name.find_first_not_of('-'), name.size())), known);
    return near.empty() ? near : "--" + near;
}

std::string about_option(const CLI::App& given_to, const CLI::App& innermost, const std::string& word) {
    const std::string name = option_name(word), text = "unknown option '" + name + "'";
    if (&given_to == &innermost && innermost.get_option_no_throw(name) != nullptr)
        return "option '" + name + "' stands after '--', where words are not options; expected it before '--'";
    if (innermost.get_option_no_throw(name) != nullptr)
        return text + " of '" + command_words(given_to) + "'; expected it after '" + command_words(innermost) + "'";
    const std::string near = nearest_option(given_to, name);
    return near.empty() ? text : text + "; did you mean '" + near + "'?";
}

}  // namespace

std::string command_words(const CLI::App& command) {
    const CLI::App* above = command.get_parent();
    return (above == nullptr ? "" : command_words(*above) + " ") + command.get_name();
}

std::string expected_subcommands(const CLI::App& command) {
    return "expected one of: " + lpe::joined_by(subcommand_names(command), ", ");
}

std::string unknown_subcommand(const CLI::App& command, const std::string& word) {
    const std::string near = near_miss(word, subcommand_names(command));
    return "unknown subcommand '" + word + "'; " + expected_subcommands(command) + (near.empty() ? "" : "\n" + near);
}

std::string unknown_option(const CLI::App& command) {
    for (const CLI::App* each = &command; each != nullptr; each = each->get_parent())
        for (const std::string& word : each->remaining())
            if (is_option(word)) return about_option(*each, command, word);
    return {};
}

std::vector<std::string> further_words(const CLI::App& command) {
    std::vector<std::string> words = command.remaining();
    for (const std::string& word : words)
        if (is_option(word)) throw CLI::ExtrasError(command.get_name(), {word});
    std::erase(words, "--");
    return words;
}

}  // namespace raylex::experiments
