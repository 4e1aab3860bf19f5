#include "experiments/study/run/cells/run_files.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <future>

#include "display/checkpoint/banded_record.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "display/output/writer/exr_writer.h"
#include "display/services/parameters.h"
#include "experiments/job/rendering/provenance.h"

namespace raylex::experiments {
namespace {

std::size_t size_of(int side) {
    return static_cast<std::size_t>(side);
}

/// Writes the arrays of one channel of light.
Status write_channel(const std::string& directory, const std::string& name, const display::PixelImage& image,
                     const display::FrameBuffer* buffer, display::ChannelId id,
                     const std::vector<std::uint64_t>& samples) {
    const display::FrameBufferLayout& layout = image.layout();
    PixelArray array{size_of(layout.height), size_of(layout.width), 3, image.resolve(id)};
    if (Status s = write_npy(directory + "/" + name + ".mean.npy", array, display::FileSync::later); !s) return s;
    if (buffer == nullptr || buffer->light_path_count() > 0)
        return success();  // no moments, because they would contain camera samples without splats
    std::vector<double> variance = buffer->resolve_variance_of_mean(id);
    if (variance.empty()) return success();
    for (std::size_t i = 0; i < variance.size(); ++i) {
        const auto n = static_cast<double>(samples[i / 3]);
        variance[i] *= n * (n - 1);
    }
    array.values = std::move(variance);
    return write_npy(directory + "/" + name + ".m2.npy", array, display::FileSync::later);
}

bool is_light(const display::ChannelDefinition& channel) {
    return channel.style == display::ChannelStyle::expression && display::takes_samples(channel) &&
           display::keeps_pixels(channel) && channel.rule == display::FilterRule::filter;
}

/// Runs all tasks on two threads, because the processors are idle now. Returns the first failure in order.
Status on_two_processors(const std::vector<std::function<Status()>>& tasks) {
    std::vector<Status> done(tasks.size(), success());
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
        for (std::size_t i = next++; i < tasks.size(); i = next++) done[i] = tasks[i]();
    };
    auto other = std::async(std::launch::async | std::launch::deferred, work);
    work();
    other.get();
    const auto failed = std::find_if(done.begin(), done.end(), [](const Status& each) { return !each; });
    return failed == done.end() ? success() : *failed;
}

}  // namespace

std::vector<ChannelInfo> channel_infos(const ChannelPlan& plan) {
    std::vector<ChannelInfo> infos{{"beauty", "C.*", "renderman", true}};
    for (const display::ChannelDefinition& each : plan.channels)
        if (is_light(each))
            infos.push_back(
                {each.name, each.expression, each.dialect == lpe::Dialect::osl ? "osl" : "renderman", false});
    return infos;
}

Result<std::vector<PartitionResult>> write_render_files(const std::string& directory, const Rendered& rendered,
                                                        const JobScene& scene,
                                                        const std::map<std::string, std::string>& attributes) {
    const transport::RenderOutput& output = rendered.output;
    return write_buffer_files(directory, output.image(), output.sum ? nullptr : &output.frame_buffer, output.beauty,
                              image_description(rendered.job, scene, output, rendered.partitions, attributes),
                              record_identity(rendered));
}

display::RecordIdentity record_identity(const Rendered& rendered) {
    const transport::RenderOutput& output = rendered.output;
    return {{"scene", rendered.job.scene_file},
            {"seed", std::to_string(output.used.seed)},
            {"samples per pixel", std::to_string(output.samples.per_pixel)},
            {"instruction set", output.used.isa}};
}

Result<std::vector<PartitionResult>> write_buffer_files(const std::string& directory, const display::PixelImage& pixels,
                                                        const display::FrameBuffer* buffer, display::ChannelId beauty,
                                                        display::ImageDescription description,
                                                        display::RecordIdentity identity) {
    const std::string image = directory + "/image.exr";
    description.sync = display::FileSync::later;
    // A study has thousands of such images beside much larger sums, so speed matters more than size.
    for (const char* kind : {"light", "color"})
        if (Status s = display::override_exr_storage(description.storage, kind, "float none", {}); !s) return s.error();
    const int width = pixels.layout().width, height = pixels.layout().height;
    std::vector<std::uint64_t> samples;
    for (int y = 0; buffer != nullptr && y < height; ++y)
        for (int x = 0; x < width; ++x) samples.push_back(buffer->sample_count(x, y));
    std::vector<display::SplitResult> splits;
    std::vector<std::function<Status()>> files;  // the largest first
    if (buffer != nullptr) files.emplace_back([&] { return write_sums(directory + "/record.bin", identity, *buffer); });
    files.emplace_back([&] { return display::write_exr(image, pixels, beauty, description, &splits); });
    const auto channels = pixels.channels();
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const auto id = static_cast<display::ChannelId>(i);
        if (!is_light(channels[i])) continue;
        const std::string name = id == beauty ? "beauty" : channels[i].name;
        files.emplace_back([&, id, name] { return write_channel(directory, name, pixels, buffer, id, samples); });
    }
    if (buffer != nullptr)
        files.emplace_back([&] {
            return write_npy_counts(directory + "/samples.npy", size_of(height), size_of(width), samples,
                                    display::FileSync::later);
        });
    if (Status s = on_two_processors(files); !s) return s.error();
    std::vector<PartitionResult> results;
    for (const display::SplitResult& each : splits) {
        results.push_back({each.partition, each.holds, each.largest_relative});
        if (each.holds) continue;
        // Reads the file again only after a failure, for the residual map.
        auto written = display::read_exr(image);
        if (!written) return written.error();
        auto found = display::check_declared_splits(*written);
        if (!found) return found.error();
        for (const display::SplitResult& read : *found) {
            if (read.partition != each.partition) continue;
            const std::string map = directory + "/" + each.partition + ".residual.png";
            if (Status s = display::write_residual_png(map, read, written->width, written->height); !s)
                return s.error();
        }
    }
    return results;
}

Result<std::vector<std::string>> write_image_files(const std::string& directory, const std::string& path, int width,
                                                   int height, const std::vector<ChannelInfo>& channels) {
    auto image = display::read_exr(path);
    if (!image) return image.error();
    if (image->width != width || image->height != height)
        return error_at({path, 0, 0}, "the image has " + std::to_string(image->width) + "x" +
                                          std::to_string(image->height) + " pixels; expected " + std::to_string(width) +
                                          "x" + std::to_string(height));
    if (image->data_window)
        return error_at({path, 0, 0},
                        "the image has pixels in " + std::to_string(image->data_window->width()) + "x" +
                            std::to_string(image->data_window->height()) + " of its " + std::to_string(width) + "x" +
                            std::to_string(height) + " only (its data window); expected all pixels",
                        "turn off the renderer's crop window, or its option that omits black borders");
    std::vector<std::string> absent;
    for (const ChannelInfo& channel : channels) {
        const display::ImageLayer* layer = image->layer(channel.beauty ? "" : channel.name);
        if (layer == nullptr || layer->triple()[0] == nullptr) {
            if (!channel.beauty) {
                absent.push_back(channel.name);
                continue;
            }
            return error_at({path, 0, 0}, "the image has no colours; expected R, G and B");
        }
        PixelArray array{size_of(height), size_of(width), 3, std::vector<double>(3 * size_of(height) * size_of(width))};
        for (std::size_t c = 0; c < 3; ++c) {
            const std::vector<float>& values = layer->triple()[c]->values;
            for (std::size_t i = 0; i < values.size(); ++i) {
                if (!std::isfinite(values[i]))
                    return error_at({path, 0, 0}, "layer '" + channel.name + "' is not finite at pixel (" +
                                                      std::to_string(i % size_of(width)) + ", " +
                                                      std::to_string(i / size_of(width)) + ")");
                array.values[3 * i + c] = static_cast<double>(values[i]);
            }
        }
        const std::string file = directory + "/" + channel.name + ".mean.npy";
        if (Status s = write_npy(file, array, display::FileSync::later); !s) return s.error();
    }
    return absent;
}

Result<display::FrameBuffer> read_record(const std::string& directory) {
    const std::string path = directory + "/record.bin";
    auto file = display::RecordFileReader::open(path);
    if (!file) return file.error();
    const auto record = display::BandedRecord::open(*std::move(file));
    if (!record) return record.error();
    return display::sum_of_records({&*record, 1});
}

Status write_sums(const std::string& path, const display::RecordIdentity& identity, const display::FrameBuffer& buffer,
                  const std::string& image) {
    const std::size_t bands =
        display::record_bands(buffer.layout(), buffer.channels(), buffer.takes_raster_splats()).size();
    auto writer =
        display::RecordFileWriter::create(path, identity, bands + (image.empty() ? 0 : 1), display::FileSync::later);
    if (!writer) return writer.error();
    if (Status added = display::add_bands(*writer, buffer); !added) return added;
    if (!image.empty())
        if (Status added = writer->add("image", image); !added) return added;
    return writer->commit();
}

}  // namespace raylex::experiments
