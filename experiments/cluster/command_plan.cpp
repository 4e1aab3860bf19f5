#include "experiments/cluster/command_plan.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iterator>
#include <kainjow/mustache.hpp>
#include <string_view>

#include "display/services/parameters.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/job/text/json.h"
#include "experiments/program/console.h"
#include "lpe/read_input.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;
namespace mustache = kainjow::mustache;

/// Where the templates that come with raylex stand: beside the program in a build folder, or as installed.
fs::path template_folder() {
    std::error_code failed;
    const fs::path program = fs::path(program_path()).parent_path();
    const fs::path built = program / "cluster", installed = program.parent_path() / RAYLEX_CLUSTER_FOLDER;
    return fs::exists(built, failed) ? built : installed;
}

/// Name and file of each template there.
std::vector<std::pair<std::string, fs::path>> shipped_templates() {
    std::vector<std::pair<std::string, fs::path>> found;
    std::error_code failed;
    for (const fs::directory_entry& each : fs::directory_iterator(template_folder(), failed))
        found.emplace_back(each.path().stem().string(), each.path());
    std::sort(found.begin(), found.end());
    return found;
}

std::string replaced(const std::string& text, const std::function<std::string(char)>& of) {
    std::string result;
    for (const char c : text) result += of(c);
    return result;
}

/// How text stands in a file of this ending.
std::function<std::string(const std::string&)> escape_of(const std::string& extension) {
    const auto by = [](std::function<std::string(char)> of) {
        return [of = std::move(of)](const std::string& text) { return replaced(text, of); };
    };
    if (extension == ".mk") return by([](char c) { return c == '$' ? "$$" : std::string(1, c); });
    // Inside "..." of Python, where Snakemake takes braces for places.
    if (extension == ".smk")
        return by([](char c) {
            if (c == '\\' || c == '"') return std::string("\\") + c;
            if (c == '\n') return std::string("\\n");
            return c == '{' || c == '}' ? std::string(2, c) : std::string(1, c);
        });
    if (extension == ".xml")
        return by([](char c) {
            const std::string_view known = "&<>\"";
            constexpr std::array names{"&amp;", "&lt;", "&gt;", "&quot;"};
            const std::size_t at = known.find(c);
            return at == std::string_view::npos ? std::string(1, c) : std::string(names[at]);
        });
    if (extension == ".yaml")  // inside "..."
        return [](const std::string& text) {
            // Kubernetes puts values in the place of $(NAME), and $ in that of $$.
            const std::string quoted =
                json_text(Json(replaced(text, [](char c) { return c == '$' ? "$$" : std::string(1, c); })));
            return quoted.substr(1, quoted.size() - 2);
        };
    return [](const std::string& text) { return text; };
}

/// Letters, digits and '_', not beginning with a digit.
std::string rule_name(const std::string& name) {
    std::string rule = name;
    for (char& c : rule)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    return rule.empty() || std::isdigit(static_cast<unsigned char>(rule.front())) != 0 ? "_" + rule : rule;
}

/// Make knows no way to write some characters in a file's name; then the command goes by its own.
bool is_plain_file(const std::string& path) {
    return !path.empty() && std::all_of(path.begin(), path.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
               std::string_view("-_./+,@").find(c) != std::string_view::npos;
    });
}

double megabytes(std::uint64_t bytes) {
    return std::ceil(static_cast<double>(bytes) / 1e6);
}

std::string needs_text(const PlannedCommand& command) {
    std::string text =
        command.memory_bytes > 0 ? size_text(static_cast<double>(command.memory_bytes)) : "memory not known";
    text += command.cpu_seconds >= 0 ? ", " + duration_text(command.cpu_seconds) + " CPU" : ", CPU time not known";
    return text + ", " + counted(command.cores, "core") + (command.exclusive ? ", nothing else on its machine" : "");
}

std::string shell_text(const CommandPlan& plan) {
    std::string text = "# " + plan.name + ": " + counted(plan.commands.size(), "command") + ", made by raylex " +
                       raylex_version() + " (" + raylex_revision() + ")\n";
    for (const std::string& note : plan.notes) text += "# " + note + "\n";
    for (const PlannedCommand& each : plan.commands)
        text += shell_command(each.arguments) + "  # " + each.name + ": " + needs_text(each) + "\n";
    return text;
}

std::string json_lines(const CommandPlan& plan) {
    std::string text;
    for (const PlannedCommand& each : plan.commands) {
        Json json{{"name", each.name},           {"command", shell_command(each.arguments)},
                  {"arguments", each.arguments}, {"target", each.target},
                  {"needs", each.needs},         {"memory_bytes", nullptr},
                  {"cpu_seconds", nullptr},      {"cores", each.cores},
                  {"exclusive", each.exclusive}};
        if (each.memory_bytes > 0) json["memory_bytes"] = each.memory_bytes;
        if (each.cpu_seconds >= 0) json["cpu_seconds"] = each.cpu_seconds;
        text += json_text(json) + "\n";
    }
    return text;
}

mustache::data argument_list(const std::vector<std::string>& arguments) {
    mustache::data list(mustache::data::type::list);
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        mustache::data each;
        each.set("argument", arguments[i]);
        each.set("more", i + 1 < arguments.size());
        list.push_back(each);
    }
    return list;
}

/// Small letters, digits and '-', at most 63 of them: a name in Kubernetes, whose end tells commands apart.
std::string object_name(const std::string& plan, const std::string& command) {
    constexpr std::size_t most = 63;
    const std::size_t left = most - std::min(most, command.size() + 1);
    std::string name = plan.substr(0, left) + "-" + command;
    for (char& c : name)
        c = std::isalnum(static_cast<unsigned char>(c)) == 0
                ? '-'
                : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return name.substr(name.find_first_not_of('-'));
}

/// 1 for what needs nothing, else one more than what it needs.
std::size_t step_of(const CommandPlan& plan, const PlannedCommand& command) {
    std::size_t step = 1;
    for (const PlannedCommand& other : plan.commands)
        if (std::find(command.needs.begin(), command.needs.end(), other.name) != command.needs.end())
            step = std::max(step, 1 + step_of(plan, other));
    return step;
}

mustache::data command_data(const CommandPlan& plan, const PlannedCommand& command, bool with_needs) {
    mustache::data data;
    const bool plain = is_plain_file(command.target);
    data.set("command_name", command.name);
    data.set("rule", rule_name(command.name));
    data.set("goal", plain ? command.target : rule_name(command.name));
    data.set("plain", plain);
    data.set("target", command.target);
    data.set("command", shell_command(command.arguments));
    data.set("arguments", argument_list(command.arguments));
    data.set("cores", std::to_string(command.cores));
    data.set("exclusive", command.exclusive);
    data.set("resources", needs_text(command));
    data.set("memory_known", command.memory_bytes > 0);
    data.set("memory_mb", number_text(megabytes(command.memory_bytes), 12));
    data.set("cpu_seconds", number_text(std::max(0.0, command.cpu_seconds)));
    const bool last = std::none_of(plan.commands.begin(), plan.commands.end(), [&](const PlannedCommand& other) {
        return std::find(other.needs.begin(), other.needs.end(), command.name) != other.needs.end();
    });
    data.set("last", last);
    data.set("job", object_name(plan.name, command.name));
    data.set("step", std::to_string(step_of(plan, command)));
    if (!with_needs) return data;
    mustache::data needs(mustache::data::type::list);
    for (const PlannedCommand& other : plan.commands)
        if (std::find(command.needs.begin(), command.needs.end(), other.name) != command.needs.end()) {
            mustache::data needed = command_data(plan, other, false);
            needed.set("dependent", rule_name(command.name));
            needs.push_back(needed);
        }
    data.set("needs", needs);
    return data;
}

mustache::data plan_data(const CommandPlan& plan) {
    mustache::data data, commands(mustache::data::type::list), notes(mustache::data::type::list);
    for (const PlannedCommand& each : plan.commands) commands.push_back(command_data(plan, each, true));
    for (const std::string& each : plan.notes) notes.push_back(mustache::data(each));
    data.set("name", plan.name);
    data.set("version", raylex_version() + " (" + raylex_revision() + ")");
    data.set("notes", notes);
    data.set("commands", commands);
    return data;
}

const std::vector<std::string>& plan_names() {
    static const std::vector<std::string> names{"name",         "version",     "notes",    ".",         "commands",
                                                "command_name", "rule",        "goal",     "plain",     "target",
                                                "command",      "arguments",   "argument", "more",      "cores",
                                                "exclusive",    "resources",   "last",     "memory_mb", "needs",
                                                "memory_known", "cpu_seconds", "job",      "step",      "dependent"};
    return names;
}

/// Mustache writes nothing for a name that it does not know; a file with a hole helps nobody.
Status check_names(const std::string& text, const std::string& path, const std::vector<std::string>& known) {
    for (std::size_t at = text.find("{{"); at != std::string::npos; at = text.find("{{", at + 2)) {
        const std::size_t begin = text.find_first_not_of("{#^/& ", at), end = text.find_first_of("} ", begin);
        if (begin == std::string::npos || end == std::string::npos || text[at + 2] == '!') continue;
        const std::string name = text.substr(begin, end - begin);
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        std::string list;
        for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
        return error_at(
            {path, static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n')) + 1,
             0},
            "the template asks for '" + name + "', which is not known; expected one of: " + list,
            near_miss(name, known));
    }
    return success();
}

Result<fs::path> template_file(const std::string& format) {
    std::error_code failed;
    std::vector<std::string> known{"shell", "json"};
    for (const auto& [name, path] : shipped_templates()) {
        if (name == format) return path;
        known.push_back(name);
    }
    if (format.find_first_of("./") != std::string::npos || fs::exists(format, failed)) return fs::path(format);
    std::string list;
    for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
    return error_at({"--commands", 0, 0}, "'" + format + "' is no format; expected " + list + ", or a template's file",
                    near_miss(format, known));
}

Result<std::string> rendered_template(const std::string& format, const mustache::data& data,
                                      const std::vector<std::string>& known) {
    auto file = template_file(format);
    if (!file) return file.error();
    auto text = read_input(file->string(), NamedBy::command_line, "a template");
    if (!text) return text.error();
    if (Status s = check_names(*text, file->string(), known); !s) return s.error();
    mustache::mustache form(*text);
    if (!form.is_valid()) return error_at({file->string(), 0, 0}, "this is no template: " + form.error_message());
    form.set_custom_escape(escape_of(file->extension().string()));
    return form.render(data);
}

}  // namespace

std::string program_path() {
    std::error_code failed;
    return fs::read_symlink("/proc/self/exe", failed).string();
}

std::string job_name(const std::string& text) {
    std::string name = text.empty() ? "raylex" : text;
    for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') c = '_';
    return name;
}

std::vector<std::string> command_formats() {
    std::vector<std::string> formats{"shell", "json"};
    for (const auto& [name, path] : shipped_templates())
        if (!name.starts_with("slurm")) formats.push_back(name);  // those are for 'raylex submit'
    return formats;
}

Result<std::string> plan_text(const CommandPlan& plan, const std::string& format) {
    if (format.empty() || format == "shell") return shell_text(plan);
    if (format == "json") return json_lines(plan);
    return rendered_template(format, plan_data(plan), plan_names());
}

Result<std::string> fill_template(const std::string& format, const TemplateValues& values) {
    mustache::data data;
    std::vector<std::string> known;
    for (const auto& [name, value] : values) {
        data.set(name, value.empty() ? mustache::data(false) : mustache::data(value));
        known.push_back(name);
    }
    return rendered_template(format, data, known);
}

}  // namespace raylex::experiments
