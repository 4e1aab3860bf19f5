// Work for many machines as commands that each stand alone, and what a queue must know of them. The queue is somebody
// else's: the plan is written as lines for a shell, as JSON, or by a template.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Idempotent: what is done is not done again, and what was killed goes on.
struct PlannedCommand {
    std::string name;                    ///< "shard-2-of-8": unique; letters, digits and '-'
    std::vector<std::string> arguments;  ///< the program first; nothing in them depends on the folder
    std::string target;                  ///< the file that is there when it is done
    std::vector<std::string> needs;      ///< names of commands that must be done before
    std::uint64_t memory_bytes = 0;      ///< at most, about; 0: not known
    double cpu_seconds = -1;             ///< of all threads; negative: not known
    unsigned cores = 1;
    bool exclusive = false;  ///< it measures seconds: nothing else may run on its machine
};

struct CommandPlan {
    std::string name;                      ///< of the job: letters, digits, '-', '_' and '.'
    std::vector<std::string> notes;        ///< for whoever reads the file
    std::vector<PlannedCommand> commands;  ///< each behind those that it needs
};

/// The text with what queues do not take in a name as '_'.
std::string job_name(const std::string& text);

/// Of this program, whole.
std::string program_path();

/// What --commands can be: "shell" (a command a line, its needs behind '#'), "json" (an object a line), or the name of
/// a template that comes with raylex.
std::vector<std::string> command_formats();

/// Whether texts can stand in a job file: control characters and line ends would end a comment or an option there, and
/// only files for a shell or Make hold bytes that are no UTF-8. The Error is at `place`.
Status check_job_texts(const std::vector<std::string>& texts, const std::string& format, const SourceLocation& place);

/// The plan as a file. `format` is one of command_formats(), or the path of a template of somebody's own
/// (experiments/docs/clusters.md says what stands in one). Errors: no such format with the near miss; a template that
/// cannot be read or asks for what there is not, with its line.
Result<std::string> plan_text(const CommandPlan& plan, const std::string& format);

/// A template's text from named texts alone, for files that are of no plan.
using TemplateValues = std::vector<std::pair<std::string, std::string>>;
Result<std::string> fill_template(const std::string& format, const TemplateValues& values);

}  // namespace raylex::experiments
