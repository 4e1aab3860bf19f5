#include "experiments/study/run/cells/run_renderer.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>
#include <utility>

#include "display/output/atomic_file.h"
#include "display/output/reader/exr_layers.h"
#include "display/services/parameters.h"
#include "experiments/job/passes/pass_render.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/program/console.h"
#include "experiments/study/results_file.h"
#include "experiments/study/run/cells/run_files.h"
#include "experiments/study/run/cells/run_parts.h"
#include "experiments/study/run/processes/external.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// The load from other processes since construction, from /proc/stat.
class OtherLoad {
  public:
    /// Returns the fraction of all processors' time; negative if unknown. `children` is the CPU time of processes that
    /// ran for this cell.
    [[nodiscard]] double share(double children = 0) const {
        const double others = busy_seconds() - begin_ - watch_.process_cpu() - children;
        const double all = watch_.wall() * std::max(1U, std::thread::hardware_concurrency());
        return begin_ > 0 ? std::clamp(others / all, 0.0, 1.0) : -1;
    }

  private:
    /// Returns the CPU time of all processes since the machine started; 0 if unknown.
    static double busy_seconds() {
        std::ifstream file("/proc/stat");
        std::string name;
        double user = 0, nice = 0, system = 0, idle = 0, waiting = 0, interrupts = 0, soft = 0, stolen = 0;
        file >> name >> user >> nice >> system >> idle >> waiting >> interrupts >> soft >> stolen;
        return (user + nice + system + interrupts + soft + stolen) / static_cast<double>(sysconf(_SC_CLK_TCK));
    }
    transport::Stopwatch watch_;
    double begin_ = busy_seconds();
};

Status file_error(const std::string& path, const std::error_code& failed, const char* what) {
    return error_at({path, 0, 0}, std::string("cannot ") + what + ": " + failed.message());
}

/// Opens a directory for the cell's files. Of the files of an interrupted session, only the checkpoint is kept.
Status open_partial(const std::string& path) {
    std::error_code failed;
    fs::create_directories(path, failed);
    if (failed) return file_error(path, failed, "make this directory");
    std::vector<fs::path> left;
    for (const fs::directory_entry& each : fs::directory_iterator(path, failed))
        if (each.path() != fs::path(checkpoint_file(path))) left.push_back(each.path());
    for (const fs::path& each : left) fs::remove_all(each, failed);
    return success();
}

std::optional<transport::CheckpointSettings> checkpoints(const ExperimentConfig& config, const std::string& partial,
                                                         bool possible) {
    if (config.checkpoint_seconds <= 0 || !possible) return std::nullopt;
    transport::CheckpointSettings settings;
    settings.file = checkpoint_file(partial);
    settings.seconds = config.checkpoint_seconds;
    std::error_code failed;
    settings.resume = fs::exists(settings.file, failed);
    return settings;
}

std::function<void(const transport::RenderProgress&)> forward(const WorkContext& context) {
    return [&context](const transport::RenderProgress& now) {
        if (!context.progress) return;
        const auto total = static_cast<double>(std::max<std::uint64_t>(now.samples_total, 1));
        const bool known = now.adaptive != nullptr && !now.adaptive->channel.empty();
        context.progress({std::min(1.0, static_cast<double>(now.samples_done) / total), now.seconds,
                          known ? now.adaptive->error : -1});
    };
}

/// Translates a budget into settings of the render.
void apply_budget(const StudyRun& run, double seconds_per_sample, RenderOrder& order) {
    order.seed = run.seed;
    switch (run.budget_kind) {
        case BudgetKind::samples:
            order.samples = run.part_of.empty() ? static_cast<std::uint64_t>(run.budget) : run.end_sample;
            order.first_sample = run.first_sample;
            order.whole = static_cast<std::uint64_t>(run.budget);
            break;
        case BudgetKind::seconds:
            order.limit = transport::SampleLimit{.seconds = run.budget, .seconds_per_sample = seconds_per_sample};
            break;
        case BudgetKind::error:
            order.limit = transport::SampleLimit{.seconds_per_sample = seconds_per_sample, .error = run.budget};
            break;
    }
}

/// Renders with checkpoints if possible. Some integrators, and filter mode splat, have none; an interruption then loses
/// the whole cell.
Result<Rendered> render_saved(const WorkContext& context, RenderOrder order, const std::string& partial) {
    const Variant& variant = context.config.variants[order.variant];
    const transport::RenderSettings& settings = variant.render;
    order.checkpoint = checkpoints(context.config, partial, !settings.film.splat && variant.passes.empty());
    auto rendered = context.scenes.render(order, forward(context), context.stop);
    if (rendered || !order.checkpoint || order.checkpoint->resume) return rendered;
    if (rendered.error().message.find("checkpoint") == std::string::npos) return rendered;
    order.checkpoint.reset();
    return context.scenes.render(order, forward(context), context.stop);
}

std::map<std::string, std::string> attributes_of(const WorkContext& context, const Rendered& rendered,
                                                 const std::string& id) {
    const std::vector<std::string> command{"raylex", "experiment", "replay",         context.config.file,
                                           id,       "-o",         context.directory};
    std::map<std::string, std::string> attributes = header_attributes(rendered.job, rendered.output, command, "");
    attributes.erase("raylex/color_config");
    attributes["raylex/experiment"] = context.config.name + " " + context.config.hash;
    attributes["raylex/cell"] = id;
    if (!rendered.pass_lines.empty()) attributes[passes_attribute] = rendered.pass_lines;
    return attributes;
}

void take_results(const Rendered& rendered, StudyRun& run) {
    const transport::RenderOutput& output = rendered.output;
    const transport::RenderStatistics& statistics = output.statistics;
    run.samples_per_pixel = output.samples.per_pixel - run.first_sample;
    run.phases = rendered.phases;
    run.wall_seconds = rendered.seconds;
    run.cpu_seconds = rendered.cpu_seconds;
    run.guide_samples = statistics.guide.repeated();
    run.rays = statistics.camera_rays + statistics.scattering_rays + statistics.shadow_rays;
    run.invalid_samples = statistics.invalid_samples;
    run.peak_memory_bytes = rendered.peak_memory_bytes;
    run.isa = output.used.isa;
    run.threads = static_cast<unsigned>(output.used.threads);
    run.warnings = rendered.warnings;
    run.omits = rendered.omits;
    run.passes = rendered.passes;
    if (run.invalid_samples > 0)
        run.warnings.push_back(
            std::to_string(run.invalid_samples) +
            " contributions or values were not finite; they are missing from beauty and layers alike");
}

Result<RenderedRun> fail_run(const WorkContext& context, RenderedRun outcome, const Error& error) {
    return record_failure(context.directory, std::move(outcome), error, false);
}

Result<RenderedRun> close_run(const WorkContext& context, RenderedRun outcome, const std::string& partial) {
    StudyRun& run = outcome.run;
    run.directory = run_directory(context.directory, run.id);
    if (Status s = context.closer->close(
            {run, partial, run.directory, {checkpoint_file(partial), failed_file(context.directory, run.id)}});
        !s)
        return s.error();
    return outcome;
}

/// Returns the values of the placeholders in the command of a cell.
NamedValues places_of(const WorkContext& context, const PlannedRun& planned, const StudyRun& run,
                      const StudyScene& scene, const std::string& image) {
    const int threads = context.config.base.settings.machine.threads;
    NamedValues places{
        {"scene", fs::absolute(context.config.scenes[planned.scene].job.scene_file).string()},
        {"scene_name", run.scene},
        {"seed", std::to_string(short_seed(run.seed))},
        {"spp", number_text(run.budget, 10)},
        {"seconds", number_text(run.budget, 10)},
        {"out", image},
        {"width", std::to_string(scene.width)},
        {"height", std::to_string(scene.height)},
        {"threads", std::to_string(threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency()))}};
    places.insert(places.end(), run.settings.begin(), run.settings.end());
    return places;
}

Result<RenderedRun> run_external(const WorkContext& context, const PlannedRun& planned, RenderedRun outcome,
                                 const std::string& partial) {
    const MethodRequest& method = context.config.methods[context.config.variants[planned.variant].method];
    StudyRun& run = outcome.run;
    auto scene = context.scenes.scene(planned.scene);
    if (!scene) return fail_run(context, std::move(outcome), scene.error());
    const std::string image = fs::absolute(partial).string() + "/image.exr";
    std::error_code ignored;
    fs::remove(image, ignored);
    auto filled = fill_command(method.command, places_of(context, planned, run, **scene, image), method.location);
    if (!filled) return fail_run(context, std::move(outcome), filled.error());
    const std::string& command = filled->text;
    const OtherLoad others;
    auto process = run_process(
        *filled, fs::absolute(fs::path(context.config.file)).parent_path().string(),
        fs::absolute(partial).string() + "/log.txt", method.timeout, context.stop, [&](double seconds, int group) {
            if (context.progress)
                context.progress({run.budget_kind == BudgetKind::seconds ? std::min(1.0, seconds / run.budget) : 0,
                                  seconds, -1, group});
        });
    if (!process) return fail_run(context, std::move(outcome), process.error());
    outcome.outside_seconds = process->wall_seconds;
    if (process->stopped) {
        outcome.stopped = true;
        return outcome;
    }
    run.other_load = others.share(process->cpu_seconds);
    run.phases = {{"process", process->wall_seconds, process->cpu_seconds}};
    run.wall_seconds = process->wall_seconds;
    run.cpu_seconds = process->cpu_seconds;
    run.peak_memory_bytes = process->peak_memory_bytes;
    if (run.budget_kind == BudgetKind::samples) run.samples_per_pixel = static_cast<std::uint64_t>(run.budget);
    const std::string said =
        process->last_words.empty() ? "; it printed nothing" : "; its last output: " + process->last_words;
    if (process->timed_out)
        return fail_run(context, std::move(outcome),
                        error_at(method.location,
                                 "method '" + method.name + "' was ended after its timeout of " +
                                     duration_text(method.timeout) + said,
                                 command));
    if (process->exit_code != 0)
        return fail_run(context, std::move(outcome),
                        error_at(method.location,
                                 "the command of method '" + method.name + "' ended with exit code " +
                                     std::to_string(process->exit_code) + said,
                                 command));
    if (!fs::exists(image, ignored))
        return fail_run(
            context, std::move(outcome),
            error_at(method.location, "the command of method '" + method.name + "' wrote no image to {out}" + said,
                     command));
    auto channels = context.scenes.channels(planned.scene, planned.variant);
    if (!channels) return fail_run(context, std::move(outcome), channels.error());
    auto absent = write_image_files(partial, image, (*scene)->width, (*scene)->height, channel_infos(**channels));
    if (!absent) return fail_run(context, std::move(outcome), absent.error());
    if (!absent->empty())
        run.warnings.push_back("the images of method '" + method.name + "' have no layers named " +
                               display::list_names(*absent) + "; these channels are not measured for this method");
    return close_run(context, std::move(outcome), partial);
}

}  // namespace

std::string checkpoint_file(const std::string& partial) {
    return partial + "/render.checkpoint";
}

Result<RenderedRun> record_failure(const std::string& results, RenderedRun outcome, const Error& reason,
                                   bool keep_checkpoint) {
    outcome.run.failed = true;
    outcome.run.failure = reason.to_string();
    std::error_code ignored;
    const std::string partial = partial_directory(results, outcome.run.id);
    fs::create_directories(results + "/failed", ignored);
    if (keep_checkpoint && fs::exists(checkpoint_file(partial), ignored)) static_cast<void>(open_partial(partial));
    else fs::remove_all(partial, ignored);
    if (Status s = write_run_file(failed_file(results, outcome.run.id), outcome.run); !s) return s.error();
    return outcome;
}

Result<RenderedRun> render_run(const WorkContext& context, const PlannedRun& planned, double seconds_per_sample) {
    RenderedRun outcome{planned.run};
    outcome.run.machine = host_description();
    const std::string partial = partial_directory(context.directory, planned.run.id);
    if (Status s = open_partial(partial); !s) return s.error();
    const Variant& variant = context.config.variants[planned.variant];
    if (!context.config.methods[variant.method].command.empty())
        return run_external(context, planned, std::move(outcome), partial);
    RenderOrder order{.scene = planned.scene, .variant = planned.variant, .beside = context.closer};
    apply_budget(planned.run, seconds_per_sample, order);
    const OtherLoad others;
    auto rendered = render_saved(context, order, partial);
    if (!rendered) {
        // A checkpoint that does not match may contain valuable work, so the user decides.
        if (rendered.error().file == checkpoint_file(partial)) return rendered.error();
        return fail_run(context, std::move(outcome), rendered.error());
    }
    if (!rendered->output.samples.complete) {
        if (context.stop == nullptr || !context.stop->load())
            return fail_run(context, std::move(outcome),
                            error_at({},
                                     "the time budget ended before every pixel had a sample; expected more time, or "
                                     "shorter paths by max_depth"));
        outcome.stopped = true;
        return outcome;
    }
    outcome.run.other_load = others.share();
    take_results(*rendered, outcome.run);
    const transport::Stopwatch writing;
    auto scene = context.scenes.scene(planned.scene, variant.effects);
    if (!scene) return scene.error();
    if (const std::string& whole = planned.run.part_of; !whole.empty()) {
        const auto attributes = attributes_of(context, *rendered, whole);
        if (Status s = write_part_record(partial, *rendered, *(*scene)->loaded, attributes); !s) return s.error();
    } else {
        auto splits = write_render_files(partial, *rendered, *(*scene)->loaded,
                                         attributes_of(context, *rendered, planned.run.id));
        if (!splits) return splits.error();
        outcome.run.splits = std::move(*splits);
    }
    outcome.relative_error = relative_error(rendered->output);
    outcome.run.phases.push_back({"write", writing.wall(), writing.process_cpu()});
    return close_run(context, std::move(outcome), partial);
}

Result<Rendered> render_again(const WorkContext& context, const PlannedRun& planned, const StudyRun& done) {
    RenderOrder order{
        .scene = planned.scene, .variant = planned.variant, .samples = done.samples_per_pixel, .seed = done.seed};
    if (done.budget_kind != BudgetKind::samples) order.guide_samples = done.guide_samples;
    return context.scenes.render(order, forward(context), context.stop);
}

}  // namespace raylex::experiments
