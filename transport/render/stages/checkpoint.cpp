#include "transport/render/stages/checkpoint.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "display/buffer/record_bytes.h"
#include "display/services/thread_or_none.h"
#include "transport/render/stages/render_state.h"

namespace raylex::transport {
namespace {

using display::RecordIdentity;
using display::RecordReader;
using display::RecordWriter;

std::string number_text(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.17g", value);
    return text.data();
}

/// The text of an entity, such as "mitchell(xradius=2 B=0.5)".
std::string entity_text(const SceneEntity& entity) {
    std::string text = entity.type + "(";
    for (const Parameter& each : entity.parameters.parameters) {
        text += (text.back() == '(' ? "" : " ") + each.name + "=";
        for (const double number : each.numbers) text += number_text(number) + ";";
        for (const std::string& word : each.strings) text += word + ";";
        for (const std::uint8_t flag : each.booleans) text += flag != 0 ? "true;" : "false;";
    }
    return text + ")";
}

std::string channel_text(const display::ChannelDefinition& channel) {
    std::string text = channel.style == display::ChannelStyle::expression ? channel.expression : channel.name;
    if (channel.dialect == lpe::Dialect::osl) text += " (osl)";
    for (const std::size_t other : channel.rest_of) text += " -" + std::to_string(other);
    text += ", type " + std::to_string(static_cast<int>(channel.type)) + ", rule " +
            std::to_string(static_cast<int>(channel.rule));
    if (channel.statistics) text += ", statistics";
    if (!display::takes_samples(channel))
        text += ", statistic " + std::to_string(static_cast<int>(channel.statistic)) + " of " +
                std::to_string(channel.source);
    return text;
}

void write_statistics(RecordWriter& writer, const RenderStatistics& statistics) {
    // If this binding stops compiling, statistics have a new number that no record stores yet.
    const auto& [build_seconds, build_cpu_seconds, prepare_seconds, prepare_cpu_seconds, pilot_rays, guide, guide_view,
                 render_seconds, render_cpu_seconds, camera_samples, camera_rays, scattering_rays, shadow_rays,
                 discarded_samples, branches, pruned, path_length_histogram, attribution_overflow, invalid_samples,
                 invalid_by_channel, invalid_log, refused_services_calls, refusals, checkpoints,
                 checkpoint_stall_seconds] = statistics;
    static_cast<void>(build_seconds), static_cast<void>(build_cpu_seconds);  // of this session only
    static_cast<void>(prepare_seconds), static_cast<void>(prepare_cpu_seconds), static_cast<void>(pilot_rays);
    static_cast<void>(checkpoints), static_cast<void>(checkpoint_stall_seconds);
    static_cast<void>(discarded_samples), static_cast<void>(guide), static_cast<void>(guide_view);
    writer.number(render_seconds);
    writer.number(render_cpu_seconds);
    for (const std::uint64_t each : {camera_samples, camera_rays, scattering_rays, shadow_rays, branches,
                                     attribution_overflow, invalid_samples, refused_services_calls})
        writer.number(each);
    writer.numbers({pruned.begin(), pruned.end()});
    writer.numbers(path_length_histogram);
    writer.numbers(invalid_by_channel);
    std::vector<std::uint64_t> refused;
    for (const display::RefusalCounts& each : refusals) refused.insert(refused.end(), each.by.begin(), each.by.end());
    writer.numbers(refused);
    writer.number(static_cast<std::uint64_t>(invalid_log.size()));
    for (const display::InvalidSample& each : invalid_log) {
        writer.number(each.pixel_x);
        writer.number(each.pixel_y);
        writer.number(each.sample);
        writer.number(each.channel);
        for (const float value : {each.value.r, each.value.g, each.value.b}) writer.number(value);
    }
}

void read_statistics(RecordReader& reader, RenderStatistics& statistics) {
    statistics.render_seconds = reader.number<double>();
    statistics.render_cpu_seconds = reader.number<double>();
    for (std::uint64_t* each : {&statistics.camera_samples, &statistics.camera_rays, &statistics.scattering_rays,
                                &statistics.shadow_rays, &statistics.branches, &statistics.attribution_overflow,
                                &statistics.invalid_samples, &statistics.refused_services_calls})
        *each = reader.number<std::uint64_t>();
    const std::vector<std::uint64_t> pruned = reader.numbers();
    std::copy_n(pruned.begin(), std::min(pruned.size(), pruned_causes), statistics.pruned.begin());
    statistics.path_length_histogram = reader.numbers();
    statistics.invalid_by_channel = reader.numbers();
    const std::vector<std::uint64_t> refused = reader.numbers();
    constexpr std::size_t kinds = display::refusal_kinds;
    statistics.refusals.resize(refused.size() / kinds);
    for (std::size_t i = 0; i < statistics.refusals.size() * kinds; ++i)
        statistics.refusals[i / kinds].by[i % kinds] = refused[i];
    const auto logged = reader.number<std::uint64_t>();
    for (std::uint64_t i = 0; i < logged && reader.ok(); ++i) {
        display::InvalidSample each;
        each.pixel_x = reader.number<std::int32_t>();
        each.pixel_y = reader.number<std::int32_t>();
        each.sample = reader.number<std::uint64_t>();
        each.channel = reader.number<display::ChannelId>();
        for (float* value : {&each.value.r, &each.value.g, &each.value.b}) *value = reader.number<float>();
        statistics.invalid_log.push_back(each);
    }
}

Error resume_error(const std::string& file, std::string message, std::string hint) {
    return {std::move(message), file, 0, 0, {}, std::move(hint)};
}

constexpr const char* start_again = "to start again, remove this file and leave out --resume";

}  // namespace

RecordIdentity render_identity(const ResolvedJob& job) {
    const RenderSettings& settings = job.settings;
    const CameraSampling& sampling = job.sampling;
    RecordIdentity identity = settings.identity;
    const auto add = [&](std::string name, std::string value) {
        identity.emplace_back(std::move(name), std::move(value));
    };
    add("resolution", std::to_string(job.grid.width) + "x" + std::to_string(job.grid.height));
    if (const auto& crop = sampling.film.crop)
        add("crop", std::to_string(crop->x0) + "," + std::to_string(crop->y0) + "," + std::to_string(crop->x1) + "," +
                        std::to_string(crop->y1));
    if (job.bucket) add("rows", std::to_string(job.bucket->first) + " to " + std::to_string(job.bucket->end));
    add("seed", std::to_string(sampling.seed));
    add("samples per pixel", std::to_string(job.budget.samples_per_pixel));
    add("sampler", sampling.sampler_name);
    add("pixel filter",
        sampling.filter->name() + (settings.film.filter ? " " + entity_text(*settings.film.filter) : std::string()));
    add("filter mode", sampling.splat ? "splat" : "importance");
    if (settings.paths.integrator) add("integrator", entity_text(*settings.paths.integrator));
    if (!settings.paths.prune) add("prune", "off");
    if (settings.paths.max_depth) add("max depth", std::to_string(*settings.paths.max_depth));
    for (std::size_t i = 0; i < settings.channels.sample_filters.size(); ++i)
        add("sample filter " + std::to_string(i + 1), entity_text(settings.channels.sample_filters[i]));
    add("beauty", settings.channels.beauty ? "true" : "false");
    add("lobes", settings.labels.picked_lobes ? "picked" : "exact");
    for (const display::ChannelDefinition& channel : job.channels.list)
        add("channel " + channel.name, channel_text(channel));
    for (const geoaovs::MatteKind kind : settings.mattes.kinds)
        add("cryptomatte " + geoaovs::matte_layer(kind), std::to_string(settings.mattes.ranks) + " ranks");
    if (settings.stop.adaptive) add("adaptive", describe(*settings.stop.adaptive));
    if (settings.stop.limit)
        add("end", number_text(settings.stop.limit->seconds) + " s, error " + number_text(settings.stop.limit->error));
    if (settings.samples.first > 0) add("first sample", std::to_string(settings.samples.first));
    add("instruction set", job.scene.isa());
    return identity;
}

Status check_checkpoint(const CheckpointSettings& settings, const RenderState& state) {
    const ResolvedJob& job = state.prepared.job;
    if (job.integrator().traits().saved_state == SavedState::unknown)
        return error_at({},
                        "integrator '" + job.chosen.name +
                            "' cannot save its state, so a render with it has no "
                            "checkpoints",
                        "leave out --checkpoint and --resume, or choose another integrator, such as path");
    if (state.target.has_sinks_of_others())
        return error_at({}, "outputs that read raw samples, such as deep images, are not saved in checkpoints",
                        "leave out --checkpoint and --resume, or the deep image");
    if (settings.file.empty()) return error_at({}, "a checkpoint without a file; expected a file name");
    return success();
}

display::RecordFile make_checkpoint(const RecordIdentity& identity, const RenderPosition& position,
                                    const RenderState& state) {
    const RenderTarget& target = state.target;
    const Integrator& integrator = state.prepared.job.integrator();
    display::RecordFile record;
    record.identity = identity;
    RecordWriter progress(record.add("progress"));
    progress.number(position.phase);
    progress.number(position.task);
    progress.number(static_cast<std::uint64_t>(position.unfinished.size()));
    for (const UnfinishedTask& each : position.unfinished) {
        progress.number(each.task);
        progress.number(each.done);
    }
    write_statistics(progress, position.statistics);
    target.frame_buffer.append_record(record.add("frame buffer"));
    for (const geoaovs::Cryptomatte& matte : target.mattes) matte.coverage().append_record(record.add(matte.name()));
    const std::string section = state.schedule.section();
    if (!section.empty()) state.schedule.append_record(record.add(section));
    if (integrator.traits().saved_state == SavedState::saved) integrator.save_state(record.add("integrator"));
    return record;
}

Result<std::optional<TrainedGuide>> saved_guide(const ResolvedJob& job) {
    std::optional<TrainedGuide> guide;
    if (!job.checkpoint || !job.checkpoint->resume) return guide;
    const auto record = display::RecordFileReader::open(job.checkpoint->file);
    if (!record || !record->has(guide_section)) return guide;  // restore_checkpoint() names what is wrong with the file
    const auto content = record->read(guide_section);
    if (!content) return content.error();
    guide = TrainedGuide::from_record(*content);
    if (guide) return guide;
    return resume_error(job.checkpoint->file, "cannot resume: the guide of the checkpoint is damaged", start_again);
}

Result<RenderPosition> restore_checkpoint(const CheckpointSettings& settings, const RecordIdentity& identity,
                                          RenderState& state) {
    const std::string& file = settings.file;
    std::error_code failed;
    if (std::filesystem::is_directory(file, failed))
        return resume_error(
            file, "cannot resume: these are the buckets of a render with --memory or --bucket-rows",
            "use the settings of the first session, or, to start again, remove this folder and leave out --resume");
    if (!std::filesystem::exists(file, failed))
        return resume_error(file, "there is no checkpoint to resume from; expected this file",
                            "leave out --resume to start a new render");
    auto record = display::read_record_file(file);
    if (!record) {
        Error error = record.error();
        error.message = "cannot resume: " + error.message;
        error.hint = start_again;
        return error;
    }
    if (const auto differences = display::identity_differences(record->identity, identity); !differences.empty()) {
        std::string message = "cannot resume: the checkpoint belongs to another render";
        for (const std::string& each : differences) message += "\n  " + each;
        return resume_error(
            file, message,
            "use the settings of the first session, or, to start again, remove this file and leave out --resume");
    }
    return restore_record(*record, file, state);
}

Result<RenderPosition> restore_record(const display::RecordFile& record, const std::string& file, RenderState& state) {
    RenderTarget& target = state.target;
    Integrator& integrator = state.prepared.job.integrator();
    const auto damaged = [&](const std::string& section) {
        return resume_error(
            file, "cannot resume: section '" + section + "' of the checkpoint does not match this render", start_again);
    };
    const auto content = [&](const std::string& name) -> std::string_view {
        const display::RecordSection* section = record.find(name);
        return section != nullptr ? std::string_view(section->content) : std::string_view();
    };
    RenderPosition position;
    RecordReader progress(content("progress"));
    position.phase = progress.number<std::uint64_t>();
    position.task = progress.number<std::uint64_t>();
    const auto unfinished = progress.number<std::uint64_t>();
    for (std::uint64_t i = 0; i < unfinished && progress.ok(); ++i) {
        const auto task = progress.number<std::uint64_t>(), done = progress.number<std::uint64_t>();
        position.unfinished.push_back({task, done});
    }
    read_statistics(progress, position.statistics);
    if (!progress.at_end()) return damaged("progress");
    auto restored = display::FrameBuffer::from_record(content("frame buffer"));
    if (!restored || !restored->difference_from(target.frame_buffer).empty()) return damaged("frame buffer");
    restored->adopt_kernels(target.frame_buffer);
    target.frame_buffer = *std::move(restored);
    for (geoaovs::Cryptomatte& matte : target.mattes)
        if (!matte.coverage().restore_record(content(matte.name()))) return damaged(matte.name());
    const std::string section = state.schedule.section();
    if (!section.empty() && !state.schedule.restore_record(content(section))) return damaged(section);
    if (integrator.traits().saved_state == SavedState::saved)
        if (Status s = integrator.restore_state(content("integrator")); !s) return s.error();
    return position;
}

void CheckpointWriter::start(display::RecordFile record) {
    wait();
    busy_.store(true);
    const auto write = [this, content = std::make_shared<const display::RecordFile>(std::move(record))] {
        const Status status = display::write_record_file(file_, *content);
        last_written_ = status.ok();
        if (status) ++written_;
        else fail(status.error());
        busy_.store(false);
    };
    thread_ = display::thread_or_none(write);
    if (!thread_.joinable()) write();
}

void CheckpointWriter::fail(Error error) {
    last_written_ = false;
    if (failures_.empty() || failures_.back().message != error.message) failures_.push_back(std::move(error));
}

void CheckpointWriter::wait() {
    if (thread_.joinable()) thread_.join();
}

}  // namespace raylex::transport
