#include "experiments/cluster/study_status.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "experiments/cluster/slurm.h"
#include "experiments/cluster/study_commands.h"
#include "experiments/program/work_lock.h"
#include "experiments/study/run/run_marks.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// Counts the complete entries of a folder, without partial and hidden ones.
std::size_t count_entries(const std::string& folder) {
    std::size_t count = 0;
    std::error_code failed;
    for (const fs::directory_entry& each : fs::directory_iterator(folder, failed)) {
        const std::string name = each.path().filename().string();
        if (!name.ends_with(".partial") && !name.starts_with(".")) ++count;
    }
    return count;
}

/// Returns the number of shards by the part directories, for studies without a submission.
unsigned shards_begun(const StudyFolders& folders) {
    unsigned shards = 0;
    std::error_code failed;
    for (const fs::directory_entry& each : fs::directory_iterator(folders.parts, failed))
        if (const auto mark = begun_mark(each.path().string()); mark && !mark->only_references)
            shards = std::max(shards, mark->shard.parts);
    return shards;
}

/// Returns the last error in a task's log. A full disk can prevent the error mark of a cell, but not this.
std::string error_in_log(const std::string& path) {
    std::ifstream log(path);
    std::string error;
    for (std::string line; std::getline(log, line);)
        if (line.starts_with("raylex: error:")) error = line.substr(std::string("raylex: error: ").size());
    return error;
}

class Look {
  public:
    Look(const std::string& directory, const Submission* submission) : folders_(directory), submission_(submission) {
        if (submission == nullptr) return;
        auto queue = slurm_queue(submission->ids());
        if (queue) queue_ = *std::move(queue);
        else warning_ = queue.error().to_string();
    }

    [[nodiscard]] std::string warning() const { return warning_; }

    [[nodiscard]] TaskStatus part(const std::string& name, const std::string& directory, const std::string& job,
                                  const std::string& log) const {
        TaskStatus status;
        status.name = name;
        status.runs = count_entries(directory + "/cells");
        status.failed_runs = count_entries(directory + "/failed");
        const auto finished = finished_mark(directory);
        if (finished) {
            status.state = finished->failed > 0 ? TaskState::failed : TaskState::done;
            if (finished->failed > 0) status.message = first_failure(directory, *finished);
        } else if (const TaskState queued = in_queue(job); queued != TaskState::missing) {
            status.state = queued;
        } else if (WorkLock::is_held(lock_of(directory))) {
            status.state = TaskState::running;
        } else if (status.message = error_mark(directory); !status.message.empty()) {
            status.state = TaskState::failed;
        } else if (begun_mark(directory) || !job.empty()) {
            status.message = log.empty() ? std::string() : error_in_log(log);
            status.state = status.message.empty() ? TaskState::stopped : TaskState::failed;
            if (status.message.empty()) status.message = "it ended before it was finished";
        }
        return status;
    }

    [[nodiscard]] TaskStatus merge() const {
        TaskStatus status;
        status.name = "merge";
        std::error_code failed;
        if (fs::exists(folders_.results + "/experiment.json", failed)) status.state = TaskState::done;
        else if (submission_ != nullptr) status.state = in_queue(submission_->merge);
        return status;
    }

  private:
    static std::string lock_of(const std::string& directory) {
        const auto mark = begun_mark(directory);
        return directory + "/.running" + (mark && mark->shard.parts > 1 ? "-" + std::to_string(mark->shard.part) : "");
    }

    [[nodiscard]] TaskState in_queue(const std::string& job) const {
        const auto found = queue_.find(job);
        if (job.empty() || found == queue_.end()) return TaskState::missing;
        const std::string& state = found->second;
        return state == "PENDING" || state == "REQUEUED" ? TaskState::queued : TaskState::running;
    }

    static std::string first_failure(const std::string& directory, const RunMark& mark) {
        std::error_code failed;
        for (const fs::directory_entry& each : fs::directory_iterator(directory + "/failed", failed))
            return "cell " + each.path().stem().string() + (mark.failed > 1 ? " and others" : "");
        return "a reference";
    }

    StudyFolders folders_;
    const Submission* submission_;
    std::map<std::string, std::string> queue_;
    std::string warning_;
};

}  // namespace

std::size_t StudyStatus::count(TaskState state) const {
    return static_cast<std::size_t>(
        std::count_if(tasks.begin(), tasks.end(), [&](const TaskStatus& each) { return each.state == state; }));
}

std::string state_text(TaskState state) {
    switch (state) {
        case TaskState::done:
            return "done";
        case TaskState::running:
            return "running";
        case TaskState::queued:
            return "queued";
        case TaskState::failed:
            return "FAILED";
        case TaskState::stopped:
            return "stopped";
        case TaskState::missing:
            return "missing";
    }
    return {};
}

Result<StudyStatus> study_status(const std::string& directory) {
    auto submissions = read_submission(directory);
    if (!submissions) return submissions.error();
    const Submission* submission = submissions->empty() ? nullptr : &submissions->front();
    const StudyFolders folders(directory);
    const unsigned shards = submission != nullptr ? submission->count : shards_begun(folders);
    if (shards == 0)
        return error_at({directory, 0, 0}, "this directory contains no study",
                        "expected the -o of 'raylex submit' or of 'raylex experiment plan --commands'");
    const Look look(directory, submission);
    StudyStatus status;
    status.warning = look.warning();
    std::error_code failed;
    const bool submitted = submission != nullptr;
    const auto log = [&](const std::string& name) { return submitted ? directory + "/slurm/" + name + ".log" : ""; };
    if ((submitted && !submission->references.empty()) || fs::exists(folders.reference_run, failed))
        status.tasks.push_back(
            look.part("references", folders.reference_run, submitted ? submission->references : "", log("references")));
    for (unsigned part = 1; part <= shards; ++part) {
        const std::string number = std::to_string(part);
        status.tasks.push_back(look.part("shard " + number, folders.part(part),
                                         submitted ? submission->shards + "_" + number : "", log("shard-" + number)));
    }
    status.tasks.push_back(look.merge());
    return status;
}

}  // namespace raylex::experiments
