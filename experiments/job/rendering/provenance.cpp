#include "experiments/job/rendering/provenance.h"

#include <array>
#include <cctype>
#include <ctime>
#include <fstream>
#include <thread>

#include "display/output/splits/stored_precision.h"
#include "experiments/program/console.h"
#include "experiments/revision.h"
#include "transport/math/real.h"
#include "transport/plugins/plugin_loader.h"

namespace raylex::experiments {

std::string raylex_version() {
    return RAYLEX_VERSION;
}
std::string raylex_revision() {
    return RAYLEX_REVISION;
}
std::string build_description() {
    return std::string(RAYLEX_COMPILER) + ", " + RAYLEX_BUILD_TYPE;
}

std::string host_description() {
    std::string model = "unknown processor";
    std::ifstream cpu("/proc/cpuinfo");
    for (std::string line; std::getline(cpu, line);) {
        if (!line.starts_with("model name")) continue;
        const std::size_t start = line.find(':');
        if (start != std::string::npos && start + 2 <= line.size()) model = line.substr(start + 2);
        break;
    }
    return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " hardware threads";
}

std::string utc_time() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text.data();
}

std::string shell_command(const std::vector<std::string>& arguments) {
    std::string command;
    for (const std::string& argument : arguments) {
        bool plain = !argument.empty();
        for (const char c : argument)
            plain = plain && (std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                              std::string_view("-_=./:,+@%").find(c) != std::string_view::npos);
        if (!command.empty()) command += ' ';
        if (plain) {
            command += argument;
            continue;
        }
        command += '\'';
        for (const char c : argument) command += c == '\'' ? std::string("'\\''") : std::string(1, c);
        command += '\'';
    }
    return command;
}

std::string replay_command(const Job& job, const transport::RenderOutput& output,
                           const std::vector<std::string>& arguments, const display::InvalidSample& sample) {
    std::vector<std::string> again = arguments;
    if (job.settings.machine.isa.empty()) again.insert(again.end(), {"--isa", output.used.isa});
    again.insert(again.end(), {"--replay", std::to_string(sample.pixel_x) + "," + std::to_string(sample.pixel_y) + "," +
                                               std::to_string(sample.sample)});
    return shell_command(again);
}

std::map<std::string, std::string> header_attributes(const Job& job, const transport::RenderOutput& output,
                                                     const std::vector<std::string>& arguments,
                                                     const std::string& color_config) {
    std::map<std::string, std::string> attributes{
        {"raylex/version", raylex_version()},
        {"raylex/revision", raylex_revision()},
        {"raylex/compiler", build_description()},
        {"raylex/host", host_description()},
        {"raylex/time", utc_time()},
        {"raylex/command", shell_command(arguments)},
        {"raylex/scene", job.scene_file},
        {"raylex/seed", std::to_string(output.used.seed)},
        {"raylex/samples_per_pixel", std::to_string(output.samples.per_pixel)},
        {"raylex/camera_samples", std::to_string(output.statistics.camera_samples)},
        {"raylex/threads", std::to_string(output.used.threads)},
        {"raylex/isa", output.used.isa},
        {"raylex/arithmetic", transport::real_is_double ? "double" : "float"},
        {"raylex/integrator", output.used.integrator},
        {"raylex/sampler", output.used.sampler},
        {"raylex/filter", output.used.filter},
        {"raylex/filter_mode", output.used.splat ? "splat" : "importance"},
        {"raylex/color_config", color_config},
    };
    for (const transport::LoadedPlugin& plugin : transport::loaded_plugins()) {
        std::string& list = attributes["raylex/plugins"];
        list += (list.empty() ? "" : "\n") + plugin.path;
    }
    if (const std::uint64_t paths = output.frame_buffer.light_path_count(); paths > 0)
        attributes["raylex/light_paths"] = std::to_string(paths);
    if (output.sums.light_magnitude > 0)
        attributes[display::light_magnitude] = number_text(output.sums.light_magnitude);
    if (output.buckets.image) attributes["raylex/buckets"] = std::to_string(output.buckets.rows.size());
    if (job.settings.stop.adaptive) attributes["raylex/adaptive"] = describe(*job.settings.stop.adaptive);
    if (job.effects.any()) attributes["raylex/effects"] = job.effects.text();
    if (output.samples.resumed > 0) attributes["raylex/resumed_samples"] = std::to_string(output.samples.resumed);
    if (!job.job_text.empty()) attributes["raylex/job"] = job.job_text;
    if (!job.rendering_space.empty()) attributes["raylex/rendering_space"] = job.rendering_space;
    return attributes;
}

std::string guide_settings(const transport::GuideSummary& guide) {
    if (guide.samples == 0) return {};
    if (!guide.used) return " with guide = \"off\"";
    return " with guide = \"on\" and guidesamples = " + std::to_string(guide.samples);
}

std::string text_of_invalid(const Job& job, const transport::RenderOutput& output,
                            const std::vector<std::string>& arguments) {
    const transport::RenderStatistics& statistics = output.statistics;
    std::string text = std::to_string(statistics.invalid_samples) +
                       " contributions or values were not finite or too large to sum; they are missing from beauty and "
                       "layers alike. The AOV invalidSamples shows where, --stats lists the first ones";
    if (statistics.invalid_log.empty() || !job.passes.empty()) return text;  // passes replay no sample
    const display::InvalidSample& first = statistics.invalid_log.front();
    return text + ".\n  The first: pixel (" + std::to_string(first.pixel_x) + ", " + std::to_string(first.pixel_y) +
           "), sample " + std::to_string(first.sample) + ", seed " + std::to_string(output.used.seed) +
           "; to render only this sample" +
           (job.settings.stop.limit ? guide_settings(statistics.guide) : std::string()) + ":\n  " +
           replay_command(job, output, arguments, first);
}

}  // namespace raylex::experiments
