#include "experiments/job/passes/pass_render.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "display/services/split_mix.h"
#include "experiments/job/passes/pass_classes.h"
#include "experiments/job/passes/pass_sum.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/program/console.h"
#include "transport/render/resolve/resolved_job.h"
#include "transport/render/tiles.h"

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
    if (settings.stop.adaptive) {
        // Light that lands on any pixel has no error by pixel.
        if (!is_camera_based(pass.method, settings.paths.max_depth)) settings.stop.adaptive.reset();
        else if (pass.samples_per_pixel) apply_sample_limit(*pass.samples_per_pixel, *settings.stop.adaptive);
    }
    if (index > 0) settings.samples.seed = mix_bits(settings.samples.seed + index * golden_gamma);
    if (plan.passes.size() == 1) return settings;
    settings.channels.takes = pass.expression;
    settings.channels.list = pass.channels;
    if (pass.has_aovs) return settings;
    settings.before_preparing = nullptr;
    settings.before_rendering = nullptr;
    settings.mattes.kinds.clear();
    keep_known(settings.channels.rules, pass.channels);
    keep_known(settings.channels.layers, pass.channels);
    keep_known(settings.channels.statistics, pass.channels);
    if (pass.has_halves) settings.channels.statistics.clear();
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

/// Adds the counts of another render, but no pixels and no samples per pixel.
void add_output(RenderOutput& sum, const RenderOutput& of) {
    add_pass_statistics(sum.statistics, of.statistics);
    sum.sums.rejected += of.sums.rejected;
    sum.sums.light_magnitude += of.sums.light_magnitude;
    sum.samples.unconverged_pixels += of.samples.unconverged_pixels;
    if (of.samples.adaptive && (!sum.samples.adaptive || of.samples.adaptive->error > sum.samples.adaptive->error))
        sum.samples.adaptive = of.samples.adaptive;
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
          records_(plan.passes.size()) {}

    Result<JobOutput> run() {
        const std::size_t with_aovs = plan_.with_aovs();
        // What one pass does not support is found before another one is rendered.
        for (std::size_t i = 0; i < plan_.passes.size(); ++i) {
            const RenderSettings settings = settings_of(job_, plan_, i);
            if (auto resolved = transport::ResolvedJob::resolve(built_, settings); !resolved)
                return of_pass(i, resolved.error());
        }
        if (Status done = render(with_aovs); !done) return done.error();
        for (std::size_t i = 0; i < plan_.passes.size(); ++i) {
            if (i == with_aovs) continue;
            if (stop_ != nullptr && stop_->load()) sum_->samples.complete = false;
            else if (Status done = render(i); !done) return done.error();
            if (!images_[i])
                records_[i] = {plan_.passes[i].name, plan_.passes[i].method.type, 0, 0,
                               plan_.passes[i].name + ": not rendered"};
        }
        std::vector<PassImage> images;
        std::size_t first = 0;
        for (std::size_t i = 0; i < images_.size(); ++i) {
            if (i == with_aovs) first = images.size();
            if (images_[i]) images.push_back(std::move(*images_[i]));
        }
        JobOutput result{std::move(*sum_), std::move(records_)};
        result.output.sum = std::make_shared<PassSum>(std::move(images), first, channels_);
        return result;
    }

  private:
    [[nodiscard]] Error of_pass(std::size_t index, Error error) const {
        error.message = "the pass '" + plan_.passes[index].name + "': " + error.message;
        return error;
    }

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
        std::optional<display::FrameBuffer> half;
        auto output = plan_.passes[index].has_halves ? render_halves(settings, progress, half)
                                                     : transport::render(scene_, built_, settings, progress, stop_);
        if (!output) return of_pass(index, output.error());
        records_[index] = record_of(index, *output);
        if (plan_.passes[index].has_halves && (!half || !output->samples.complete))
            output->warnings.push_back(
                error_at({}, "the pass '" + plan_.passes[index].name +
                                 "' was stopped before both of its halves were rendered: mse, even and odd of light "
                                 "lack its noise"));
        keep(index, *std::move(output), std::move(half));
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

    /// Renders all samples, and returns those of the first half as well. The sum of the halves is exact, so the bits
    /// are those of one render.
    Result<RenderOutput> render_halves(RenderSettings settings,
                                       const std::function<void(const RenderProgress&)>& progress,
                                       std::optional<display::FrameBuffer>& half) {
        constexpr auto block = static_cast<std::uint64_t>(transport::TileGrid::block_size);
        if (!settings.samples.per_pixel) return error_at({}, "halves of a pass need a number of samples");
        const std::uint64_t all = *settings.samples.per_pixel, split = all / block / 2 * block;
        settings.samples.per_pixel = split;
        settings.samples.whole = all;  // both halves train the same guide
        auto first = transport::render(scene_, built_, settings, progress, stop_);
        if (!first || !first->samples.complete) return first;
        settings.samples.first = split;
        settings.samples.per_pixel = all;
        auto output = transport::render(scene_, built_, settings, progress, stop_);
        if (!output) return output;
        if (Status merged = output->frame_buffer.merge(first->frame_buffer); !merged) return merged.error();
        add_output(*output, *first);
        half.emplace(std::move(first->frame_buffer));
        return output;
    }

    void keep(std::size_t index, RenderOutput output, std::optional<display::FrameBuffer> half) {
        if (!sum_) channels_ = channels_of_sum(output.frame_buffer.channels(), job_);
        std::vector<display::ChannelId> position = positions_in(output.frame_buffer.channels(), channels_);
        const display::FrameBufferLayout one{.width = 1, .height = 1};
        auto empty = output.frame_buffer.like(one);
        images_[index].emplace(PassImage{std::move(output.frame_buffer), std::move(position), std::move(half)});
        if (empty) output.frame_buffer = *std::move(empty);
        if (!sum_) {
            sum_.emplace(std::move(output));
            return;
        }
        add_output(*sum_, output);
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

    [[nodiscard]] PassRecord record_of(std::size_t index, const RenderOutput& output) const {
        const PlannedPass& pass = plan_.passes[index];
        const display::PixelRegion region = output.view.crop.value_or(output.frame_buffer.whole());
        const auto pixels = static_cast<double>(region.width()) * static_cast<double>(region.height());
        const double samples = output.samples.complete && !output.samples.adaptive
                                   ? static_cast<double>(output.samples.per_pixel)
                                   : static_cast<double>(output.statistics.camera_samples) / pixels;
        PassRecord record{pass.name, output.used.integrator, samples, output.statistics.render_cpu_seconds};
        record.text = pass.name + ": " + record.method + ", " + number_text(record.samples_per_pixel, 10) +
                      " samples per pixel, " + number_text(record.cpu_seconds) + " CPU s, seed " +
                      std::to_string(output.used.seed);
        if (!output.samples.complete) record.text += ", INCOMPLETE";
        if (pass.has_aovs) record.text += ", with the AOVs";
        record.text += ", takes " + (pass.takes == pass.expression ? "" : pass.takes + " = ") + pass.expression;
        return record;
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
    std::vector<PassRecord> records_;               // [pass]
    std::vector<std::size_t> rendered_;             // in the order of rendering
    std::optional<RenderOutput> sum_;
    std::vector<ChannelDefinition> channels_;  // of the sum
};

}  // namespace

std::string JobOutput::pass_lines() const {
    std::string lines;
    for (const PassRecord& each : passes) lines += (lines.empty() ? "" : "\n") + each.text;
    return lines;
}

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
