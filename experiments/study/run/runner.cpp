#include "experiments/study/run/runner.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <thread>

#include "display/services/parameters.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/program/console.h"
#include "experiments/study/results_file.h"
#include "experiments/study/run/cells/method_settings.h"
#include "experiments/study/run/cells/run_parts.h"
#include "experiments/study/run/results_state.h"
#include "experiments/study/run/run_marks.h"
#include "experiments/study/run/run_progress.h"
#include "experiments/study/run/workers/estimates.h"
#include "experiments/study/run/workers/run_worker.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

NamedValues provenance(const ExperimentConfig& config) {
    const unsigned cores = std::thread::hardware_concurrency();
    const int threads = config.base.settings.machine.threads;
    double load = 0;
    if (getloadavg(&load, 1) != 1) load = 0;  // as on an idle machine
    return {{"version", raylex_version()},
            {"revision", raylex_revision()},
            {"compiler", build_description()},
            {"machine", host_description()},
            {"cores", std::to_string(cores)},
            {"threads", std::to_string(threads > 0 ? static_cast<unsigned>(threads) : cores)},
            {"load average at the start", number_text(load)},
            {"started", utc_time()},
            {"seed", std::to_string(config.seed)}};
}

class Run {
  public:
    Run(const ExperimentConfig& config, const RunRequest& request, const std::atomic<bool>* stop)
        : config_(config),
          request_(request),
          stop_(stop),
          worker_(config, plan_, request.directory, stop, request.isolated, [this] { lock_.leave_to_parent(); }),
          estimates_(config) {}

    Result<RunOutcome> run() {
        for (Status (Run::*step)() :
             {&Run::open, &Run::describe, &Run::warm_up, &Run::make_references, &Run::run_all}) {
            if (Status s = (this->*step)(); !s) return s.error();
            if (stopped()) break;
        }
        return finish();
    }

  private:
    [[nodiscard]] bool stopped() const { return stop_ != nullptr && stop_->load(); }
    Status open() {
        auto plan = make_plan(config_);
        if (!plan) return plan.error();
        plan_ = std::move(*plan);
        work_ = split_runs(
            config_, plan_,
            [this](std::size_t scene, std::size_t variant) { return worker_.reason_to_keep(scene, variant); },
            request_.shard.split_runs);
        auto earlier = earlier_results(config_, request_, work_);
        if (!earlier) return earlier.error();
        earlier_ = std::move(*earlier);
        std::error_code failed;
        fs::create_directories(request_.directory + "/cells", failed);
        if (failed) return directory_error(request_.directory, "cannot make this directory: " + failed.message());
        const std::string shard = request_.shard.parts > 1 ? "-" + std::to_string(request_.shard.part) : std::string();
        if (Status s = lock_.take(request_.directory, ".running" + shard); !s) return s;
        if (earlier_)
            if (Status s = set_damaged_aside(*earlier_); !s) return s;
        for (const auto* notes : {&plan_.notes, &work_.notes})
            for (const std::string& note : *notes) print_note(note);
        return success();
    }

    /// Fills in experiment.json except for the references.
    Status describe() {
        experiment_.name = config_.name;
        experiment_.directory = request_.directory;
        experiment_.config_text = config_.text;
        experiment_.config_hash = config_.hash;
        experiment_.config_file = fs::absolute(config_.file).lexically_normal().string();
        experiment_.overrides = config_.overrides;
        experiment_.provenance = earlier_ ? earlier_->provenance : provenance(config_);
        experiment_.cpu_clock = config_.cpu_clock;
        experiment_.regions = config_.regions;
        for (Region& region : experiment_.regions)
            if (!region.mask_file.empty())
                region.mask_file = fs::absolute(region.mask_file).lexically_normal().string();
        if (earlier_) {
            experiment_.time = earlier_->time;
            for (const auto& [name, value] : provenance(config_))
                for (const auto& [known, before] : experiment_.provenance)
                    if (known == name && before != value && (name == "revision" || name == "machine"))
                        print_warning("earlier results have another " + name + ": " + before +
                                      "; times are not comparable");
        }
        for (const PlannedRun& each : plan_.runs) experiment_.planned.push_back(each.run);
        for (const MethodRequest& each : config_.methods) {
            std::string integrator = each.settings.paths.integrator ? each.settings.paths.integrator->type : "";
            for (const PassRequest& pass : each.passes)
                integrator += (integrator.empty() ? "" : " + ") + pass.method.type;
            experiment_.methods.push_back({each.name, integrator, each.command, each.unbiased,
                                           settings_text(each.settings, each.effects, each.passes)});
        }
        bool any_died = false;
        for (std::size_t i = 0; i < config_.scenes.size(); ++i) {
            if (Status s = describe_scene(i); !s) return s;
            any_died = any_died || worker_.died();
            if (!stopped()) continue;
            experiment_.scenes.clear();  // so that an incomplete description does not overwrite a complete one
            return success();
        }
        // An error in all scenes, such as in a channel, should be fixed before anything is rendered.
        if (broken_.size() == config_.scenes.size() && !any_died && !earlier_) return broken_.begin()->second;
        for (const auto& [index, error] : broken_)
            print_warning("scene '" + config_.scenes[index].name +
                          "' fails, so all its cells fail: " + error.to_string());
        return write_experiment_files(experiment_);
    }

    Status describe_scene(std::size_t index) {
        const auto planned = std::find_if(plan_.runs.begin(), plan_.runs.end(),
                                          [&](const PlannedRun& each) { return each.scene == index; });
        SceneInfo info;
        info.name = config_.scenes[index].name;
        info.file = fs::absolute(config_.scenes[index].job.scene_file).lexically_normal().string();
        auto facts = worker_.describe(index, planned != plan_.runs.end() ? planned->variant : 0);
        if (!facts) {
            if (!stopped()) broken_.emplace(index, facts.error());
            if (earlier_)
                for (const SceneInfo& known : earlier_->scenes)
                    if (known.name == info.name) info = known;
            experiment_.scenes.push_back(std::move(info));
            return success();
        }
        info.hash = facts->info.hash;
        info.width = facts->info.width;
        info.height = facts->info.height;
        info.channels = facts->info.channels;
        if (earlier_)
            for (const SceneInfo& known : earlier_->scenes)
                if (known.name == info.name && !known.hash.empty() &&
                    (known.hash != info.hash || known.width != info.width || known.height != info.height))
                    return error_at(config_.scenes[index].location,
                                    "scene '" + info.name + "' has changed since the results in '" +
                                        request_.directory + "' were started",
                                    "choose another directory with -o, or restore the scene's files");
        if (earlier_)  // until it is found or made again
            for (const SceneInfo& known : earlier_->scenes)
                if (known.name == info.name) {
                    info.reference = known.reference;
                    info.reference_method = known.reference_method;
                    info.reference_samples = known.reference_samples;
                    info.reference_relative_error = known.reference_relative_error;
                }
        for (PartitionInfo& each : facts->partitions) {
            const bool known = std::any_of(experiment_.partitions.begin(), experiment_.partitions.end(),
                                           [&](const PartitionInfo& other) { return other.name == each.name; });
            if (!known) experiment_.partitions.push_back(std::move(each));
        }
        experiment_.scenes.push_back(std::move(info));
        return success();
    }

    Status warm_up() {
        // Finished work is not measured again.
        if (earlier_ && earlier_->missing.empty() && !request_.retry) return success();
        // A shard does no work that every other shard would do too, except to measure times.
        if (request_.begin && !measures_seconds()) return success();
        const double rendered = worker_.seconds();
        std::set<std::size_t> skips;
        for (const auto& [scene, error] : broken_) skips.insert(scene);
        for (const std::string& each : estimates_.calibrate(worker_, plan_, skips, stop_)) warn(each, "");
        warm_up_ = worker_.seconds() - rendered;
        return success();
    }

    [[nodiscard]] bool measures_seconds() const {
        if (request_.only_references) return false;
        return std::any_of(work_.items.begin(), work_.items.end(), [&](const PlannedRun& each) {
            return each.run.budget_kind == BudgetKind::seconds &&
                   request_.shard.has(static_cast<std::size_t>(&each - work_.items.data()));
        });
    }

    Status make_references() {
        for (std::size_t i = 0; i < experiment_.scenes.size(); ++i) {
            const bool wanted = std::any_of(work_.items.begin(), work_.items.end(), [&](const PlannedRun& each) {
                return each.scene == i && request_.shard.has(static_cast<std::size_t>(&each - work_.items.data()));
            });
            if (!wanted || broken_.contains(i)) continue;
            SceneInfo& info = experiment_.scenes[i];
            progress_.begin("reference of " + info.name, -1, 0);
            double seconds = 0;
            const double rendered = worker_.seconds();
            auto made = worker_.reference(i, info, seconds, draw());
            if (!made) return made.error();
            references_ += seconds;
            reference_render_ += worker_.seconds() - rendered;
            if (stopped() || !*made) return success();
            if (!info.reference_failure.empty()) {
                ++references_failed_;
                progress_.line("reference of " + info.name + ": FAILED: " + info.reference_failure);
            }
            if (info.reference.empty()) continue;
            std::string text = "reference of " + info.name + ": " + info.reference_method;
            if (info.reference_samples > 0) text += ", " + std::to_string(info.reference_samples) + " spp";
            if (info.reference_relative_error >= 0)
                text += ", error " + number_text(100 * info.reference_relative_error, 2) + " %";
            progress_.line(text + (seconds > 0 ? ", " + duration_text(seconds) : ", known"));
        }
        return write_experiment_files(experiment_);
    }

    [[nodiscard]] bool is_settled(const StudyRun& cell) const {
        return settled_.contains(cell.id) || settled_.contains(cell.part_of);
    }

    Status run_all() {
        if (request_.only_references) return success();
        if (earlier_)
            for (const auto* list : {&earlier_->runs, &earlier_->parts})
                for (const StudyRun& each : *list)
                    if (!each.failed || !request_.retry) settled_.insert(each.id);
        for (std::size_t i = 0; i < work_.items.size(); ++i) {
            const PlannedRun& planned = work_.items[i];
            if (!request_.shard.has(i) || is_settled(planned.run)) continue;
            const std::string title =
                "[" + std::to_string(i + 1) + "/" + std::to_string(work_.items.size()) + "] " + planned.run.id;
            expect(i + 1);
            progress_.begin(title, left_seconds_, left_unknown_);
            const auto broken = broken_.find(planned.scene);
            auto outcome = broken != broken_.end()
                               ? record_failure(request_.directory, {planned.run}, broken->second, true)
                               : worker_.render_run(planned, estimates_.seconds_per_sample(planned), draw());
            if (!outcome) return outcome.error();
            outside_ += outcome->outside_seconds;
            if (outcome->stopped) return success();
            estimates_.learn(planned, outcome->run, outcome->relative_error);
            settled_.insert(planned.run.id);
            report(title, *outcome);
            if (stopped()) return success();
        }
        return success();
    }

    /// Updates the estimate of the remaining cells. For long plans this happens about once a second, so that its cost
    /// is negligible.
    void expect(std::size_t from) {
        constexpr std::size_t short_plan = 2000;
        if (work_.items.size() > short_plan && expected_.wall() < 1 && left_seconds_ >= 0) return;
        expected_ = transport::Stopwatch();
        left_seconds_ = 0;
        left_unknown_ = 0;
        for (std::size_t i = from; i < work_.items.size(); ++i) {
            if (!request_.shard.has(i) || is_settled(work_.items[i].run)) continue;
            const auto seconds = estimates_.seconds(work_.items[i]);
            if (seconds) left_seconds_ += *seconds;
            else ++left_unknown_;
        }
    }

    [[nodiscard]] std::function<void(const WorkProgress&)> draw() {
        return [this](const WorkProgress& now) { progress_.update(now); };
    }

    /// Prints each warning once, with the first cell that has it.
    void warn(const std::string& text, const std::string& id) {
        if (++warnings_[text] == 1) progress_.line("warning: " + (id.empty() ? "" : id + ": ") + text);
    }

    void report(const std::string& title, const RenderedRun& outcome) {
        const StudyRun& cell = outcome.run;
        for (const std::string& each : cell.warnings) warn(each, cell.id);
        if (cell.failed) {
            progress_.line(title + ": FAILED: " + cell.failure);
            return;
        }
        std::string text = title + ": ";
        if (cell.samples_per_pixel > 0) text += std::to_string(cell.samples_per_pixel) + " spp, ";
        text += duration_text(cell.wall_seconds) + " (" + duration_text(cell.cpu_seconds) + " CPU)";
        if (outcome.relative_error >= 0) text += ", error " + number_text(100 * outcome.relative_error, 2) + " %";
        for (const PartitionResult& each : cell.splits)
            if (!each.holds)
                text +=
                    "; split '" + each.partition + "' DOES NOT HOLD (" + number_text(each.worst_relative_error) + ")";
        const bool last = left_seconds_ <= 0 && left_unknown_ == 0;
        progress_.line(text + (last ? "" : "; " + time_left_text(left_seconds_, left_unknown_) + " left"));
    }

    Result<RunOutcome> finish() {
        if (Status s = worker_.close(); !s) return s.error();
        RunnerTime& time = experiment_.time;
        time.total += total_.wall();
        time.references += references_;
        time.warm_up += warm_up_;
        time.render += worker_.seconds() - reference_render_ - warm_up_ + outside_;
        if (!experiment_.scenes.empty())
            if (Status s = write_experiment_files(experiment_); !s) return s.error();
        RunOutcome outcome;
        outcome.interrupted = stopped();
        auto results = read_experiment(request_.directory);
        if (!results) return outcome.interrupted ? Result<RunOutcome>(outcome) : Result<RunOutcome>(results.error());
        for (const StudyRun& each : results->runs) {
            ++(each.failed ? outcome.failed : outcome.done);
            outcome.splits_broken += static_cast<std::size_t>(std::any_of(
                each.splits.begin(), each.splits.end(), [](const PartitionResult& split) { return !split.holds; }));
        }
        for (const StudyRun& each : results->parts) ++(each.failed ? outcome.failed : outcome.parts);
        outcome.left = results->missing.size();
        outcome.references_failed = references_failed_;
        summarise(*results, outcome);
        return outcome;
    }

    void summarise(const Experiment& results, const RunOutcome& outcome) {
        progress_.line(request_.directory + ": " + std::to_string(outcome.done) + " of " +
                       counted(plan_.runs.size(), "cell") + " done" +
                       (outcome.parts > 0 ? ", " + counted(outcome.parts, "part of a cell", "parts of cells") : "") +
                       (outcome.failed > 0 ? ", " + std::to_string(outcome.failed) + " FAILED" : "") +
                       (outcome.left > 0 ? ", " + std::to_string(outcome.left) + " not run yet" : ""));
        for (const auto* list : {&results.runs, &results.parts})
            for (const StudyRun& each : *list)
                if (each.failed) progress_.line("  failed: " + each.id + ": " + each.failure);
        if (outcome.splits_broken > 0)
            progress_.line("  " + counted(outcome.splits_broken, "cell has", "cells have") +
                           " a split that does not sum to what it splits");
        if (const std::string load = results.load_warning(); !load.empty()) progress_.line("  warning: " + load);
        const RunnerTime& time = results.time;
        if (time.render > 0)
            progress_.line("  " + duration_text(time.render) + " of rendering, " + duration_text(time.warm_up) +
                           " of warm-up, " + duration_text(time.references) + " for references; runner overhead " +
                           duration_text(time.overhead()) + ": " +
                           (time.overhead_percent() < 100 ? number_text(time.overhead_percent(), 2)
                                                          : std::to_string(std::lround(time.overhead_percent()))) +
                           " % of render time");
        if (outcome.parts > 0)
            progress_.line("  'raylex experiment merge' combines the parts into cells when all exist");
        else if (outcome.left > 0 && request_.shard.parts == 1)
            progress_.line("  'raylex experiment resume' with the same config and directory continues from here");
    }

    const ExperimentConfig& config_;
    const RunRequest& request_;
    const std::atomic<bool>* stop_;
    transport::Stopwatch total_, expected_;
    DirectoryLock lock_;
    Plan plan_;
    WorkList work_;
    RunWorker worker_;
    Estimates estimates_;
    RunProgress progress_{request_.quiet};
    std::map<std::size_t, Error> broken_;          // scenes that cannot be rendered
    std::map<std::string, std::size_t> warnings_;  // with their counts
    std::size_t references_failed_ = 0;
    std::optional<Experiment> earlier_;
    Experiment experiment_;
    std::set<std::string> settled_;
    double references_ = 0, reference_render_ = 0, warm_up_ = 0, outside_ = 0;
    double left_seconds_ = -1;
    std::size_t left_unknown_ = 0;
};

}  // namespace

Result<Shard> parse_shard(const std::string& text, const SourceLocation& where) {
    Shard shard;
    const char* at = text.data();
    const char* const end = at + text.size();
    const auto [slash, no_part] = std::from_chars(at, end, shard.part);
    if (no_part == std::errc() && slash != end && *slash == '/') {
        const auto [last, no_parts] = std::from_chars(slash + 1, end, shard.parts);
        if (no_parts == std::errc() && last == end && shard.part >= 1 && shard.part <= shard.parts) return shard;
    }
    return error_at(where,
                    "'" + text + "' is not a shard; expected PART/PARTS, such as 2/4, with PART from 1 to PARTS");
}

Result<RunOutcome> run_experiment(const ExperimentConfig& config, const RunRequest& request,
                                  const std::atomic<bool>* stop) {
    return Run(config, request, stop).run();
}

}  // namespace raylex::experiments
