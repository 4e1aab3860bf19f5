#include "experiments/study/report/study_report.h"

#include <cmath>
#include <filesystem>
#include <map>

#include "display/output/atomic_file.h"
#include "experiments/job/text/json.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/study/file_records.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/page/assets.h"
#include "experiments/study/report/page/study_page.h"
#include "experiments/study/report/page/study_tables.h"
#include "experiments/study/report/paper/paper.h"

namespace raylex::experiments {
namespace {

Status write_plots(const std::string& directory, const std::vector<Plot>& plots, const std::string& d3) {
    Result<PlotDrawer> drawer = PlotDrawer::create(d3);
    if (!drawer) return std::move(drawer).error();
    for (const Plot& plot : plots) {
        Json spec = parse_json(plot.json);
        spec["standalone"] = true;
        Result<std::string> svg = drawer->draw(json_text(spec));
        if (!svg) return std::move(svg).error();
        Status written = display::write_text_file(directory + "/" + plot.file, *svg);
        if (!written) return written;
    }
    return success();
}

/// Writes tables/SCENE.CHANNEL.tex of every measured channel, insets/ and spectra/.
Status write_paper(const std::string& directory, const Study& study, std::size_t& files) {
    for (const SceneInfo& scene : study.experiment->scenes)
        for (const ChannelInfo& channel : scene.channels) {
            const std::string table = latex_table(study, scene.name, channel.name);
            if (table.empty()) continue;
            Status written = display::write_text_file(
                directory + "/tables/" + file_part(scene.name) + "." + file_part(channel.name) + ".tex", table);
            if (!written) return written;
            ++files;
        }
    Result<std::size_t> maps = write_deviation_maps(study, directory + "/spectra");
    if (!maps) return maps.error();
    files += *maps;
    Result<std::size_t> insets = write_insets(study, directory + "/insets");
    if (!insets) return insets.error();
    files += *insets;
    return success();
}

/// Returns a line with the bias verdicts of a variant in a scene; empty if nothing was tested.
std::string bias_line(const Study& study, const std::string& scene, const MethodVariant& variant) {
    std::map<BiasConclusion, std::vector<const BiasEntry*>> found;  // channels in order, the beauty first
    for (const BiasEntry& entry : study.bias)
        if (entry.scene == scene && entry.variant == variant.name) found[entry.conclusion()].push_back(&entry);
    std::string text;
    const auto add = [&](const std::string& part) {
        text += (text.empty() ? variant.name + " on " + scene + ": " : "; ") + part;
    };
    if (const auto& wrong = found[BiasConclusion::differs]; !wrong.empty()) {
        add((variant.unbiased ? "BIASED: it differs from the reference" : "differs from the reference, as declared") +
            std::string(" in ") + wrong.front()->channel + ", by " + finding_of(study, *wrong.front()));
        if (const Counterexamples::Counterexample* word = first_counterexample(study, scene, variant.name))
            add("first wrong path " + word->text + ", channel " + word->channel);
    } else if (const auto& clean = found[BiasConclusion::none_found]; !clean.empty()) {
        const BiasEntry& first = *clean.front();
        add("no bias found; a bias of " + percent_text(first.result.detectable_whole) +
            " of the mean would be found with 90 %" +
            (first.against.empty() ? "" : " (compared with " + first.against + ")"));
    }
    for (const BiasConclusion other :
         {BiasConclusion::cannot_tell, BiasConclusion::rare, BiasConclusion::omits_paths}) {
        std::vector<std::pair<std::string, std::string>> reasons;  // each with its first verdict and its channels
        std::map<std::string, std::size_t> places;
        for (const BiasEntry* entry : found[other]) {
            const auto [place, added] = places.try_emplace(
                other == BiasConclusion::cannot_tell ? entry->reason() : std::string(), reasons.size());
            if (added) reasons.emplace_back(result_of(study, *entry), entry->channel);
            else reasons[place->second].second += ", " + entry->channel;
        }
        for (const auto& [result, channels] : reasons) add(result + " (" + channels + ")");
    }
    return text;
}

/// Prints all verdicts of a small study. For a large one, prints those against methods declared unbiased, and the
/// number of others.
void print_results(const Study& study) {
    constexpr std::size_t most_lines = 12;
    const std::vector<std::string> lines = result_lines(study);
    std::size_t kept_back = 0;
    for (const std::string& line : lines)
        if (lines.size() <= most_lines || line.find(": BIASED: ") != std::string::npos) print_line(line);
        else ++kept_back;
    if (kept_back > 0) print_line(std::to_string(kept_back) + " other verdicts on bias are in the report");
}

/// Prints the effect of each setting by channel for a small study. For a large one it is only on the page.
void print_effects(const Study& study) {
    constexpr std::size_t most_lines = 24;
    if (study.effects.size() > most_lines) return;
    for (const SettingEffect& each : study.effects) {
        const Interval& ratio = each.speed_up;
        const std::string change =
            each.channel + " on " + each.scene + ", " + each.key + " " + each.from + " to " + each.to + ": ";
        if (ratio.note == wide_note) print_line(change + ratio.note);
        if (!std::isfinite(ratio.value)) continue;
        print_line(change + plain_number(ratio.value) + " times as efficient" +
                   (ratio.valid() ? " [" + plain_number(ratio.low) + ", " + plain_number(ratio.high) + "]" : "") +
                   ", by medians " + plain_number(each.by_medians) + (ratio.note.empty() ? "" : "; " + ratio.note));
    }
}

/// Returns the experiment without damaged cells and references, and their number. Each is a warning and is not
/// measured.
std::pair<Experiment, std::size_t> without_damage(Experiment experiment) {
    std::size_t count = 0;
    for (StudyRun& run : experiment.runs) {
        const std::string damage = damage_of(run);
        if (damage.empty()) continue;
        ++count;
        print_warning("cell '" + run.id + "' is damaged and is left out: " + damage);
        run.failed = true;
        run.failure = "damaged: " + damage;
    }
    for (SceneInfo& scene : experiment.scenes) {
        if (scene.reference.empty()) continue;
        const std::string damage = damage_of_reference(scene.reference);
        if (damage.empty()) continue;
        ++count;
        print_warning("the reference of scene '" + scene.name + "' is damaged and is left out: " + damage);
        scene.reference_failure = "damaged: " + damage;
        scene.reference.clear();
    }
    return {std::move(experiment), count};
}

}  // namespace

std::vector<std::string> result_lines(const Study& study) {
    std::vector<std::string> lines;
    for (const SceneInfo& scene : study.experiment->scenes)
        for (const MethodVariant& variant : study.variants)
            if (std::string line = bias_line(study, scene.name, variant); !line.empty())
                lines.push_back(std::move(line));
    return lines;
}

int write_study_report(const Experiment& as_read, const StudyReportOptions& options) {
    Result<std::string> d3 = read_d3();
    if (!d3) return report_error(d3.error());
    const auto [experiment, damaged] = without_damage(as_read);
    Result<Study> study = study_of(experiment, options);
    if (!study) return report_error(study.error());
    const std::string directory = options.directory.empty() ? experiment.directory : options.directory;
    std::error_code failed;
    for (const char* folder : {"/plots", "/tables", "/insets", "/spectra"}) {
        std::filesystem::create_directories(directory + folder, failed);
        if (failed) return report_error("the folder '" + directory + folder + "' cannot be made: " + failed.message());
    }
    const std::vector<Plot> plots = plots_of(*study);
    const Pictures pictures = pictures_of(*study);
    for (const std::string& each : pictures.left_out) print_warning("no picture of " + each);
    const std::string page = study_page(*study, plots, pictures, *d3);
    std::size_t paper_files = 0;
    Status written = write_plots(directory + "/plots", plots, *d3);
    if (written) written = write_paper(directory, *study, paper_files);
    if (written) written = display::write_text_file(directory + "/results.csv", results_csv(*study));
    if (written) written = display::write_text_file(directory + "/results.columns.csv", columns_csv());
    if (written) written = display::write_text_file(directory + "/results.jsonl", results_jsonl(*study));
    if (written) written = display::write_text_file(directory + "/report.html", page);
    if (!written) return report_error(written.error());
    if (!study->omissions.empty())
        print_warning(counted(study->omissions.size(), "omission") + ", listed in the report; the first: " +
                      study->omissions.front().what + ": " + study->omissions.front().reason);
    print_line(directory + "/report.html: " + size_text(static_cast<double>(page.size())) +
               "; results.csv, results.jsonl, " + std::to_string(plots.size()) + " plots and " +
               std::to_string(paper_files) + " tables, insets and maps beside it");
    if (constexpr std::size_t most_lines = 12; study->comparisons.size() <= most_lines && study->variants.size() > 1)
        for (const MethodComparison& each : study->comparisons)
            print_line(each.scene + ": " + best_sentence(*study, each));
    print_effects(*study);
    print_results(*study);
    return damaged > 0 ? exit_bad_input : exit_holds;
}

}  // namespace raylex::experiments
