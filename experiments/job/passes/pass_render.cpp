#include "experiments/job/passes/pass_render.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "display/services/split_mix.h"
#include "experiments/job/passes/pass_sum.h"
#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

using display::ChannelDefinition;
using transport::RenderOutput;
using transport::RenderProgress;
using transport::RenderSettings;
using transport::RenderStatistics;

/// Keeps the requests for channels that the pass has.
template <typename Request>
void keep_known(std::vector<Request>& requests, const std::vector<ChannelDefinition>& channels) {
    std::erase_if(requests, [&](const Request& request) {
        return request.channel != "beauty" &&
               std::none_of(channels.begin(), channels.end(),
                            [&](const ChannelDefinition& each) { return each.name == request.channel; });
    });
}

RenderSettings settings_of(const Job& job, const PassPlan& plan, std::size_t index) {
    const PlannedPass& pass = plan.passes[index];
    RenderSettings settings = job.settings;
    settings.paths.integrator = pass.method;
    if (pass.samples_per_pixel) settings.samples.per_pixel = pass.samples_per_pixel;
    if (settings.stop.limit) settings.stop.limit->seconds *= pass.time_share;
    if (index > 0) settings.samples.seed = mix_bits(settings.samples.seed + index * golden_gamma);
    if (plan.passes.size() == 1) return settings;
    settings.channels.takes = pass.expression;
    settings.channels.list = pass.channels;
    if (pass.has_aovs) return settings;
    settings.before_rendering = nullptr;
    settings.mattes.kinds.clear();
    keep_known(settings.channels.rules, pass.channels);
    keep_known(settings.channels.layers, pass.channels);
    keep_known(settings.channels.statistics, pass.channels);
    return settings;
}

/// The channels of the sum: those of the pass with the AOVs, with the expressions of the job.
std::vector<ChannelDefinition> channels_of_sum(std::span<const ChannelDefinition> of_pass, const Job& job) {
    std::vector<ChannelDefinition> channels(of_pass.begin(), of_pass.end());
    const std::size_t shift = job.settings.channels.beauty ? 1 : 0;
    for (ChannelDefinition& channel : channels) {
        if (channel.name == "beauty") channel.expression = "C.*";
        for (const ChannelDefinition& known : job.settings.channels.list) {
            if (known.name != channel.name || known.style != display::ChannelStyle::expression) continue;
            channel.expression = known.expression;
            channel.rest_of = known.rest_of;
            for (std::size_t& member : channel.rest_of) member += shift;
        }
    }
    return channels;
}

void add_pass_statistics(RenderStatistics& sum, const RenderStatistics& of) {
    const auto add = [&](auto... member) { ((sum.*member += of.*member), ...); };
    using S = RenderStatistics;
    add(&S::prepare_seconds, &S::prepare_cpu_seconds, &S::pilot_rays, &S::render_seconds, &S::render_cpu_seconds,
        &S::camera_samples, &S::camera_rays, &S::scattering_rays, &S::shadow_rays, &S::discarded_samples, &S::branches,
        &S::attribution_overflow, &S::invalid_samples, &S::refused_services_calls);
    for (std::size_t i = 0; i < sum.pruned.size(); ++i) sum.pruned[i] += of.pruned[i];
    sum.path_length_histogram.resize(std::max(sum.path_length_histogram.size(), of.path_length_histogram.size()));
    for (std::size_t i = 0; i < of.path_length_histogram.size(); ++i)
        sum.path_length_histogram[i] += of.path_length_histogram[i];
}

class PassRenderer {
  public:
    PassRenderer(const Job& job, const PassPlan& plan, const transport::SceneDescription& scene,
                 const transport::BuiltScene& built, const std::function<void(const RenderProgress&)>& progress,
                 const std::atomic<bool>* stop)
        : job_(job),
          plan_(plan),
          scene_(scene),
          built_(built),
          progress_(progress),
          stop_(stop),
          images_(plan.passes.size()),
          lines_(plan.passes.size()) {}

    Result<JobOutput> run() {
        const std::size_t with_aovs = plan_.with_aovs();
        if (Status done = render(with_aovs); !done) return done.error();
        for (std::size_t i = 0; i < plan_.passes.size(); ++i) {
            if (i == with_aovs) continue;
            if (stop_ != nullptr && stop_->load()) sum_->samples.complete = false;
            else if (Status done = render(i); !done) return done.error();
            if (!images_[i]) lines_[i] = plan_.passes[i].name + ": not rendered";
        }
        std::vector<PassImage> images;
        std::size_t first = 0;
        for (std::size_t i = 0; i < images_.size(); ++i) {
            if (i == with_aovs) first = images.size();
            if (images_[i]) images.push_back(std::move(*images_[i]));
        }
        JobOutput result{std::move(*sum_), {}};
        for (const std::string& line : lines_) result.passes += (result.passes.empty() ? "" : "\n") + line;
        result.output.sum = std::make_shared<PassSum>(std::move(images), first, channels_);
        return result;
    }

  private:
    Status render(std::size_t index) {
        RenderSettings settings = settings_of(job_, plan_, index);
        if (const auto next = settings.before_rendering; next)
            settings.before_rendering = [&, next](const transport::RenderPlan& of_pass,
                                                  std::vector<display::SampleSink*>& sinks) {
                return next(plan_of_sum(of_pass), sinks);
            };
        std::vector<const PassImage*> finished;
        for (const std::size_t each : rendered_) finished.push_back(&*images_[each]);
        std::function<void(const RenderProgress&)> progress;
        if (progress_) progress = [&](const RenderProgress& now) { report(now, index, settings, finished); };
        auto output = transport::render(scene_, built_, settings, progress, stop_);
        if (!output) {
            Error error = output.error();
            error.message = "the pass '" + plan_.passes[index].name + "': " + error.message;
            return error;
        }
        lines_[index] = line_of(index, *output);
        keep(index, *std::move(output));
        rendered_.push_back(index);
        return success();
    }

    /// The plan of the pass with the AOVs, with the channels of the sum and the memory of the other passes.
    transport::RenderPlan plan_of_sum(const transport::RenderPlan& of_pass) {
        channels_ = channels_of_sum(of_pass.channels, job_);
        transport::RenderPlan all = of_pass;
        all.channels = channels_;
        const display::FrameBufferLayout layout{.width = of_pass.width, .height = of_pass.height};
        for (const PlannedPass& pass : plan_.passes) {
            if (pass.has_aovs) continue;
            std::vector<ChannelDefinition> channels = pass.channels;
            channels.push_back(channels_.front());  // the beauty
            all.memory.push_back(
                {"the pass " + pass.name, display::total_bytes(display::frame_buffer_memory(layout, channels))});
        }
        return all;
    }

    void keep(std::size_t index, RenderOutput output) {
        if (!sum_) channels_ = channels_of_sum(output.frame_buffer.channels(), job_);
        std::vector<display::ChannelId> position = positions_in(output.frame_buffer.channels(), channels_);
        // The method misses no path of the class of its pass: the plan has a proof. What it misses elsewhere is no
        // loss.
        std::erase_if(output.warnings,
                      [](const Error& warning) { return warning.message.find("missing from") != std::string::npos; });
        const display::FrameBufferLayout one{.width = 1, .height = 1};
        auto empty = output.frame_buffer.like(one);
        images_[index].emplace(PassImage{std::move(output.frame_buffer), std::move(position)});
        if (empty) output.frame_buffer = *std::move(empty);
        if (!sum_) {
            sum_.emplace(std::move(output));
            return;
        }
        add_pass_statistics(sum_->statistics, output.statistics);
        sum_->sums.rejected += output.sums.rejected;
        sum_->sums.light_magnitude += output.sums.light_magnitude;
        sum_->samples.complete = sum_->samples.complete && output.samples.complete;
        sum_->samples.per_pixel += output.samples.per_pixel;
        if (index == 0) sum_->used.seed = output.used.seed;
        sum_->used.integrator += " + " + output.used.integrator;
        for (Error& warning : output.warnings) {
            const std::string text = warning.to_string();
            const bool is_known = std::any_of(sum_->warnings.begin(), sum_->warnings.end(),
                                              [&](const Error& each) { return each.to_string() == text; });
            if (!is_known) sum_->warnings.push_back(std::move(warning));
        }
    }

    [[nodiscard]] std::string line_of(std::size_t index, const RenderOutput& output) const {
        const PlannedPass& pass = plan_.passes[index];
        std::string line = pass.name + ": " + output.used.integrator + ", " + std::to_string(output.samples.per_pixel) +
                           " samples per pixel, " + number_text(output.statistics.render_cpu_seconds) +
                           " CPU s, seed " + std::to_string(output.used.seed);
        if (!output.samples.complete) line += ", INCOMPLETE";
        if (pass.has_aovs) line += ", with the AOVs";
        return line + ", takes " + (pass.takes == pass.expression ? "" : pass.takes + " = ") + pass.expression;
    }

    /// Samples of pixel that a pass is expected to take, relative to the others.
    [[nodiscard]] double weight(std::size_t index) const {
        const auto samples = plan_.passes[index].samples_per_pixel;
        return static_cast<double>(samples ? *samples : job_.settings.samples.per_pixel.value_or(16));
    }

    void report(const RenderProgress& now, std::size_t index, const RenderSettings& settings,
                std::span<const PassImage* const> finished) {
        RenderProgress all = now;
        double rest = 0;
        for (std::size_t i = 0; i < plan_.passes.size(); ++i)
            if (i != index && std::find(rendered_.begin(), rendered_.end(), i) == rendered_.end()) rest += weight(i);
        const double scale = rest / weight(index);
        const std::uint64_t done = sum_ ? sum_->statistics.camera_samples : 0;
        all.samples_done += done;
        all.samples_total += done + static_cast<std::uint64_t>(scale * static_cast<double>(now.samples_total));
        all.seconds += sum_ ? sum_->statistics.render_seconds : 0;
        if (now.image == nullptr || !sum_) return progress_(all);
        // The ids of the running pass: the beauty and the list, as in its frame buffer.
        std::vector<ChannelDefinition> list = settings.channels.list;
        if (settings.channels.beauty) {
            list.insert(list.begin(), ChannelDefinition{});
            list.front().name = "beauty";
        }
        const LivePassSum image(finished, *now.image, positions_in(list, channels_), channels_);
        all.image = &image;
        progress_(all);
    }

    const Job& job_;
    const PassPlan& plan_;
    const transport::SceneDescription& scene_;
    const transport::BuiltScene& built_;
    const std::function<void(const RenderProgress&)>& progress_;
    const std::atomic<bool>* stop_;
    std::vector<std::optional<PassImage>> images_;  // [pass]
    std::vector<std::string> lines_;                // [pass]
    std::vector<std::size_t> rendered_;             // in the order of rendering
    std::optional<RenderOutput> sum_;
    std::vector<ChannelDefinition> channels_;  // of the sum
};

}  // namespace

Result<JobOutput> render_job(const Job& job, const PassPlan& plan, const transport::SceneDescription& scene,
                             const transport::BuiltScene& built,
                             const std::function<void(const RenderProgress&)>& progress,
                             const std::atomic<bool>* stop) {
    if (plan.passes.size() > 1) return PassRenderer(job, plan, scene, built, progress, stop).run();
    const RenderSettings settings = plan.passes.empty() ? job.settings : settings_of(job, plan, 0);
    auto output = transport::render(scene, built, settings, progress, stop);
    if (!output) return output.error();
    return JobOutput{*std::move(output), {}};
}

}  // namespace raylex::experiments
