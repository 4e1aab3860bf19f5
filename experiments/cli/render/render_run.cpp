#include "experiments/cli/render/render_run.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "display/output/atomic_file.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "display/output/writer/exr_writer.h"
#include "experiments/atlas/merged_atlas.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/loading_line.h"
#include "experiments/cli/render/progress.h"
#include "experiments/cli/render/render_outputs.h"
#include "experiments/cli/render/render_summary.h"
#include "experiments/cli/render/rescue.h"
#include "experiments/job/channels/channel_plan.h"
#include "experiments/job/passes/pass_render.h"
#include "experiments/job/rendering/effect_report.h"
#include "experiments/job/rendering/job_scene.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/job/rendering/statistics.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/interrupt.h"
#include "experiments/program/tint.h"
#include "experiments/program/work_lock.h"
#include "experiments/report/guide/guide_view.h"
#include "experiments/shards/shard_render.h"
#include "lpe/algebra/wording/event_words.h"
#include "transport/render/built_scene.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// The steps of one render, in order. A step returns nothing if the render continues, or the exit code if it ends.
class RenderRun {
  public:
    RenderRun(Job job, const std::vector<std::string>& arguments) : job_(std::move(job)), arguments_(arguments) {}

    int run() {
        at_once_.emplace("raylex: interrupted before anything was rendered; no file was written\n");
        for (const Status& possible : {check_guide_only(job_), begin_passes(job_)})
            if (!possible) return report_error(possible.error());
        if (job_.shard) return run_shard();
        if (job_.settings.samples.only || job_.guide_only) {
            for (std::optional<int> (RenderRun::*step)() : {&RenderRun::load, &RenderRun::build, &RenderRun::plan})
                if (const std::optional<int> code = (this->*step)()) return *code;
            return job_.guide_only ? render().value_or(exit_holds) : replay();
        }
        for (std::optional<int> (RenderRun::*step)() :
             {&RenderRun::lock_checkpoint, &RenderRun::check_outputs, &RenderRun::load, &RenderRun::build,
              &RenderRun::plan, &RenderRun::render, &RenderRun::write_image, &RenderRun::run_checks,
              &RenderRun::write_statistics})
            if (const std::optional<int> code = (this->*step)()) return *code;
        print_summary({job_, *output_, image_, splits_, deep_, atlas_, beauties_, outputs_.files(), phases_});
        if (!output_->samples.complete) return interrupt_flag().load() ? exit_interrupted : exit_does_not_hold;
        if ((deep_ && !deep_->holds) || (atlas_ && !atlas_->holds)) return exit_does_not_hold;
        const auto holds = [](const display::SplitResult& each) { return each.holds; };
        return std::all_of(splits_.begin(), splits_.end(), holds) ? exit_holds : exit_does_not_hold;
    }

    /// Estimates the cost of all samples.
    std::optional<int> estimate(bool calibrate, RenderEstimate& estimate) {
        quiet_ = true;
        if (Status possible = begin_passes(job_); !possible) return report_error(possible.error());
        for (std::optional<int> (RenderRun::*step)() : {&RenderRun::load, &RenderRun::build, &RenderRun::plan})
            if (const std::optional<int> code = (this->*step)()) return code;
        if (Status possible = check_shardable(job_, loaded_->scene); !possible) return report_error(possible.error());
        auto samples = samples_of_job(job_, loaded_->scene);
        if (!samples) return report_error(samples.error());
        estimate.samples_per_pixel = *samples;
        const std::uint64_t most_memory = job_.settings.buckets ? job_.settings.buckets->memory : 0;
        // an image that does not fit into memory is not test-rendered either
        calibrate = calibrate && !job_.settings.buckets;
        job_.settings.buckets.reset();
        if (Status possible = transport::check_render(*built_, job_.settings); !possible)
            return report_error(possible.error());
        job_.settings.paths.guide_file.clear();  // it has the guide of all samples
        constexpr double seconds = 2;
        job_.settings.stop.limit = transport::SampleLimit{.seconds = seconds};
        double pixels = 0;
        std::uint64_t image_bytes = 0;
        job_.settings.before_rendering = [&](const transport::RenderPlan& plan, std::vector<display::SampleSink*>&) {
            pixels = static_cast<double>(plan.crop.width()) * static_cast<double>(plan.crop.height());
            image_bytes = display::total_bytes(plan.memory) / 2;  // the plan counts the image twice, once for its limit
            return calibrate ? success() : Status(error_at({}, "nothing is rendered"));
        };
        const auto output = transport::render(loaded_->scene, *built_, job_.settings, {}, &interrupt_flag());
        if (interrupt_flag().load()) return exit_interrupted;
        if (!output && pixels == 0) return report_error(output.error());
        // Resident memory, plus copies of the image: the image and its copy for the limit, and a checkpoint or record.
        estimate.memory_bytes = peak_memory_bytes() + (output ? 1 : 3) * image_bytes;
        if (most_memory > 0) estimate.memory_bytes = std::min(estimate.memory_bytes, most_memory);
        if (!output || output->statistics.camera_samples == 0) return go_on;
        estimate.cpu_seconds = output->statistics.render_cpu_seconds * pixels * static_cast<double>(*samples) /
                               static_cast<double>(output->statistics.camera_samples);
        return go_on;
    }

  private:
    using Step = std::optional<int>;
    static constexpr std::nullopt_t go_on = std::nullopt;

    /// Renders one shard of the samples and writes the record of their sums.
    int run_shard() {
        for (std::optional<int> (RenderRun::*step)() :
             {&RenderRun::check_outputs, &RenderRun::lock_shard, &RenderRun::load, &RenderRun::begin_shard,
              &RenderRun::build, &RenderRun::plan, &RenderRun::render, &RenderRun::write_shard,
              &RenderRun::write_statistics})
            if (const std::optional<int> code = (this->*step)()) return *code;
        const transport::RenderStatistics& statistics = output_->statistics;
        print_line(shard_->record() + ": " + shard_->text() + ", " + duration_text(statistics.render_seconds) + " (" +
                   duration_text(statistics.render_cpu_seconds) + " CPU)");
        return exit_holds;
    }

    void warn(const std::string& message) {
        print_warning(message);
        warnings_.push_back(message);
    }

    /// Checks before the render that all output files can be written.
    Step check_outputs() {
        take_standard_output_for(job_.statistics);
        if (fs::path(job_.output).extension() != ".exr")
            return report_error("the output '" + job_.output + "' does not end in .exr; expected an OpenEXR file name");
        if (Status recovery = check_recovery(job_); !recovery) return report_error(recovery.error());
        if (Status fits = check_exr_requests(job_.outputs); !fits) return report_error(fits.error());
        if (job_.resume && !job_.shard)
            for (const std::string& path : {job_.output, checkpoint_file(job_)}) display::remove_abandoned(path);
        std::vector<std::string> taken{job_.scene_file, job_.job_file, job_.settings.paths.guide_file};
        for (const std::string& path : requested_files(job_)) {
            if (is_standard_output(path))
                return report_error("an image cannot be written to standard output, '-'; expected a file name");
            for (const std::string& other : taken) {
                std::error_code failed;
                if (!other.empty() && (path == other || fs::equivalent(path, other, failed)))
                    return report_error("'" + path +
                                        "' is already an input or another output; expected a different file");
            }
            taken.push_back(path);
            Status writable = display::check_writable(path);
            if (!writable) return report_error(writable.error());
        }
        return go_on;
    }

    Step load() {
        const PhaseClock clock;
        LoadingLine loading;
        auto loaded = load_job_scene(job_, loading.progress());
        loading.finish();
        if (!loaded) return report_error(loaded.error());
        loaded_ = std::move(*loaded);
        job_.settings.identity = checkpoint_identity(job_, loaded_->color);
        job_.settings.paths.guide_view = !job_.statistics.empty() && !job_.guide_only;
        ask_for_film_layers(loaded_->scene.film, job_);
        if (const auto ignored = ask_for_film_clamp(loaded_->scene, job_)) warn(*ignored);
        for (const std::string& warning : loaded_->warnings) warn(warning);
        if (!quiet_)
            for (const std::string& line : job_.show_effects ? effect_table(loaded_->effects, job_.effects)
                                                             : effect_summary(loaded_->effects, job_.effects))
                print_line(line);
        if (!job_.settings.samples.only)
            if (Status made = outputs_.make(job_, loaded_->color); !made) return report_error(made.error());
        phases_["load"] = clock.elapsed();
        return interrupted_early();
    }

    /// Builds the scene once. The plan and the render share its tables, so no image or grid is read twice.
    Step build() {
        LoadingLine loading;
        auto built = transport::BuiltScene::build(loaded_->scene, job_.settings.machine, loading.progress());
        loading.finish();
        if (!built) return report_error(built.error());
        built_ = std::move(*built);
        return interrupted_early();
    }

    /// Locks the checkpoint, so that no checkpoint of another running process is resumed or replaced.
    Step lock_checkpoint() {
        if (job_.checkpoint_seconds == 0 && !job_.settings.buckets) return go_on;
        auto lock = WorkLock::take(checkpoint_file(job_) + ".lock", "is rendering this image");
        if (!lock) return report_error(lock.error());
        lock_.emplace(*std::move(lock));
        return go_on;
    }

    Step lock_shard() {
        auto lock = WorkLock::take(shard_lock(job_.shard->record), "is rendering this shard");
        if (!lock) return report_error(lock.error());
        lock_.emplace(*std::move(lock));
        return go_on;
    }

    Step begin_shard() {
        if (!job_.preview.empty() || !job_.outputs.drivers.empty())
            print_note(
                "previews and viewers need whole images and are left out; 'raylex preview' shows the merged image");
        auto shard = ShardRender::make(job_, loaded_->scene);
        if (!shard) return report_error(shard.error());
        shard_ = *std::move(shard);
        return go_on;
    }

    /// Ends the render before a ray is traced if the record of this shard exists.
    Status look_for_record(const transport::RenderPlan& plan) {
        std::string warning;
        auto done = shard_->is_done(plan, warning);
        if (!done) return done.error();
        if (!warning.empty()) warn(warning);
        shard_is_done_ = *done;
        return *done ? Status(error_at({}, "this shard is done")) : success();
    }

    Step plan() {
        const PhaseClock clock;
        auto words = scene_path_strings(job_, loaded_->scene, built_.get());
        if (!words) return report_error(words.error());
        auto plan = plan_channels(job_, *words);
        if (!plan) return report_error(plan.error());
        if (Status added = add_denoiser_inputs(*words, *plan, job_); !added) return report_error(added.error());
        for (const std::string& note : plan->notes) warn(note);
        if (!plan->refuted.empty()) return report_refuted(plan->refuted);
        auto passes = plan_passes(job_, loaded_->scene, *words, *plan);
        if (!passes) return report_error(passes.error());
        passes_ = *std::move(passes);
        for (const std::string& note : passes_.notes) print_note(note);
        if (!passes_.refuted.empty()) return report_refuted(passes_.refuted);
        warn_of_single_samples();
        if (!job_.settings.channels.beauty && plan->channels.empty())
            return report_error("--no-beauty leaves nothing to render; expected at least one --lpe or --aov as well");
        job_.settings.channels.list = plan->channels;
        if (!quiet_)
            for (const std::string& line :
                 job_.show_effects ? aov_table(job_.settings.channels.list) : aov_summary(job_.settings.channels.list))
                print_line(line);
        if (!job_.settings.samples.only)
            if (Status atlas = outputs_.atlas().prepare(job_, *words); !atlas) return report_error(atlas.error());
        partitions_ = plan->partitions;
        beauties_ = plan->beauties;
        phases_["plan"] = clock.elapsed();
        return interrupted_early();
    }

    static int report_refuted(const std::string& refuted) {
        std::fprintf(stderr, "raylex: %s\nNothing was rendered.\n", refuted.c_str());
        return exit_does_not_hold;
    }

    /// Warns of layers of statistics that contain only zeros.
    void warn_of_single_samples() {
        const auto samples = samples_of_job(job_, loaded_->scene);
        if (!samples || *samples > 1) return;
        for (const display::StatisticRequest& request : job_.settings.channels.statistics)
            if (request.statistic != display::Statistic::even)
                warn("the variance of one sample per pixel is unknown: the layer '" + request.channel + "_" +
                     display::statistic_name(request.statistic) + "' will be black; expected --spp of at least 2");
    }

    /// Handles Ctrl-C before the first sample, when there is nothing to write.
    static Step interrupted_early() {
        if (!interrupt_flag().load()) return go_on;
        std::fprintf(stderr, "raylex: interrupted before anything was rendered; no file was written\n");
        return exit_interrupted;
    }

    /// Removes the checkpoint. Call it only after all files are written.
    void remove_checkpoint() {
        if (!output_->samples.complete || (job_.checkpoint_seconds == 0 && !output_->buckets.image)) return;
        const Status removed = output_->buckets.image ? transport::remove_buckets(checkpoint_file(job_))
                                                      : display::remove_file(checkpoint_file(job_));
        if (!removed) warn(removed.error().to_string());
        output_->buckets.image.reset();  // frees the band in memory before the file is read
    }

    Step render() {
        request_checkpoints(job_);
        Progress progress;
        std::size_t warned = 0;  // warnings before the render
        if (shard_)
            job_.settings.before_preparing = [&](const transport::RenderPlan& plan) { return look_for_record(plan); };
        job_.settings.before_rendering = [&](const transport::RenderPlan& plan,
                                             std::vector<display::SampleSink*>& sinks) {
            at_once_.reset();
            for (const Error& warning : plan.warnings) warn(warning.to_string());
            warned = plan.warnings.size();
            if (job_.guide_only) return Status(error_at({}, "the guide is ready"));
            progress.begin(plan);
            Status begun = outputs_.begin(plan, sinks, loaded_->primaries, partitions_);
            if (begun) print_memory(outputs_, job_.outputs.memory_limit);
            return begun;
        };
        auto output = render_job(
            job_, passes_, loaded_->scene, *built_,
            [&](const transport::RenderProgress& now) {
                progress.update(now);
                outputs_.update(now);
            },
            &interrupt_flag());
        progress.finish();
        for (const std::string& warning : outputs_.take_warnings()) warn(warning);
        if (job_.guide_only && !at_once_) {
            if (!fs::exists(job_.settings.paths.guide_file)) return exit_does_not_hold;  // a warning has the reason
            print_line(job_.settings.paths.guide_file + ": what the training found for this render");
            return exit_holds;
        }
        if (shard_is_done_) {
            print_line(shard_->record() + ": " + shard_->text() + " is done already");
            return exit_holds;
        }
        if (!output) return report_error(output.error());
        pass_records_ = output->pass_lines();
        output_.emplace(std::move(output->output));
        for (std::size_t i = warned; i < output_->warnings.size(); ++i) warn(output_->warnings[i].to_string());
        const transport::RenderStatistics& statistics = output_->statistics;
        phases_["build"] = {statistics.build_seconds, statistics.build_cpu_seconds};
        phases_["prepare"] = {statistics.prepare_seconds, statistics.prepare_cpu_seconds};
        phases_["render"] = {statistics.render_seconds, statistics.render_cpu_seconds};
        if (statistics.invalid_samples > 0) warn(text_of_invalid(job_, *output_, arguments_));
        if (!output_->samples.complete && statistics.camera_samples == 0) {
            if (interrupt_flag().load()) return interrupted_early();
            print_warning(
                "the time ended before any sample was finished; no file was written. Expected more time, or shorter "
                "paths by --max-depth");
            return exit_does_not_hold;
        }
        return go_on;
    }

    /// Renders one sample of one pixel and prints it; writes no file. Returns exit code 1 if a value is rejected.
    int replay() {
        const transport::SampleChoice& only = *job_.settings.samples.only;
        auto output = transport::render(loaded_->scene, *built_, job_.settings, {}, &interrupt_flag());
        if (!output) return report_error(output.error());
        const transport::RenderStatistics& statistics = output->statistics;
        const std::span<const display::ChannelDefinition> channels = output->frame_buffer.channels();
        print_line("pixel (" + std::to_string(only.x) + ", " + std::to_string(only.y) + "), sample " +
                   std::to_string(only.sample) + ", seed " + std::to_string(output->used.seed) + ": " +
                   std::to_string(statistics.invalid_samples) + " contributions or values rejected");
        const auto triple = [](double r, double g, double b) {
            return "(" + number_text(r) + ", " + number_text(g) + ", " + number_text(b) + ")";
        };
        for (const display::InvalidSample& each : statistics.invalid_log)
            print_line("  refused: " + triple(each.value.r, each.value.g, each.value.b) +
                       (each.channel >= 0 ? " for " + channels[static_cast<std::size_t>(each.channel)].name : ""));
        const bool inside = only.x >= 0 && only.y >= 0 && only.x < output->view.width && only.y < output->view.height;
        for (std::size_t i = 0; inside && i < channels.size(); ++i) {
            const std::vector<double> value = output->frame_buffer.resolve(static_cast<display::ChannelId>(i),
                                                                           {only.x, only.y, only.x + 1, only.y + 1});
            print_line("  " + channels[i].name + ": " +
                       (value.size() == 3 ? triple(value[0], value[1], value[2]) : number_text(value[0])));
        }
        return statistics.invalid_samples > 0 ? exit_does_not_hold : exit_holds;
    }

    /// Returns the description that goes into the file or the record.
    display::ImageDescription describe_image() {
        attributes_ = header_attributes(job_, *output_, arguments_, loaded_->color.description);
        if (!pass_records_.empty()) attributes_[passes_attribute] = pass_records_;
        if (!beauties_.empty()) attributes_["raylex/is_beauty"] = lpe::joined_by(beauties_, ", ");
        if (!loaded_->color.texture_spaces->empty())
            attributes_["raylex/texture_spaces"] = *loaded_->color.texture_spaces;
        return image_description(job_, *loaded_, *output_, partitions_, attributes_);
    }

    int report_unwritten(Error error) const {
        std::error_code failed;
        if ((job_.checkpoint_seconds > 0 || output_->buckets.image) && fs::exists(checkpoint_file(job_), failed))
            error.hint += "\n" + checkpoint_file(job_) + (job_.shard ? ": the same command" : ": --resume") +
                          " continues from here";
        return report_error(error);
    }

    Step write_shard() {
        const PhaseClock clock;
        if (!output_->samples.complete) {
            print_line(shard_->record() + ": " + shard_->text() +
                       ", INTERRUPTED; the same command continues from here");
            return exit_interrupted;
        }
        const display::ImageDescription description = describe_image();
        // The record is written last: its presence means that the shard is complete.
        const ShardRange& range = shard_->range();
        const auto write = [&](const std::string& path) {
            return shard_->write(path, *output_, description, job_.outputs.filters);
        };
        Status written = outputs_.atlas().write(*output_, of_samples(description, range.first, range.end));
        if (written) written = write(shard_->record());
        if (!written)
            return report_unwritten(rescued(written.error(), "the record of the shard", shard_->record(), write));
        remove_checkpoint();
        phases_["write"] = clock.elapsed();
        return go_on;
    }

    Step write_image() {
        const PhaseClock clock;
        const display::ImageDescription description = describe_image();
        Status written = outputs_.close(*output_, description);
        for (const std::string& warning : outputs_.take_warnings()) warn(warning);
        if (!written) return report_unwritten(written.error());
        remove_checkpoint();
        for (const std::string& line : outputs_.denoised()) print_line(line);
        phases_["write"] = clock.elapsed();
        return go_on;
    }

    /// Checks the file as read back from disk, not the buffers it was written from. After an interrupt the user waits,
    /// and reading takes as long as writing, so the results stored in the header are used instead.
    Step run_checks() {
        auto file = display::ExrBands::open(job_.output);
        if (!file) return report_error(file.error());
        image_ = file->image();
        if (const std::string repaired = repaired_text(image_.attributes); !repaired.empty()) warn(repaired);
        if (!output_->samples.complete && interrupt_flag().load()) return go_on;
        if (!image_.partitions.empty()) {
            auto results = display::check_declared_splits(*file);
            if (!results) return report_error(results.error());
            splits_ = std::move(*results);
        }
        if (outputs_.deep() != nullptr) {
            auto pixels = display::read_exr(job_.output);
            if (!pixels) return report_error(pixels.error());
            image_ = *std::move(pixels);
        }
        auto deep = outputs_.report_deep_check(image_);
        if (!deep) return report_error(deep.error());
        deep_ = std::move(*deep);
        auto atlas = outputs_.atlas().run_checks();
        if (!atlas) return report_error(atlas.error());
        atlas_ = *atlas;
        return go_on;
    }

    Step write_statistics() {
        if (job_.statistics.empty()) return go_on;
        RunRecord record{&job_,   &*output_,   arguments_,        phases_,         warnings_,
                         splits_, attributes_, outputs_.memory(), outputs_.deep(), loaded_->effects};
        if (const auto& view = output_->statistics.guide_view; view && !is_standard_output(job_.statistics))
            record.guide_view = guide_view_json(*view);
        Status written = write_text(job_.statistics, statistics_json(record));
        if (!written) return report_error(written.error());
        return go_on;
    }

    Job job_;
    const std::vector<std::string>& arguments_;
    // defers interrupts: up to before_rendering() they end the program, after it they wait for the image
    const InterruptsWait wait_;
    std::optional<InterruptsAtOnce> at_once_;
    std::unique_ptr<JobScene> loaded_;
    std::shared_ptr<const transport::BuiltScene> built_;
    std::vector<display::PartitionDeclaration> partitions_;
    std::vector<std::string> beauties_;
    PassPlan passes_;
    std::string pass_records_;
    RenderOutputs outputs_;
    std::optional<WorkLock> lock_;
    std::optional<ShardRender> shard_;
    bool shard_is_done_ = false, quiet_ = false;
    std::optional<transport::RenderOutput> output_;
    std::optional<display::DeepCheck> deep_;
    std::optional<display::AtlasCheck> atlas_;
    display::ExrImage image_;  // has pixels only if a deep image is compared with them
    std::vector<display::SplitResult> splits_;
    std::map<std::string, PhaseTime> phases_;
    std::map<std::string, std::string> attributes_;
    std::vector<std::string> warnings_;
};

}  // namespace

std::optional<int> estimate_render(Job job, const std::vector<std::string>& arguments, bool calibrate,
                                   RenderEstimate& estimate) {
    install_interrupt_handler();
    return RenderRun(std::move(job), arguments).estimate(calibrate, estimate);
}

int run_render(Job job, const std::vector<std::string>& arguments) {
    install_interrupt_handler();
    return RenderRun(std::move(job), arguments).run();
}

}  // namespace raylex::experiments
