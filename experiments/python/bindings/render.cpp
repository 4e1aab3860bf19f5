// raylex.render: reads a job like the program, runs the program's steps from scene to image, and calls a callback
// meanwhile.
#include <pybind11/stl.h>

#include <map>
#include <optional>

#include "display/output/writer/exr_writer.h"
#include "display/output/writer/memory_image.h"
#include "experiments/cli/render/render_outputs.h"
#include "experiments/job/channels/channel_plan.h"
#include "experiments/job/channels/scene_path_strings.h"
#include "experiments/job/job_file.h"
#include "experiments/job/passes/pass_render.h"
#include "experiments/job/rendering/job_scene.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/job/settings/setting.h"
#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/call_scope.h"
#include "experiments/python/bindings/image.h"
#include "experiments/python/bindings/run_control.h"
#include "experiments/python/bindings/scenes/scene.h"
#include "transport/plugins/plugin_loader.h"

namespace raylex::python {

using namespace pybind11::literals;

thread_local std::shared_ptr<RunControl> RunControl::current_;

namespace {

using transport::RenderProgress;

/// The argument of a progress callback. Arrays are made on request, only during the call.
class Progress : public CallScope {
  public:
    Progress(const RenderProgress& now, const std::vector<display::ChannelDefinition>& channels,
             display::ChannelId beauty, display::PixelRegion whole)
        : CallScope("this progress is no longer valid; it can be used only during the callback"),
          now_(now),
          channels_(channels),
          beauty_(beauty),
          whole_(whole) {}

    [[nodiscard]] double fraction() const {
        const auto total = static_cast<double>(std::max<std::uint64_t>(now().samples_total, 1));
        return std::min(static_cast<double>(now().samples_done) / total, 1.0);
    }
    [[nodiscard]] std::uint64_t samples() const { return now().samples_done; }
    [[nodiscard]] double seconds() const { return now().seconds; }

    [[nodiscard]] py::array_t<double> image(const std::string& name) const {
        const display::ChannelId id = find(name);
        std::vector<double> values = unlocked(*this, [&] { return now().image->resolve(id, whole_); });
        return shaped(std::move(values), id);
    }
    [[nodiscard]] py::array_t<double> standard_error(const std::string& name) const {
        const display::ChannelId id = find(name);
        std::vector<double> values = unlocked(*this, [&] {
            std::vector<double> variance = now().image->resolve_variance_of_mean(id, whole_);
            for (double& each : variance) each = std::sqrt(each);
            return variance;
        });
        if (values.empty())
            fail("'" + name + "' keeps no statistics, so its error is unknown; expected the beauty, or a channel of " +
                 "statistics={name: ['mse']}, and a method whose samples belong to pixels");
        return shaped(std::move(values), id);
    }

  private:
    [[nodiscard]] const RenderProgress& now() const {
        check();
        if (now_.image == nullptr) fail("no sample is finished yet, so there is no image");
        return now_;
    }
    [[nodiscard]] display::ChannelId find(const std::string& name) const {
        check();
        std::vector<std::string> names;
        for (std::size_t i = 0; i < channels_.size(); ++i) {
            const auto id = static_cast<display::ChannelId>(i);
            names.push_back(id == beauty_ ? "beauty" : channels_[i].name);
            if (names.back() == name) return id;
        }
        fail("no layer '" + name + "' is being rendered", near_miss(name, names));
    }
    [[nodiscard]] py::array_t<double> shaped(std::vector<double> values, display::ChannelId id) const {
        const int components = display::component_count(channels_[static_cast<std::size_t>(id)].type);
        std::vector<py::ssize_t> shape{whole_.height(), whole_.width()};
        if (components != 1) shape.push_back(components);
        return owning_array(std::move(values), std::move(shape));
    }
    const RenderProgress& now_;
    const std::vector<display::ChannelDefinition>& channels_;
    display::ChannelId beauty_;
    display::PixelRegion whole_;
};

/// One render, from the text of its job to its image. The results needed to write a file later are kept.
class JobRender {
  public:
    JobRender(const std::string& text, const Scene* scene, std::vector<std::string> arguments)
        : arguments_(std::move(arguments)), job_(take(experiments::parse_job(text, "render()"))) {
        for (const experiments::PluginRequest& plugin : job_.plugins)
            take(transport::load_plugin(plugin.file, plugin.location));
        if (scene != nullptr) scene_ = *scene;
        if (job_.checkpoint_seconds > 0)
            fail(
                "only the program writes checkpoints; expected `raylex render --checkpoint` for renders that must "
                "survive a crash");
        if (!job_.statistics.empty()) fail("only the program supports 'stats'; expected Image.statistics");
    }

    void prepare() {
        take(experiments::begin_passes(job_));
        loaded_ = scene_ ? take(experiments::prepare_job_scene(job_, labelled(*scene_)))
                         : take(experiments::load_job_scene(job_));
        job_.settings.identity = experiments::checkpoint_identity(job_, loaded_->color);
        warnings_ = loaded_->warnings;
        experiments::ask_for_film_layers(loaded_->scene.film, job_);
        if (const auto ignored = experiments::ask_for_film_clamp(loaded_->scene, job_)) warnings_.push_back(*ignored);
        built_ = take(transport::BuiltScene::build(loaded_->scene, job_.settings.machine));
        const experiments::ScenePathStrings words =
            take(experiments::scene_path_strings(job_, loaded_->scene, built_.get()));
        experiments::ChannelPlan plan = take(experiments::plan_channels(job_, words));
        if (!plan.refuted.empty()) fail(plan.refuted, "nothing was rendered");
        take(experiments::add_denoiser_inputs(words, plan, job_));
        passes_ = take(experiments::plan_passes(job_, loaded_->scene, words, plan));
        if (!passes_.refuted.empty()) fail(passes_.refuted, "nothing was rendered");
        warnings_.insert(warnings_.end(), passes_.notes.begin(), passes_.notes.end());
        if (!job_.settings.channels.beauty && plan.channels.empty())
            fail("beauty=False leaves nothing to render; expected at least one of lpe= or aovs= as well");
        warnings_.insert(warnings_.end(), plan.notes.begin(), plan.notes.end());
        job_.settings.channels.list = std::move(plan.channels);
        take(outputs_.atlas().prepare(job_, words));
        partitions_ = std::move(plan.partitions);
        take(experiments::check_exr_requests(job_.outputs));
        take(outputs_.make(job_, loaded_->color));
    }

    void render(RunControl& control, const py::object& callback) {
        job_.settings.before_rendering = [&](const transport::RenderPlan& plan,
                                             std::vector<display::SampleSink*>& sinks) {
            channels_.assign(plan.channels.begin(), plan.channels.end());
            beauty_ = plan.beauty;
            whole_ = {0, 0, plan.width, plan.height};
            return outputs_.begin(plan, sinks, loaded_->primaries, partitions_);
        };
        const auto progress = [&](const RenderProgress& now) {
            outputs_.update(now);
            if (callback && !control.failed()) report(now, control, callback);
        };
        auto output = experiments::render_job(job_, passes_, loaded_->scene, *built_, progress, &control.stop_flag());
        job_.settings.before_rendering = nullptr;
        experiments::JobOutput rendered = take(std::move(output));
        output_.emplace(std::move(rendered.output));
        pass_records_ = rendered.pass_lines();
        for (const Error& warning : output_->warnings) warnings_.push_back(warning.to_string());
    }

    /// Returns nothing if no sample was finished.
    std::shared_ptr<Image> image(const std::shared_ptr<JobRender>& self) {
        if (output_->statistics.camera_samples == 0) return nullptr;
        std::map<std::string, std::string> attributes =
            experiments::header_attributes(job_, *output_, arguments_, loaded_->color.description);
        if (!pass_records_.empty()) attributes[experiments::passes_attribute] = pass_records_;
        description_ = experiments::image_description(job_, *loaded_, *output_, partitions_, attributes);
        auto image = std::make_shared<Image>(
            display::image_in_memory(outputs_.filtered(output_->image()), output_->beauty, description_));
        if (job_.outputs.denoise) image = denoised(*image, experiments::denoise_options(job_));
        take(outputs_.close(*output_, description_));
        for (std::string& warning : outputs_.take_warnings()) warnings_.push_back(std::move(warning));
        image->warnings = warnings_;
        image->complete = output_->samples.complete;
        image->statistics = statistics();
        image->write = [self](const std::string& path) { return self->write(path); };
        return image;
    }

  private:
    void report(const RenderProgress& now, RunControl& control, const py::object& callback) const {
        const Callback locked;
        try {
            const auto progress = std::make_shared<Progress>(now, channels_, beauty_, whole_);
            const std::unique_ptr<Progress, void (*)(Progress*)> ends(progress.get(), [](Progress* p) { p->end(); });
            const py::object answer = callback(progress);
            if (!answer.is_none() && !py::bool_(answer)) control.stop();
        } catch (...) { control.fail_with_current(); }
    }

    [[nodiscard]] std::map<std::string, double> statistics() const {
        const transport::RenderStatistics& of = output_->statistics;
        const auto number = [](std::uint64_t value) { return static_cast<double>(value); };
        return {{"samples_per_pixel", number(output_->samples.per_pixel)},
                {"seed", number(output_->used.seed)},
                {"threads", output_->used.threads},
                {"build_seconds", of.build_seconds},
                {"seconds", of.render_seconds},
                {"cpu_seconds", of.render_cpu_seconds},
                {"camera_samples", number(of.camera_samples)},
                {"camera_rays", number(of.camera_rays)},
                {"scattering_rays", number(of.scattering_rays)},
                {"shadow_rays", number(of.shadow_rays)},
                {"invalid_samples", number(of.invalid_samples)}};
    }

    [[nodiscard]] Status write(const std::string& path) const {
        Status written = display::write_exr(path, outputs_.filtered(output_->image()), output_->beauty, description_);
        if (!written || !job_.outputs.denoise) return written;
        const auto denoised = display::denoise_exr(path, path, experiments::denoise_options(job_));
        return denoised ? success() : Status(denoised.error());
    }

    std::vector<std::string> arguments_;
    experiments::Job job_;
    std::optional<Scene> scene_;
    std::unique_ptr<experiments::JobScene> loaded_;
    std::shared_ptr<const transport::BuiltScene> built_;
    experiments::PassPlan passes_;
    std::string pass_records_;
    std::vector<display::PartitionDeclaration> partitions_;
    experiments::RenderOutputs outputs_;
    std::vector<display::ChannelDefinition> channels_;
    display::ChannelId beauty_ = display::invalid_channel;
    display::PixelRegion whole_;
    std::optional<transport::RenderOutput> output_;
    display::ImageDescription description_;
    std::vector<std::string> warnings_;
};

/// Throws a callback's exception on, with the image rendered so far as its attribute `image`.
void rethrow_with(const RunControl& control, const std::shared_ptr<Image>& image) {
    try {
        control.rethrow();
    } catch (const py::error_already_set& exception) {
        if (image) exception.value().attr("image") = py::cast(image);
        throw;
    }
}

std::shared_ptr<Image> render(const std::string& text, const Scene* scene, const py::object& callback) {
    const auto arguments = py::module_::import("sys").attr("argv").cast<std::vector<std::string>>();
    const auto control = std::make_shared<RunControl>();
    const py::object call = callback.is_none() ? py::object() : callback;
    std::shared_ptr<JobRender> job;
    std::shared_ptr<Image> image;
    try {
        image = watched(control, [&] {
            job = std::make_shared<JobRender>(text, scene, arguments);
            job->prepare();
            job->render(*control, call);
            return job->image(job);
        });
    } catch (const Failure&) {
        rethrow_with(*control, nullptr);  // a callback's exception is the cause of the failure
        throw;
    }
    rethrow_with(*control, image);
    if (!image) fail("the render was stopped before any sample was finished");
    return image;
}

/// Returns (argument of render(), key of a job, help) of every setting with a Python name.
std::vector<std::tuple<std::string, std::string, std::string>> settings() {
    std::vector<std::tuple<std::string, std::string, std::string>> rows;
    for (const experiments::SettingGroup& group : experiments::setting_groups())
        for (const experiments::RenderSetting& each : group.settings)
            if (!each.python.empty()) rows.emplace_back(each.python, each.key, each.text());
    return rows;
}

}  // namespace

void add_render(py::module_& module) {
    module.def("_settings", &settings);
    py::class_<Progress, std::shared_ptr<Progress>>(module, "Progress",
                                                    "A running render; valid only during the callback.")
        .def_property_readonly("fraction", &Progress::fraction, "0 to 1")
        .def_property_readonly("samples", &Progress::samples, "camera samples so far")
        .def_property_readonly("seconds", &Progress::seconds, "wall time since rendering began")
        .def("image", &Progress::image, "name"_a = "beauty",
             "The layer from the samples so far: float64 (height, width, components).")
        .def("standard_error", &Progress::standard_error, "name"_a = "beauty",
             "The standard error of each pixel of the layer, in the layer's unit: float64, of the layer's shape.");
    module.def("_render", &render, "job"_a, "scene"_a, "progress"_a);
}

}  // namespace raylex::python
