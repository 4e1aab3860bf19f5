#include "experiments/cli/render/render_summary.h"

#include <filesystem>

#include "experiments/cli/checks.h"
#include "experiments/job/passes/pass_render.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/program/console.h"
#include "experiments/program/interrupt.h"
#include "experiments/program/tint.h"
#include "lpe/algebra/wording/event_words.h"
#include "transport/paths/guide/guide_view.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

void print_sampling(const RenderSummary& of) {
    const std::uint64_t samples = of.output.statistics.camera_samples;
    if (of.output.samples.resumed > 0)
        print_line("resumed from a checkpoint with " + std::to_string(of.output.samples.resumed) +
                   (of.output.samples.complete ? " of " + std::to_string(samples) : std::string()) + " samples");
    if (const auto passes = of.image.attributes.find(passes_attribute); passes != of.image.attributes.end())
        print_line("passes:\n" + passes->second);
    else if (of.job.settings.stop.limit && of.output.samples.complete)
        print_line("time: " + std::to_string(of.output.samples.per_pixel) + " samples per pixel; --spp " +
                   std::to_string(of.output.samples.per_pixel) + guide_settings(of.output.statistics.guide) +
                   " renders the same bits");
    if (!of.output.samples.adaptive) return;
    const double pixels = static_cast<double>(of.output.view.width) * static_cast<double>(of.output.view.height);
    std::string line =
        "adaptive: " + number_text(static_cast<double>(samples) / pixels, 6) + " samples per pixel on average";
    if (!of.output.samples.adaptive->channel.empty())
        line += ", error of " + of.output.samples.adaptive->channel + " " +
                number_text(100 * of.output.samples.adaptive->error) + " %";
    if (const std::uint64_t missed = of.output.samples.unconverged_pixels; missed > 0)
        line += "; " + std::to_string(missed) + " pixels are above " +
                number_text(100 * of.output.samples.adaptive->target) + " % at the maximum number of samples";
    print_line(line);
}

/// Prints the results of checks that were made during writing; the file was not read again.
void print_written_results(const RenderSummary& of) {
    if (!of.splits.empty()) return;
    for (const display::PartitionDeclaration& partition : of.image.partitions)
        if (const auto result = of.image.attributes.find("verdict/" + partition.name);
            result != of.image.attributes.end())
            print_line("partition '" + partition.name + "', checked while it was written: " +
                       result->second.substr(0, result->second.find_last_not_of(' ') + 1));
}

void print_guide(const transport::RenderOutput& output) {
    const transport::RenderStatistics& statistics = output.statistics;
    const transport::GuideSummary& guide = statistics.guide;
    const transport::GuideView* view = statistics.guide_view.get();
    if (guide.samples == 0) return;
    print_line(
        "guide: " + std::to_string(guide.samples) + " samples of each pixel for training (" +
        (guide.read ? "read from a file" : duration_text(guide.seconds)) +
        (output.samples.resumed > 0 && !guide.read && output.buckets.rows.empty() ? " in an earlier session" : "") +
        "), forecast gain " + number_text(guide.gain) +
        (guide.used
             ? ", used in " + number_text(100 * guide.guided) + " % of " + std::to_string(guide.regions) + " regions" +
                   (view ? " and in " + number_text(100 * view->guided()) + " % of the image" : "") + ", " +
                   size_text(static_cast<double>(guide.bytes))
             : std::string(", not used")));
}

}  // namespace

void print_summary(const RenderSummary& of) {
    const transport::RenderStatistics& statistics = of.output.statistics;
    print_results_of_new(of.splits, of.image);
    print_written_results(of);
    if (of.deep) print_result(deep_line(*of.deep), of.deep->holds);
    if (of.atlas) {
        const auto pixels =
            static_cast<std::uint64_t>(of.output.view.width) * static_cast<std::uint64_t>(of.output.view.height);
        print_result(atlas_line(*of.atlas, pixels), of.atlas->holds);
    }
    std::error_code failed;
    const auto bytes = fs::file_size(of.job.output, failed);
    std::string line = of.job.output + ": " + std::to_string(of.output.view.width) + "x" +
                       std::to_string(of.output.view.height) + ", " + std::to_string(of.image.layers.size()) +
                       (of.image.layers.size() == 1 ? " layer, " : " layers, ") +
                       size_text(failed ? 0.0 : static_cast<double>(bytes));
    if (!of.output.samples.complete)
        line += interrupt_flag().load()
                    ? "; INCOMPLETE: interrupted"
                    : "; INCOMPLETE: the time ended before all pixels had the same number of samples";
    print_line(line);
    if (!of.output.samples.complete && (of.job.checkpoint_seconds > 0 || of.output.buckets.image) &&
        fs::exists(checkpoint_file(of.job), failed))
        print_line(checkpoint_file(of.job) + ": --resume continues from here");
    print_sampling(of);
    print_guide(of.output);
    if (!of.beauties.empty())
        print_line("layers equal to the beauty: " + lpe::joined_by(of.beauties, ", ") +
                   " (they accept every path of this scene)");
    for (const std::string& path : of.files) print_line(path);
    if (!of.job.statistics.empty() && !is_standard_output(of.job.statistics)) print_line(of.job.statistics);
    const auto seconds = [&of](const char* phase) { return duration_text(of.phases.at(phase).wall_seconds); };
    const double cpu = statistics.render_cpu_seconds;
    print_line("load " + seconds("load") + ", plan " + seconds("plan") + ", build " + seconds("build") + ", prepare " +
               seconds("prepare") + ", render " + seconds("render") + " (" + duration_text(cpu) + " CPU, " +
               number_text(cpu > 0 ? static_cast<double>(statistics.camera_samples) / cpu * 1e-6 : 0) +
               " M samples per CPU second), write " + seconds("write"));
}

}  // namespace raylex::experiments
