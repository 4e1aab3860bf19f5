#include "experiments/cluster/slurm.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "display/output/atomic_file.h"
#include "display/services/parameters.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/job/text/json.h"
#include "experiments/program/run_program.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

struct Response {
    int code = -1;
    std::string text;  ///< standard output, followed by standard error
};

/// Runs a program of Slurm to its end.
Response call(const std::vector<std::string>& arguments) {
    const auto outcome = run_program(arguments);
    if (!outcome) return {-1, outcome.error().message};
    return {outcome->exit_code, outcome->output + outcome->errors};
}

std::string slurm_folder(const std::string& directory) {
    return directory + "/slurm";
}

/// Returns the numbers as ranges for an array job: "1-3,5".
std::string ranges_text(const std::vector<unsigned>& numbers) {
    std::string text;
    for (std::size_t i = 0; i < numbers.size();) {
        std::size_t end = i;
        while (end + 1 < numbers.size() && numbers[end + 1] == numbers[end] + 1) ++end;
        text += (text.empty() ? "" : ",") + std::to_string(numbers[i]);
        if (end > i) text += "-" + std::to_string(numbers[end]);
        i = end + 1;
    }
    return text;
}

/// Returns a quoted file name for sbatch, in which % begins a placeholder and \\ escapes the next character.
std::string log_name(const std::string& folder, const std::string& name) {
    std::string text;
    for (const char c : folder) {
        if (c == '%' || c == '\\') text += c;
        else if (c == '"') text += '\\';
        text += c;
    }
    return text + "/" + name;
}

TemplateValues values_of(const SlurmRequest& request, const CommandPlan& plan, const PlannedCommand& command,
                         const std::string& job, const std::string& log) {
    // Slurm kills a task that exceeds its requested memory, hence a margin.
    constexpr double margin = 1.5;
    const double megabytes = std::ceil(margin * static_cast<double>(command.memory_bytes) / 1e6);
    std::string options;
    for (const std::string& each : request.options) options += (options.empty() ? "" : "\n") + ("#SBATCH " + each);
    return {{"job", plan.name + "-" + job},
            {"version", raylex_version() + " (" + raylex_revision() + ")"},
            {"log", log_name(slurm_folder(request.directory), log)},
            {"cores", std::to_string(command.cores)},
            {"memory", megabytes > 0 ? std::to_string(static_cast<std::uint64_t>(megabytes)) : std::string()},
            {"exclusive", command.exclusive ? "yes" : ""},
            {"options", options},
            {"array", ""},
            {"command", "exec " + shell_command(command.arguments)}};
}

Status write_job_file(const SlurmRequest& request, const std::string& name, const TemplateValues& values) {
    auto text = fill_template(request.form, values);
    if (!text) return text.error();
    return display::write_text_file(slurm_folder(request.directory) + "/" + name, *text);
}

void set_value(TemplateValues& values, const std::string& name, const std::string& value) {
    for (auto& [known, text] : values)
        if (known == name) text = value;
}

std::string by_hand(const std::string& directory, bool references) {
    const std::string folder = slurm_folder(directory);
    std::string text = "the job files are written; on a machine with Slurm, run\n";
    if (references) text += "  sbatch " + shell_command({folder + "/references.sh"}) + "\n";
    text += std::string("  sbatch ") + (references ? "--dependency=afterany:ID_OF_REFERENCES " : "") +
            shell_command({folder + "/shards.sh"}) + "\n  sbatch --dependency=afterany:ID_OF_SHARDS " +
            shell_command({folder + "/merge.sh"});
    return text;
}

/// Returns the id from the output of sbatch --parsable, "123" or "123;cluster"; empty if there is none.
std::string id_of(const Response& answer) {
    std::istringstream lines(answer.text);
    std::string id;
    for (std::string line; std::getline(lines, line);) {
        const std::string first = line.substr(0, line.find(';'));
        if (!first.empty() && std::all_of(first.begin(), first.end(), [](char c) { return c >= '0' && c <= '9'; }))
            id = first;
    }
    return answer.code == 0 ? id : std::string();
}

}  // namespace

std::vector<std::string> Submission::ids() const {
    std::vector<std::string> ids;
    for (const std::string* each : {&references, &shards, &merge})
        if (!each->empty()) ids.push_back(*each);
    return ids;
}

Result<std::vector<Submission>> read_submission(const std::string& directory) {
    const std::string path = directory + "/submission.json";
    std::error_code failed;
    if (!fs::exists(path, failed)) return std::vector<Submission>();
    auto json = read_json_file(path, "a submission.json");
    if (!json) return json.error();
    try {
        Submission submission;
        submission.submitted = json->at("submitted");
        submission.references = json->at("references");
        submission.shards = json->at("shards");
        submission.merge = json->at("merge");
        submission.count = whole(json->at("count"));
        return std::vector{submission};
    } catch (const std::exception& error) {
        return error_at({path, 0, 0}, std::string("this is not a submission.json, or it is damaged: ") + error.what(),
                        "remove it if none of its jobs is in the queue");
    }
}

Status write_submission(const std::string& directory, const Submission& submission) {
    const Json json{{"submitted", submission.submitted},
                    {"references", submission.references},
                    {"shards", submission.shards},
                    {"merge", submission.merge},
                    {"count", submission.count}};
    return display::write_text_file(directory + "/submission.json", json_text(json, 2) + "\n");
}

Status write_slurm_files(const SlurmRequest& request, const CommandPlan& plan, const std::vector<unsigned>& wanted) {
    const std::string folder = slurm_folder(request.directory);
    if (Status fits = check_job_texts(request.options, request.form, {"--option", 0, 0}); !fits) return fits;
    for (const PlannedCommand& each : plan.commands)
        if (Status fits = check_job_texts(each.arguments, request.form, {folder, 0, 0}); !fits) return fits;
    std::error_code failed;
    fs::create_directories(folder, failed);
    if (failed) return error_at({folder, 0, 0}, "cannot make this directory: " + failed.message());
    std::string lines;
    PlannedCommand all;  // requirements that hold for any shard
    for (const PlannedCommand& each : plan.commands) {
        if (each.name == "references")
            if (Status s = write_job_file(request, "references.sh",
                                          values_of(request, plan, each, "references", "references.log"));
                !s)
                return s;
        if (each.name == "merge")
            if (Status s = write_job_file(request, "merge.sh", values_of(request, plan, each, "merge", "merge.log"));
                !s)
                return s;
        if (!each.name.starts_with("shard-")) continue;
        lines += shell_command(each.arguments) + "\n";
        all.cores = std::max(all.cores, each.cores);
        all.memory_bytes = std::max(all.memory_bytes, each.memory_bytes);
        all.exclusive = all.exclusive || each.exclusive;
    }
    if (Status s = display::write_text_file(folder + "/commands.txt", lines); !s) return s;
    TemplateValues values = values_of(request, plan, all, "shards", "shard-%a.log");
    set_value(values, "array", ranges_text(wanted));
    set_value(values, "command",
              "command=$(sed -n \"${SLURM_ARRAY_TASK_ID}p\" " + shell_command({folder + "/commands.txt"}) +
                  ")\neval \"exec $command\"");
    return write_job_file(request, "shards.sh", values);
}

Result<Submission> submit_to_slurm(const std::string& directory, bool references, unsigned count) {
    const std::string folder = slurm_folder(directory);
    if (call({"sbatch", "--version"}).code != 0)
        return error_at({}, "sbatch was not found: Slurm's programs are not installed, or not in $PATH",
                        by_hand(directory, references));
    Submission submission;
    submission.submitted = utc_time();
    submission.count = count;
    std::string after;
    for (const auto& [file, id] : {std::pair<const char*, std::string*>{"references.sh", &submission.references},
                                   {"shards.sh", &submission.shards},
                                   {"merge.sh", &submission.merge}}) {
        if (id == &submission.references && !references) continue;
        std::vector<std::string> command{"sbatch", "--parsable"};
        if (!after.empty()) command.push_back("--dependency=afterany:" + after);
        command.push_back(folder + "/" + file);
        const Response answer = call(command);
        *id = id_of(answer);
        if (id->empty()) {
            for (const std::string& earlier : submission.ids()) static_cast<void>(call({"scancel", earlier}));
            return error_at({folder + "/" + file, 0, 0},
                            "sbatch rejects this job, and nothing was submitted: " + answer.text,
                            by_hand(directory, references));
        }
        after = *id;
    }
    return submission;
}

Result<std::map<std::string, std::string>> slurm_queue(const std::vector<std::string>& jobs) {
    std::map<std::string, std::string> tasks;
    if (jobs.empty()) return tasks;
    std::string list;
    for (const std::string& each : jobs) list += (list.empty() ? "" : ",") + each;
    // One line per task of an array, including pending tasks.
    const Response answer = call({"squeue", "--noheader", "--array", "--format=%i %T", "--jobs=" + list});
    // squeue forgets finished jobs after a while and then reports an error.
    if (answer.code != 0 && answer.text.find("Invalid job id") == std::string::npos)
        return error_at({}, "squeue failed: " + answer.text);
    std::istringstream lines(answer.text);
    for (std::string task, state; lines >> task >> state;)
        if (task.find_first_not_of("0123456789_") == std::string::npos) tasks[task] = state;
    return tasks;
}

}  // namespace raylex::experiments
