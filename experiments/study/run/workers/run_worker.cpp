#include "experiments/study/run/workers/run_worker.h"

#include <csignal>
#include <exception>
#include <filesystem>
#include <utility>

#include "display/services/parameters.h"
#include "experiments/job/text/json.h"
#include "experiments/study/results_file.h"
#include "experiments/study/run/processes/messages.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

constexpr double seconds_to_save = 10;  // for a checkpoint, or a file that is being written

Message request_of(Operation operation, std::size_t scene = 0, std::size_t variant = 0) {
    return {{"operation", static_cast<int>(operation)}, {"scene", scene}, {"variant", variant}};
}

}  // namespace

RunWorker::RunWorker(const ExperimentConfig& config, const Plan& plan, std::string directory,
                     const std::atomic<bool>* stop, bool isolated, std::function<void()> in_process)
    : config_(config), directory_(std::move(directory)), stop_(stop) {
    const auto make = [&config, &plan, this] { return make_worker_service(config, plan, directory_, stop_); };
    if (isolated)
        process_.emplace([make, in_process = std::move(in_process)] {
            if (in_process) in_process();
            return make();
        });
    else here_ = make();
}

Result<Message> RunWorker::ask(const Message& request, double timeout, double seconds_to_stop,
                               const std::function<void(const WorkProgress&)>& progress) {
    died_ = false;
    pid_t group = 0;
    const Tell told = [&](const std::string& text) {
        const Message now = unpacked(text);
        group = now.at(3).get<pid_t>();
        if (progress) progress({now.at(0), now.at(1), now.at(2), group});
    };
    const transport::Stopwatch watch;
    std::string content;
    if (!process_) {
        content = here_(packed(request), told);
    } else {
        auto answer = process_->ask({packed(request), timeout, stop_, seconds_to_stop, told});
        if (!answer) return answer.error();
        if (!answer->death.empty()) {
            died_ = true;
            seconds_ += watch.wall();
            if (group > 0) kill(-group, SIGKILL);  // an external command that it waited for
            return error_at({}, "the worker process " + answer->death);
        }
        content = std::move(answer->content);
    }
    try {
        Message message = unpacked(content);
        seconds_ += message.at("render_seconds").get<double>();
        if (message.contains("thrown") && process_) {
            died_ = true;  // its memory is no longer reliable
            process_->end();
        }
        if (message.contains("error")) return message.at("error").get<Error>();
        return std::move(message.at("result"));
    } catch (const std::exception& error) {
        return error_at({}, std::string("a message between processes cannot be read: ") + error.what());
    }
}

Result<DescribedScene> RunWorker::describe(std::size_t scene, std::size_t variant) {
    auto answer = ask(request_of(Operation::describe, scene, variant), config_.timeout, 0, {});
    if (!answer) return answer.error();
    return DescribedScene{answer->at("info"), answer->at("partitions").get<std::vector<PartitionInfo>>()};
}

Result<std::uint64_t> RunWorker::frame_buffer_bytes(std::size_t scene, std::size_t variant) {
    auto answer = ask(request_of(Operation::frame_buffer, scene, variant), config_.timeout, 0, {});
    if (!answer) return answer.error();
    return answer->get<std::uint64_t>();
}

std::string RunWorker::reason_to_keep(std::size_t scene, std::size_t variant) {
    auto answer = ask(request_of(Operation::reason_to_keep, scene, variant), config_.timeout, 0, {});
    return answer ? answer->get<std::string>() : std::string();
}

Result<Calibration> RunWorker::calibrate(std::size_t scene, std::size_t variant) {
    auto answer = ask(request_of(Operation::calibrate, scene, variant), config_.timeout, 0, {});
    if (!answer) return answer.error();
    return answer->get<Calibration>();
}

Result<bool> RunWorker::reference(std::size_t scene, SceneInfo& info, double& seconds,
                                  const std::function<void(const WorkProgress&)>& progress) {
    Message request = request_of(Operation::reference, scene);
    request["info"] = info;
    auto answer =
        ask(request, config_.reference.timeout, config_.checkpoint_seconds > 0 ? seconds_to_save : 1, progress);
    if (!answer) {
        if (!died_) return answer.error();
        if (stopped()) return false;
        info.reference_failure = answer.error().message;
        return true;
    }
    info = answer->at("info");
    seconds += answer->at("seconds").get<double>();
    return answer->at("made").get<bool>();
}

Result<RenderedRun> RunWorker::render_run(const PlannedRun& planned, double seconds_per_sample,
                                          const std::function<void(const WorkProgress&)>& progress) {
    const MethodRequest& method = config_.methods[config_.variants[planned.variant].method];
    Message request = request_of(Operation::run, planned.scene, planned.variant);
    request["cell"] = run_message(planned.run);
    request["seconds_per_sample"] = seconds_per_sample;
    // An external command's timeout is enforced by the process that waits for it.
    auto answer = ask(request, method.command.empty() ? method.timeout : 0,
                      config_.checkpoint_seconds > 0 ? seconds_to_save : 1, progress);
    if (!answer) {
        if (!died_) return answer.error();
        if (Status s = finish_last(); !s) return s.error();
        RenderedRun outcome{planned.run};
        outcome.stopped = stopped();
        return outcome.stopped ? outcome : record_failure(directory_, std::move(outcome), answer.error(), true);
    }
    RenderedRun outcome{run_of_message(answer->at("cell"))};
    outcome.stopped = answer->at("stopped");
    outcome.relative_error = answer->at("relative_error");
    outcome.outside_seconds = answer->at("outside_seconds");
    if (!outcome.stopped && !outcome.run.failed) last_ = outcome.run;
    return outcome;
}

/// Finishes a cell whose process ended after all files were written, but before the rename.
Status RunWorker::finish_last() {
    if (!last_) return success();
    const StudyRun run = *std::exchange(last_, std::nullopt);
    std::error_code failed;
    const std::string partial = partial_directory(directory_, run.id), whole = run_directory(directory_, run.id);
    if (fs::exists(whole, failed) || !fs::exists(partial, failed)) return success();
    return close_run_directory({run, partial, whole, {checkpoint_file(partial), failed_file(directory_, run.id)}});
}

Status RunWorker::close() {
    auto answer = ask(request_of(Operation::close), 0, seconds_to_save, {});
    if (answer) return success();
    return died_ ? finish_last() : Status(answer.error());
}

}  // namespace raylex::experiments
