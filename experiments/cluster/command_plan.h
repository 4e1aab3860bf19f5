// A plan of work for many machines: independent commands, and what a queue needs for each. raylex has no queue of its
// own: it writes the plan as shell commands, as JSON, or by a template.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// A command that can be repeated: it skips finished work and resumes interrupted work.
struct PlannedCommand {
    std::string name;                    ///< "shard-2-of-8": unique; letters, digits and '-'
    std::vector<std::string> arguments;  ///< the program first; nothing depends on the current folder
    std::string target;                  ///< the file that exists when the command is done
    std::vector<std::string> needs;      ///< names of commands that must be done first
    std::uint64_t memory_bytes = 0;      ///< approximate maximum; 0: unknown
    double cpu_seconds = -1;             ///< of all threads together; negative: unknown
    unsigned cores = 1;
    bool exclusive = false;  ///< it measures time, so nothing else may run on its machine
};

struct CommandPlan {
    std::string name;                      ///< of the job: letters, digits, '-', '_' and '.'
    std::vector<std::string> notes;        ///< notes for readers of the file
    std::vector<PlannedCommand> commands;  ///< each after those that it needs
};

/// Returns the text with '_' for characters that queues do not allow in names.
std::string job_name(const std::string& text);

/// Returns the absolute path of this program.
std::string program_path();

/// Returns the values of --commands: "shell" (one command per line, its needs after '#'), "json" (one object per line),
/// and the names of raylex's templates.
std::vector<std::string> command_formats();

/// Checks that texts are valid in a job file: control characters and line ends would end a comment or an option, and
/// only shell and Make files allow bytes that are not UTF-8. The Error is at `place`.
Status check_job_texts(const std::vector<std::string>& texts, const std::string& format, const SourceLocation& place);

/// Returns the plan as a file. `format` is one of command_formats(), or the path of a user's template
/// (experiments/docs/clusters.md describes them). Errors: an unknown format, with the closest match; a template that
/// cannot be read or uses an unknown name, with its line.
Result<std::string> plan_text(const CommandPlan& plan, const std::string& format);

/// Named values for a template that does not use a plan.
using TemplateValues = std::vector<std::pair<std::string, std::string>>;
Result<std::string> fill_template(const std::string& format, const TemplateValues& values);

}  // namespace raylex::experiments
