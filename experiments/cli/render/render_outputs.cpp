#include "experiments/cli/render/render_outputs.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "display/output/atomic_file.h"
#include "display/output/writer/exr_writer.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/render/rescue.h"
#include "experiments/program/console.h"
#include "experiments/report/denoised_text.h"
#include "experiments/report/png_driver.h"

namespace raylex::experiments {
namespace {

std::string file_of(const display::DriverRequest& request) {
    for (const Parameter& parameter : request.parameters.parameters)
        if (parameter.name == "file" && parameter.strings.size() == 1) return parameter.strings.front();
    return {};
}

display::DriverRequest main_image(const Job& job) {
    display::DriverRequest request{"exr", {}};
    Parameter& file = request.parameters.parameters.emplace_back();
    file.name = "file";
    file.type = ParameterType::string;
    file.strings = {job.output};
    return request;
}

}  // namespace

/// Prints the memory of the layers. Layers of equal size share a line; the largest come first.
void print_memory(const RenderOutputs& outputs, std::uint64_t limit) {
    const std::vector<display::MemoryItem>& items = outputs.memory();
    const std::size_t layers = outputs.layers();
    std::map<std::uint64_t, std::vector<std::string>, std::greater<>> by_size;
    for (const display::MemoryItem& item : items)
        // layers of statistics are counted with their source layers
        if (item.bytes > 0) by_size[item.bytes].push_back(item.name);
    std::string line = "memory: " + display::memory_text(display::total_bytes(items)) + " for " +
                       std::to_string(layers) + (layers == 1 ? " layer" : " layers");
    if (limit > 0) line += ", of at most " + display::memory_text(limit);
    print_line(line);
    if (outputs.buckets() > 0)
        print_line("  for a bucket of " + std::to_string(outputs.bucket_rows()) + " rows, one of " +
                   std::to_string(outputs.buckets()));
    for (const auto& [bytes, names] : by_size) {
        std::string list;
        for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
        print_line("  " + display::memory_text(bytes) + (names.size() > 1 ? " each: " : ": ") + list);
    }
}

std::vector<std::string> requested_files(const Job& job) {
    const std::string statistics = is_standard_output(job.statistics) ? std::string() : job.statistics;
    std::vector<std::string> files;
    if (job.shard) {
        files = {job.shard->record, statistics};
    } else {
        files = {job.output, job.preview, statistics, job.outputs.deep.file, job.outputs.atlas.file};
        for (const display::DriverRequest& request : job.outputs.drivers) files.push_back(file_of(request));
    }
    std::erase_if(files, [](const std::string& file) { return file.empty(); });
    return files;
}

Status RenderOutputs::make(const Job& job, const ColorSetup& color) {
    job_ = &job;
    register_png_driver();
    const display::DriverContext context{color.manager ? &*color.manager : nullptr, job.display, job.view,
                                         job.exposure};
    std::vector<display::DriverRequest> requests;
    if (job.shard) return success();
    if (!job.output.empty()) requests.push_back(main_image(job));
    if (!job.preview.empty()) requests.push_back(preview_request(job.preview, {"--preview", 0, 0}));
    requests.insert(requests.end(), job.outputs.drivers.begin(), job.outputs.drivers.end());
    for (const display::DriverRequest& request : requests) {
        auto driver = display::make_display_driver(request.name, request.parameters, context);
        if (!driver) return driver.error();
        drivers_.add(std::move(*driver));
    }
    return success();
}

Status RenderOutputs::make_deep(const transport::RenderPlan& plan) {
    const DeepRequest& request = job_->outputs.deep;
    if (request.file.empty()) return success();
    if (plan.filter->has_negative_lobes())
        return error_at(request.location, "pixel filter '" + plan.filter->name() +
                                              "' has negative lobes, and deep samples cannot have negative alpha; "
                                              "expected box, triangle, gaussian or blackman-harris");
    if (plan.splat)
        return error_at(request.location,
                        "a deep image needs samples that belong to one pixel, and filter mode splat shares samples "
                        "between pixels; expected filter mode importance");
    if (plan.raster)
        return error_at(request.location,
                        "a deep image needs samples that belong to one pixel, and light paths of this integrator reach "
                        "any pixel; expected another integrator, such as path");
    std::vector<display::ChannelId> chosen;
    if (plan.beauty >= 0) chosen.push_back(plan.beauty);
    std::vector<std::string> names;
    std::string list;
    for (const display::ChannelDefinition& channel : plan.channels) {
        names.push_back(channel.name);
        list += (list.empty() ? "" : ", ") + channel.name;
    }
    for (const std::string& name : request.channels) {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end()) {
            return error_at(
                request.location,
                "the deep image names the channel '" + name + "', which does not exist; expected one of: " + list,
                near_miss(name, names));
        }
        const auto id = static_cast<display::ChannelId>(found - names.begin());
        if (std::find(chosen.begin(), chosen.end(), id) == chosen.end()) chosen.push_back(id);
    }
    if (chosen.empty())
        return error_at(request.location,
                        "the deep image has no channel; expected channels by --deep-channels, or a beauty");
    if (Status fits = display::DeepBuffer::check(plan.channels, chosen, request.options); !fits) {
        Error error = fits.error();
        error.file = request.location.file;
        error.line = request.location.line;
        return error;
    }
    deep_ = std::make_unique<display::DeepBuffer>(plan.width, plan.height, plan.channels, chosen, request.options);
    return display::check_writable(request.file);
}

namespace {

constexpr const char* with_buckets = " with a render in buckets (--memory, --bucket-rows): ";
constexpr const char* without_it = "leave it out, or render without buckets";

Error live_viewer_in_buckets() {
    return error_at({},
                    std::string("a live viewer") + with_buckets + "it can request any part of the image at any time",
                    without_it);
}

}  // namespace

/// Refuses outputs that need the whole image at once if only one bucket of it is in memory.
Status RenderOutputs::check_buckets(const transport::RenderPlan& plan) {
    buckets_ = plan.buckets;
    bucket_rows_ = plan.bucket_rows;
    if (plan.buckets == 0) return success();
    const std::string why = with_buckets;
    if (!job_->outputs.deep.file.empty())
        return error_at(job_->outputs.deep.location,
                        "a deep image" + why + "its samples are kept in memory for the whole image", without_it);
    if (!job_->outputs.atlas.file.empty())
        return error_at(job_->outputs.atlas.location,
                        "a path atlas" + why + "its path strings are kept in memory for the whole image", without_it);
    if (std::any_of(job_->outputs.drivers.begin(), job_->outputs.drivers.end(),
                    [](const display::DriverRequest& each) { return each.name == "tev"; }))
        return live_viewer_in_buckets();
    return success();
}

Status RenderOutputs::begin(const transport::RenderPlan& plan, std::vector<display::SampleSink*>& sinks,
                            const display::Chromaticities& primaries,
                            std::vector<display::PartitionDeclaration>& partitions) {
    channels_.assign(plan.channels.begin(), plan.channels.end());
    layout_.width = plan.width;
    layout_.height = plan.height;
    for (const ObjectRequest& request : job_->outputs.filters) {
        auto filter = display::make_display_filter(request.name, request.parameters, {channels_, plan.beauty});
        if (!filter) return filter.error();
        filters_.push_back(std::move(*filter));
    }
    if (Status buckets = check_buckets(plan); !buckets) return buckets;
    drop_altered(plan, partitions);
    memory_ = plan.memory;
    if (Status deep = make_deep(plan); !deep) return deep;
    if (Status atlas = atlas_.make(*job_, plan); !atlas) return atlas;
    if (atlas_.buffer() != nullptr) memory_.push_back({"atlas", atlas_.buffer()->expected_bytes()});
    if (deep_) memory_.push_back({"deep", deep_->expected_bytes()});
    const std::string in_buckets =
        plan.buckets == 0 ? "--memory SIZE renders it in buckets and saves each finished bucket" : "";
    if (Status fits = display::check_memory(memory_, job_->outputs.memory_limit, in_buckets); !fits) return fits;
    if (deep_) sinks.push_back(deep_.get());
    if (atlas_.buffer() != nullptr) sinks.push_back(atlas_.buffer());
    display::DriverImage image;
    image.title = std::filesystem::path(job_->output).filename().string();
    image.width = plan.width;
    image.height = plan.height;
    image.layers = display::driver_layers(channels_, plan.beauty);
    image.channels = channels_;
    image.beauty = plan.beauty;
    image.chromaticities = primaries;
    image.partitions = partitions;
    if (Status opened = drivers_.open(image); !opened) return opened;
    if (buckets_ > 0 && drivers_.any_live()) return live_viewer_in_buckets();  // a live driver of a plugin
    return success();
}

/// Removes partitions whose layers no longer sum because a filter changes one layer, or the beauty, alone.
void RenderOutputs::drop_altered(const transport::RenderPlan& plan,
                                 std::vector<display::PartitionDeclaration>& partitions) {
    std::vector<display::ChannelId> altered = plan.altered;
    for (const auto& filter : filters_)
        for (const display::ChannelId id : filter->alters()) altered.push_back(id);
    const auto altered_member = [&](const display::PartitionDeclaration& partition) -> std::string {
        for (const display::ChannelId id : altered) {
            const std::string name = id == plan.beauty ? "beauty" : channels_[static_cast<std::size_t>(id)].name;
            const std::string whole = partition.of.empty() ? "beauty" : partition.of;
            if (name == whole ||
                std::find(partition.layers.begin(), partition.layers.end(), name) != partition.layers.end())
                return name;
        }
        return {};
    };
    std::erase_if(partitions, [&](const display::PartitionDeclaration& partition) {
        const std::string name = altered_member(partition);
        if (!name.empty())
            warnings_.push_back("partition '" + partition.name + "' is left out of the file: a filter changes '" +
                                name + "' alone, so the layers no longer sum");
        return !name.empty();
    });
    if (!filters_.empty() && !job_->outputs.deep.file.empty())
        warnings_.push_back(
            "the deep image is not compared with the image, because display filters change only the image");
}

namespace {

/// The image of a running render.
class LivePixels final : public display::PixelImage {
  public:
    LivePixels(const transport::LiveImage& image, const display::FrameBufferLayout& layout,
               std::span<const display::ChannelDefinition> channels)
        : image_(image), layout_(layout), channels_(channels) {}
    [[nodiscard]] const display::FrameBufferLayout& layout() const override { return layout_; }
    [[nodiscard]] std::span<const display::ChannelDefinition> channels() const override { return channels_; }
    [[nodiscard]] std::vector<double> resolve(display::ChannelId id,
                                              const display::PixelRegion& region) const override {
        return image_.resolve(id, region);
    }
    [[nodiscard]] std::vector<double> resolve_alpha(const display::PixelRegion& region) const override {
        return image_.resolve_alpha(region);
    }

  private:
    const transport::LiveImage& image_;
    const display::FrameBufferLayout& layout_;
    std::span<const display::ChannelDefinition> channels_;
};

}  // namespace

void RenderOutputs::update(const transport::RenderProgress& progress) {
    if (progress.image == nullptr) return;
    const double total = static_cast<double>(std::max<std::uint64_t>(progress.samples_total, 1));
    const LivePixels live(*progress.image, layout_, channels_);
    const display::FilteredImage image = filtered(live);
    drivers_.update(
        progress.seconds, static_cast<double>(progress.samples_done) / total,
        {[&](display::ChannelId id, const display::PixelRegion& region) { return image.resolve(id, region); },
         [&](const display::PixelRegion& region) { return image.resolve_alpha(region); }});
}

display::DenoiseOptions denoise_options(const Job& job) {
    return {job.settings.machine.threads, job.outputs.keep_noisy, {}};
}

Status RenderOutputs::close(const transport::RenderOutput& output, const display::ImageDescription& description) {
    const display::FilteredImage image = filtered(output.image());
    Status closed = success();
    try {
        closed = drivers_.close({image, output.beauty, description});
    } catch (const display::BandFailure& failure) {  // from a driver that does not catch it
        return failure.error();
    }
    if (!closed && closed.error().file == job_->output)
        closed = rescued(closed.error(), "the image", job_->output, [&](const std::string& path) {
            return display::write_exr(path, image, output.beauty, description);
        });
    if (closed && job_->outputs.denoise && !job_->output.empty()) {
        const auto denoised = display::denoise_exr(job_->output, job_->output, denoise_options(*job_));
        if (!denoised) closed = denoised.error();
        else denoised_ = denoised_text(*denoised);
    }
    // Of several failures, one becomes the error of the render. Each names the place of its file.
    const auto also = [&](const Status& written) {
        if (!written && closed) closed = written;
        else if (!written) warnings_.push_back(written.error().to_string());
    };
    also(atlas_.write(output, description));
    if (!deep_) return closed;
    std::map<std::string, std::string> repaired;
    const auto write_deep = [&](const std::string& path) {
        return display::write_deep_exr(path, *deep_, output.beauty, description, job_->outputs.deep.storage, &repaired);
    };
    const std::string& deep_file = job_->outputs.deep.file;
    Status deep = write_deep(deep_file);
    also(deep ? deep : rescued(deep.error(), "the deep image", deep_file, write_deep));
    if (const std::string text = repaired_text(repaired, "--deep-storage float"); !text.empty())
        warnings_.push_back(deep_file + ": " + text);
    if (const std::uint64_t rows = deep_->counts().refused_rows; rows > 0)
        warnings_.push_back(deep_file + ": the deep image lacks " + counted(rows, "row") +
                            " of samples: values beyond the range of its sums, or negative depths");
    return closed;
}

Result<std::optional<display::DeepCheck>> RenderOutputs::report_deep_check(const display::ExrImage& image) const {
    if (!deep_ || !filters_.empty() || job_->outputs.denoise) return std::optional<display::DeepCheck>();
    auto result = display::check_deep(job_->outputs.deep.file, image);
    if (!result) return result.error();
    return std::optional<display::DeepCheck>(std::move(*result));
}

std::vector<std::string> RenderOutputs::take_warnings() {
    std::vector<std::string> warnings = drivers_.take_warnings();
    warnings.insert(warnings.begin(), warnings_.begin(), warnings_.end());
    warnings_.clear();
    return warnings;
}

std::vector<std::string> RenderOutputs::files() const {
    std::vector<std::string> files = drivers_.files();
    std::erase(files, job_->output);
    if (deep_) files.push_back(job_->outputs.deep.file);
    if (atlas_.buffer() != nullptr) files.push_back(job_->outputs.atlas.file);
    return files;
}

std::string deep_line(const display::DeepCheck& result) {
    std::string line = "deep: " + std::to_string(result.layers.size()) +
                       (result.layers.size() == 1 ? " layer" : " layers") +
                       (result.holds ? " flattened equal the image" : " flattened DO NOT EQUAL the image") +
                       " (largest error of alpha " + number_text(result.largest_alpha) + ", of colour " +
                       number_text(result.largest_color) + "; " + std::to_string(result.samples) +
                       " samples, at most " + std::to_string(result.most_samples) + " in a pixel)";
    if (result.exceeding > 0) line += "; " + std::to_string(result.exceeding) + " pixels exceed the bound";
    if (!result.sorted) line += "; samples are out of order";
    if (result.clamped > 0) line += "; " + clamped_text(result.clamped, "the two are equal");
    return line;
}

}  // namespace raylex::experiments
