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
#include <unordered_map>

#include "display/services/parameters.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/job/text/json.h"
#include "experiments/program/console.h"
#include "experiments/program/resource.h"
#include "lpe/input/read_input.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;
namespace mustache = kainjow::mustache;

/// Returns the name and the file of each of raylex's templates.
std::vector<std::pair<std::string, fs::path>> shipped_templates() {
    std::vector<std::pair<std::string, fs::path>> found;
    std::error_code failed;
    const auto folder = resource("cluster");
    for (const fs::directory_entry& each : fs::directory_iterator(folder ? *folder : "", failed))
        found.emplace_back(each.path().stem().string(), each.path());
    std::sort(found.begin(), found.end());
    return found;
}

std::string replaced(const std::string& text, const std::function<std::string(char)>& of) {
    std::string result;
    for (const char c : text) result += of(c);
    return result;
}

/// Returns a function that escapes text for files with this extension.
std::function<std::string(const std::string&)> escape_of(const std::string& extension) {
    const auto by = [](std::function<std::string(char)> of) {
        return [of = std::move(of)](const std::string& text) { return replaced(text, of); };
    };
    if (extension == ".mk") return by([](char c) { return c == '$' ? "$$" : std::string(1, c); });
    // Snakemake files have Python strings "...", in which braces are placeholders.
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
            // Kubernetes replaces $(NAME) by a value, and $$ by $.
            const std::string quoted =
                json_text(Json(replaced(text, [](char c) { return c == '$' ? "$$" : std::string(1, c); })));
            return quoted.substr(1, quoted.size() - 2);
        };
    return [](const std::string& text) { return text; };
}

/// Returns whether text stays on one line in every format: it has no control characters, no YAML line ends and no
/// characters forbidden in XML. A line break would end a comment or an option, and the rest would be executed.
bool stays_in_line(const std::string& text) {
    constexpr std::array<std::string_view, 5> refused{"\xC2\x85", "\xE2\x80\xA8", "\xE2\x80\xA9", "\xEF\xBF\xBE",
                                                      "\xEF\xBF\xBF"};
    return std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }) &&
           std::none_of(refused.begin(), refused.end(),
                        [&](std::string_view each) { return text.find(each) != std::string::npos; });
}

/// Returns the text in quotes, with codes instead of everything but visible ASCII.
std::string visible(const std::string& text) {
    return Json(text).dump(-1, ' ', true, Json::error_handler_t::replace);
}

std::string note_text(const std::string& note) {
    return stays_in_line(note) ? note : visible(note);
}

bool is_utf8(const std::string& text) {
    try {
        static_cast<void>(Json(text).dump());
        return true;
    } catch (const Json::exception&) { return false; }
}

/// Returns a name of letters, digits and '_' that does not begin with a digit.
std::string rule_name(const std::string& name) {
    std::string rule = name;
    for (char& c : rule)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    return rule.empty() || std::isdigit(static_cast<unsigned char>(rule.front())) != 0 ? "_" + rule : rule;
}

/// Returns whether Make can express this file name. For other files, the command uses its own name as target.
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
        command.memory_bytes > 0 ? size_text(static_cast<double>(command.memory_bytes)) : "memory unknown";
    text += command.cpu_seconds >= 0 ? ", " + duration_text(command.cpu_seconds) + " CPU" : ", CPU time unknown";
    return text + ", " + counted(command.cores, "core") + (command.exclusive ? ", alone on its machine" : "");
}

std::string shell_text(const CommandPlan& plan) {
    std::string text = "# " + plan.name + ": " + counted(plan.commands.size(), "command") + ", made by raylex " +
                       raylex_version() + " (" + raylex_revision() + ")\n";
    for (const std::string& note : plan.notes) text += "# " + note_text(note) + "\n";
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

/// Returns a Kubernetes name: lower-case letters, digits and '-', at most 63 characters. Its end distinguishes
/// commands.
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

/// The positions of commands by name. Each command comes after those that it needs.
class PlanIndex {
  public:
    explicit PlanIndex(const CommandPlan& plan) : plan_(plan), needed_(plan.commands.size()) {
        for (std::size_t i = 0; i < plan.commands.size(); ++i) {
            std::size_t step = 1;
            for (const std::string& need : plan.commands[i].needs) {
                const std::size_t other = at_.at(need);
                needed_[other] = true;
                step = std::max(step, 1 + steps_[other]);
            }
            at_[plan.commands[i].name] = i;
            steps_.push_back(step);
        }
    }
    [[nodiscard]] const PlannedCommand& command(const std::string& name) const { return plan_.commands[at_.at(name)]; }
    /// Returns 1 for a command without needs, else one more than the largest step of its needs.
    [[nodiscard]] std::size_t step(const std::string& name) const { return steps_[at_.at(name)]; }
    [[nodiscard]] bool is_needed(const std::string& name) const { return needed_[at_.at(name)]; }

  private:
    const CommandPlan& plan_;
    std::unordered_map<std::string, std::size_t> at_;
    std::vector<std::size_t> steps_;
    std::vector<bool> needed_;
};

mustache::data command_data(const CommandPlan& plan, const PlanIndex& index, const PlannedCommand& command,
                            bool with_needs) {
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
    data.set("last", !index.is_needed(command.name));
    data.set("job", object_name(plan.name, command.name));
    data.set("step", std::to_string(index.step(command.name)));
    if (!with_needs) return data;
    mustache::data needs(mustache::data::type::list);
    for (const std::string& need : command.needs) {
        mustache::data needed = command_data(plan, index, index.command(need), false);
        needed.set("dependent", rule_name(command.name));
        needs.push_back(needed);
    }
    data.set("needs", needs);
    return data;
}

mustache::data plan_data(const CommandPlan& plan) {
    mustache::data data, commands(mustache::data::type::list), notes(mustache::data::type::list);
    const PlanIndex index(plan);
    for (const PlannedCommand& each : plan.commands) commands.push_back(command_data(plan, index, each, true));
    for (const std::string& each : plan.notes) notes.push_back(mustache::data(note_text(each)));
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

/// Checks that the template uses only known names. Mustache writes nothing for an unknown name, which would leave a
/// hole.
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
            "the template uses the unknown name '" + name + "'; expected one of: " + list, near_miss(name, known));
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
    if (auto folder = resource("cluster"); !folder) return folder.error();
    std::string list;
    for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
    return error_at({"--commands", 0, 0},
                    "'" + format + "' is not a format; expected " + list + ", or the file of a template",
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
    if (!form.is_valid()) return error_at({file->string(), 0, 0}, "this is not a template: " + form.error_message());
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
        if (!name.starts_with("slurm")) formats.push_back(name);  // these belong to 'raylex submit'
    return formats;
}

Status check_job_texts(const std::vector<std::string>& texts, const std::string& format, const SourceLocation& place) {
    const std::string ending = fs::path(format).extension().string();
    const bool takes_bytes = format.empty() || format == "shell" || format == "make" || ending == ".mk" ||
                             format == "slurm" || ending == ".sh";
    for (const std::string& each : texts) {
        if (format != "json" && !stays_in_line(each))
            return error_at(place, visible(each) + " has a control character, which job files cannot contain",
                            "expected names and values on one line; --commands=json allows all characters");
        if (!takes_bytes && !is_utf8(each))
            return error_at(place, visible(each) + " is not UTF-8, which this format requires",
                            "expected other names; --commands, which writes shell commands, allows all names");
    }
    return success();
}

Result<std::string> plan_text(const CommandPlan& plan, const std::string& format) {
    for (const PlannedCommand& each : plan.commands)
        for (const auto& texts : {each.arguments, {each.target}})
            if (Status fits = check_job_texts(texts, format, {"--commands", 0, 0}); !fits) return fits.error();
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
