// Man pages and completions for shells, from the same options and texts as --help.
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "display/output/atomic_file.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/unknown_words.h"
#include "experiments/job/rendering/provenance.h"

namespace raylex::experiments {
namespace {

std::string with(std::string text, const std::string& what, const std::string& by) {
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
        text.replace(at, what.size(), by);
    return text;
}

std::vector<const CLI::App*> below(const CLI::App& command) {
    return command.get_subcommands([](const CLI::App*) { return true; });
}

/// Returns a command and all commands below it.
std::vector<const CLI::App*> with_all_below(const CLI::App& command) {
    std::vector<const CLI::App*> result{&command};
    for (const CLI::App* each : below(command))
        for (const CLI::App* further : with_all_below(*each)) result.push_back(further);
    return result;
}

/// Returns the options that --help shows, group after group.
std::vector<const CLI::Option*> options_of(const CLI::App& command) {
    std::vector<const CLI::Option*> result;
    for (const std::string& group : command.get_groups())
        for (const CLI::Option* option : command.get_options())
            if (!group.empty() && option->get_group() == group) result.push_back(option);
    return result;
}

/// Returns the text up to its first semicolon, as the one line that a shell shows beside a word.
std::string short_text(const std::string& text) {
    return text.substr(0, text.find_first_of(";\n"));
}

std::string page_name(const CLI::App& command) {
    return with(command_words(command), " ", "-");
}

/// Returns the text for troff, each line of it on a line. \& hides a dot that begins a line.
std::string troff(const std::string& text) {
    std::istringstream lines(with(with(text, "\\", "\\e"), "-", "\\-"));
    std::string result;
    for (std::string line; std::getline(lines, line);) result += (result.empty() ? "\\&" : "\n.br\n\\&") + line;
    return result;
}

std::string man_page(const CLI::App& command) {
    const CLI::Formatter form;
    const std::string text = command.get_description();
    std::string page =
        ".TH " + page_name(command) + " 1 \"\" \"raylex " + raylex_version() + "\"\n.SH NAME\n" + page_name(command) +
        " \\- " + troff(text.substr(0, text.find_last_not_of('.') + 1)) + "\n.SH SYNOPSIS\n" +
        troff(with(with(form.make_usage(&command, command_words(command)), "\n", ""), "Usage: ", "")) + "\n";
    std::string group;
    for (const CLI::Option* option : options_of(command)) {
        if (option->get_group() != group) page += ".SH \"" + (group = option->get_group()) + "\"\n";
        page += ".TP\n.B " +
                troff(form.make_option_name(option, option->get_positional()) + form.make_option_opts(option)) + "\n" +
                troff(option->get_description()) + "\n";
    }
    if (!below(command).empty()) page += ".SH COMMANDS\n";
    for (const CLI::App* each : below(command))
        page += ".TP\n.BR " + troff(page_name(*each)) + " (1)\n" + troff(each->get_description()) + "\n";
    if (!command.get_footer().empty()) page += ".SH NOTES\n" + troff(command.get_footer()) + "\n";
    return page;
}

/// Returns a function for bash and zsh that sets `below` to the subcommands and `flags` to the options of the command
/// $1, as WORD:TEXT. It fails if there is no such command.
std::string word_table(const CLI::App& app) {
    std::string table = "_raylex_words() {\n    case $1 in\n";
    const auto entry = [](const std::string& word, const std::string& text) {
        return "'" + word + ":" + with(short_text(text), "'", "'\\''") + "' ";
    };
    for (const CLI::App* command : with_all_below(app)) {
        table += "    '" + command_words(*command) + "') below=(";
        for (const CLI::App* each : below(*command)) table += entry(each->get_name(), each->get_description());
        table += ") flags=(";
        for (const CLI::Option* option : options_of(*command))
            for (const std::string& name : option->get_lnames()) table += entry("--" + name, option->get_description());
        table += ") ;;\n";
    }
    return table + "    *) return 1 ;;\n    esac\n}\n";
}

constexpr const char* bash_text = R"text(
_raylex() {
    local below flags at=raylex word IFS=$'\n'
    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do if _raylex_words "$at $word"; then at+=" $word"; fi; done
    _raylex_words "$at"
    [[ $2 != -* ]] || below=("${flags[@]}")
    mapfile -t COMPREPLY < <(compgen -W "${below[*]%%:*}" -- "$2")
}
complete -o default -F _raylex raylex
)text";

constexpr const char* zsh_text = R"text(
_raylex() {
    local at=raylex word
    local -a below flags
    for word in ${words[2,CURRENT-1]}; do if _raylex_words "$at $word"; then at+=" $word"; fi; done
    _raylex_words "$at"
    if [[ $words[CURRENT] == -* ]]; then _describe -o option flags
    elif (( $#below )); then _describe command below
    else _files; fi
}
_raylex "$@"
)text";

constexpr const char* fish_text = R"text(
function __raylex_at
    set -l at raylex
    for word in (commandline -opc)[2..-1]
        contains -- "$at $word" $__raylex_commands; and set at "$at $word"
    end
    test "$at" = "$argv"
end
)text";

std::string fish_completion(const CLI::App& app) {
    std::string commands = "set -g __raylex_commands", lines;
    const auto quoted = [](const std::string& text) {
        return " '" + with(with(short_text(text), "\\", "\\\\"), "'", "\\'") + "'";
    };
    for (const CLI::App* command : with_all_below(app)) {
        commands += quoted(command_words(*command));
        const std::string begin = "complete -c raylex -n '__raylex_at " + command_words(*command) + "'";
        for (const CLI::App* each : below(*command))
            lines += begin + " -f -a " + each->get_name() + " -d" + quoted(each->get_description()) + "\n";
        for (const CLI::Option* option : options_of(*command)) {
            if (option->get_lnames().empty()) continue;
            lines += begin + " -l " + option->get_lnames().front();
            if (!option->get_snames().empty()) lines += " -s " + option->get_snames().front();
            lines +=
                (option->get_items_expected_min() > 0 ? " -r -d" : " -d") + quoted(option->get_description()) + "\n";
        }
    }
    return commands + fish_text + lines;
}

}  // namespace

Status write_manual(const CLI::App& app, const std::string& folder) {
    Status written = success();
    const auto write = [&](const std::string& name, const std::string& text) {
        const std::filesystem::path file = std::filesystem::path(folder) / name;
        std::error_code failed;
        std::filesystem::create_directories(file.parent_path(), failed);
        if (written) written = display::write_text_file(file.string(), text);
    };
    for (const CLI::App* command : with_all_below(app))
        write("man/man1/" + page_name(*command) + ".1", man_page(*command));
    write("bash-completion/completions/raylex", word_table(app) + bash_text);
    write("zsh/vendor-completions/_raylex", "#compdef raylex\n" + word_table(app) + zsh_text);
    write("fish/vendor_completions.d/raylex.fish", fish_completion(app));
    return written;
}

}  // namespace raylex::experiments
