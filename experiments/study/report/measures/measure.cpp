// Reads every image of an experiment once and measures it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>

#include "experiments/program/console.h"
#include "experiments/study/report/measures/bias_checks.h"
#include "experiments/study/report/measures/study.h"
#include "lpe/algebra/proofs/paths.h"

namespace raylex::experiments {
namespace {

/// The cells of one scene, variant and budget that have images, by replicate.
struct Group {
    const MethodVariant* variant = nullptr;
    BudgetKind kind = BudgetKind::samples;
    double budget = 0;
    std::vector<const StudyRun*> runs;
};

struct Reference {
    PixelArray mean;
    std::optional<PixelArray> variance;  ///< of the mean; empty if it was not stored
};

struct RegionPixels {
    std::string name;  ///< "": the whole image
    std::vector<std::uint32_t> pixels;
};

/// Returns the preparation time of a cell. Loading, building and writing are separate phases outside the cell's time.
double setup_of(const StudyRun& run, bool cpu_clock) {
    double rendering = 0;
    for (const Phase& phase : run.phases)
        if (phase.name == "render") rendering += cpu_clock ? phase.cpu_seconds : phase.wall_seconds;
    return rendering > 0 ? std::max(0.0, run.seconds(cpu_clock) - rendering) : 0;
}

bool is_black(const PixelArray& array) {
    return std::all_of(array.values.begin(), array.values.end(), [](double value) { return value == 0; });
}

std::vector<double> selected(const PixelArray& array, const std::vector<std::uint32_t>& pixels) {
    return values_of(array, pixels);
}

class Measurer {
  public:
    Measurer(const Experiment& experiment, Study& study) : experiment_(experiment), study_(study) {}

    Status measure() {
        for (const SceneInfo& scene : experiment_.scenes) {
            Status done = measure_scene(scene);
            if (!done) return done;
        }
        return success();
    }

  private:
    Status measure_scene(const SceneInfo& scene) {
        if (scene.reference.empty()) {
            study_.omissions.push_back(
                {"scene " + scene.name,
                 "no reference" + (scene.reference_failure.empty() ? "" : " (" + scene.reference_failure + ")") +
                     ": its errors, bias and images are not judged"});
            return success();
        }
        std::vector<RegionPixels> regions{{"", {}}};
        for (const Region& region : experiment_.regions) {
            if (!region.scene.empty() && region.scene != scene.name) continue;
            Result<std::vector<std::uint32_t>> pixels = region_pixels(region, scene.width, scene.height);
            if (!pixels) return std::move(pixels).error();
            regions.push_back({region.name, std::move(*pixels)});
        }
        const std::vector<Group> groups = groups_of(scene);
        std::string absent;  // an imported image may contain only the beauty
        for (const ChannelInfo& channel : scene.channels)
            if (channel.beauty || std::filesystem::exists(scene.reference + "/" + channel.name + ".mean.npy"))
                measure_channel(scene, channel, regions, groups);
            else absent += (absent.empty() ? "" : ", ") + channel.name;
        if (!absent.empty())
            study_.omissions.push_back({"scene " + scene.name, "its reference has no layers named " + absent +
                                                                   "; these channels are not measured"});
        return success();
    }

    [[nodiscard]] std::vector<Group> groups_of(const SceneInfo& scene) const {
        std::vector<Group> groups;
        for (const MethodVariant& variant : study_.variants)
            for (const StudyRun& run : experiment_.runs) {
                if (run.failed || run.scene != scene.name || variant_name(run) != variant.name) continue;
                const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& each) {
                    return each.variant == &variant && each.kind == run.budget_kind && each.budget == run.budget;
                });
                if (same != groups.end()) same->runs.push_back(&run);
                else groups.push_back({&variant, run.budget_kind, run.budget, {&run}});
            }
        return groups;
    }

    void measure_channel(const SceneInfo& scene, const ChannelInfo& channel, const std::vector<RegionPixels>& regions,
                         const std::vector<Group>& groups) {
        Result<PixelArray> mean = read_mean(scene.reference, channel.name);
        if (!mean) {
            study_.omissions.push_back({"channel " + channel.name + " of scene " + scene.name, mean.error().message});
            return;
        }
        if (!channel.beauty && is_black(*mean) && is_black_everywhere(channel, groups)) {
            study_.omissions.push_back({"channel " + channel.name + " of scene " + scene.name,
                                        "black in the reference and in every image, so there is nothing to measure"});
            return;
        }
        Reference reference{std::move(*mean), std::nullopt};
        Result<PixelArray> m2 = read_m2(scene.reference, channel.name), samples = read_samples(scene.reference);
        if (m2 && samples) reference.variance = variance_of_mean(*m2, *samples);
        // Curves of one (region, variant) over budgets; `groups` are ordered by budget.
        std::map<std::pair<std::string, std::string>, std::size_t> curves;
        for (const RegionPixels& region : regions)
            for (const MethodVariant& variant : study_.variants)
                for (const Group& group : groups)
                    if (group.variant == &variant && !curves.contains({region.name, variant.name})) {
                        curves[{region.name, variant.name}] = study_.curves.size();
                        study_.curves.push_back({scene.name,
                                                 variant.name,
                                                 channel.name,
                                                 region.name,
                                                 group.kind,
                                                 {},
                                                 {},
                                                 {},
                                                 {},
                                                 {},
                                                 false});
                    }
        BiasCandidates candidates;
        for (const Group& group : groups) {
            if (was_not_requested(group, channel)) continue;
            const std::vector<PixelArray> images = read_group(group, channel, reference.mean);
            offer_candidate(candidates[group.variant->name], group.budget, group.runs, images);
            // An image without light costs nothing and has no noise, so it would win every comparison.
            if (is_dark(images)) {
                study_.omissions.push_back({"channel " + channel.name + " of " + group.variant->name + " on " +
                                                scene.name + ", " + budget_kind_name(group.kind) + " " +
                                                number_text(group.budget, 6),
                                            "no light, although the reference has some; it is not compared"});
                continue;
            }
            for (const RegionPixels& region : regions) {
                std::optional<BudgetPoint> point = measure_group(group, images, channel, region, reference);
                if (point)
                    study_.curves[curves[{region.name, group.variant->name}]].points.push_back(std::move(*point));
            }
        }
        check_bias(study_, scene, channel, std::move(candidates), reference.mean, reference.variance);
    }

    /// A method without beauty renders neither the beauty nor the `rest` layer. Other renderers write whatever they
    /// have; their cells warn of missing layers once.
    [[nodiscard]] static bool was_not_requested(const Group& group, const ChannelInfo& channel) {
        const NamedValues& settings = group.variant->all_settings;
        const bool external =
            std::any_of(settings.begin(), settings.end(), [](const auto& each) { return each.first == "command"; });
        return std::all_of(group.runs.begin(), group.runs.end(), [&](const StudyRun* run) {
            const auto has = [&](const std::string& name) {
                return std::any_of(run->files.begin(), run->files.end(),
                                   [&](const FileRecord& file) { return file.name == name + ".mean.npy"; });
            };
            return !run->files.empty() && (external || !has("beauty")) && !has(channel.name);
        });
    }

    /// Returns whether all readable images are black; false if there are none.
    static bool is_dark(const std::vector<PixelArray>& images) {
        bool any = false;
        for (const PixelArray& image : images) {
            if (!image.values.empty() && !is_black(image)) return false;
            any = any || !image.values.empty();
        }
        return any;
    }

    static bool is_black_everywhere(const ChannelInfo& channel, const std::vector<Group>& groups) {
        for (const Group& group : groups)
            for (const StudyRun* run : group.runs)
                if (const auto image = read_mean(run->directory, channel.name); image && !is_black(*image))
                    return false;
        return true;
    }

    /// Returns the images in the order of `group.cells`. An unreadable image, or one of another size, is empty and
    /// recorded as an omission.
    std::vector<PixelArray> read_group(const Group& group, const ChannelInfo& channel, const PixelArray& shape) {
        std::vector<PixelArray> images;
        std::vector<Omission> omissions;
        for (const StudyRun* run : group.runs) {
            Result<PixelArray> image = read_mean(run->directory, channel.name);
            std::string reason;
            if (!image) reason = image.error().message;
            else if (image->values.size() != shape.values.size())
                reason = "channel " + channel.name + " has " + std::to_string(image->width) + " x " +
                         std::to_string(image->height) + " pixels; the reference has " + std::to_string(shape.width) +
                         " x " + std::to_string(shape.height);
            if (!reason.empty()) omissions.push_back({"channel " + channel.name + " of cell " + run->id, reason});
            images.push_back(reason.empty() ? std::move(*image) : PixelArray{});
        }
        // A renderer without a channel omits it in every replicate; this is reported once.
        if (omissions.size() == group.runs.size() && omissions.size() > 1)
            omissions = {{omissions.front().what + " and its other replicates", omissions.front().reason}};
        study_.omissions.insert(study_.omissions.end(), omissions.begin(), omissions.end());
        return images;
    }

    std::optional<BudgetPoint> measure_group(const Group& group, const std::vector<PixelArray>& images,
                                             const ChannelInfo& channel, const RegionPixels& region,
                                             const Reference& reference) {
        const std::vector<double> expected = selected(reference.mean, region.pixels);
        BudgetPoint point;
        point.budget = point.group.budget = group.budget;
        double mse_excess = 0;
        if (reference.variance) {
            const std::vector<double> variance = selected(*reference.variance, region.pixels);
            point.excess = display::reference_excess(display::ErrorMetric::relmse_mean, expected, variance);
            mse_excess = display::reference_excess(display::ErrorMetric::mse, expected, variance);
            if (!std::isfinite(point.excess)) point.excess = mse_excess = 0;
        }
        TailMonitor tail;
        std::vector<double> measured;
        double count = 0;
        for (std::size_t i = 0; i < images.size(); ++i) {
            if (images[i].values.empty()) continue;
            const StudyRun& run = *group.runs[i];
            const std::vector<double> values = selected(images[i], region.pixels);
            RunErrors errors{
                &run,         group.variant->name, channel.name, region.name, display::measure_errors(values, expected),
                point.excess, mse_excess};
            const double squared = errors.measures[display::ErrorMetric::relmse_mean];
            tail.add(display::relative_squares(values, expected));
            measured.push_back(squared);
            point.group.errors.push_back(squared - point.excess);
            point.group.seconds.push_back(run.seconds(experiment_.cpu_clock));
            if (run.samples_per_pixel > 0) point.group.samples.push_back(static_cast<double>(run.samples_per_pixel));
            point.group.setup_seconds += setup_of(run, experiment_.cpu_clock);
            point.seconds += run.seconds(experiment_.cpu_clock);
            point.wall_seconds += run.wall_seconds;
            point.cpu_seconds += run.cpu_seconds;
            point.samples += static_cast<double>(run.samples_per_pixel);
            count += 1;
            study_.runs.push_back(std::move(errors));
        }
        if (count == 0) return std::nullopt;
        for (double* each :
             {&point.group.setup_seconds, &point.seconds, &point.wall_seconds, &point.cpu_seconds, &point.samples})
            *each /= count;
        if (point.group.samples.size() != measured.size()) point.group.samples.clear();
        IntervalOptions options;
        options.confidence = study_.options.confidence;
        point.squared = error_interval(measured, point.excess, options);
        point.tail_index = tail.index();
        point.group.heavy_tail = tail.heavy();
        point.group.at_floor = point.excess > 0 && point.squared.value < point.excess;
        if (point.group.heavy_tail && point.squared.valid()) point.squared.note = heavy_tail_note;
        point.relative = point.squared;
        for (double* each : {&point.relative.value, &point.relative.low, &point.relative.high})
            if (!std::isnan(*each)) *each = relative_error(*each);
        point.efficiency = efficiency_interval(point.group.errors, point.group.seconds, options);
        if (!point.squared.valid() && point.efficiency.valid()) point.efficiency.note = point.squared.note;
        return point;
    }

    const Experiment& experiment_;
    Study& study_;
};

}  // namespace

std::string omitted_in(const Experiment& experiment, const std::string& scene, const std::string& variant,
                       const ChannelInfo& channel) {
    const auto source = [](const std::string& name, const std::string& expression, const std::string& dialect) {
        lpe::ChannelSource result;
        result.name = name;
        result.expression = expression;
        result.dialect = dialect == "osl" ? lpe::Dialect::osl : lpe::Dialect::renderman;
        result.origin = "channel '" + name + "'";
        return result;
    };
    for (const StudyRun& run : experiment.runs) {
        if (run.failed || run.scene != scene || variant_name(run) != variant) continue;
        for (const OmittedPathsInfo& each : run.omits) {
            const std::vector<lpe::ChannelSource> both{source(channel.name, channel.expression, channel.dialect),
                                                       source("omitted", each.expression, each.dialect)};
            lpe::PathSetOptions options;
            options.samples = 1;
            options.longest_counted = 0;
            const auto shared = lpe::look_at_paths(lpe::Operation::intersection, both, {}, options);
            if (!shared || !shared->empty()) return each.expression;
        }
        return {};  // equal in all cells of a variant
    }
    return {};
}

std::string variant_name(const StudyRun& run) {
    std::string name = run.method;
    for (const auto& [key, value] : run.settings) name += " " + key + "=" + value;
    return name;
}

Result<Study> study_of(const Experiment& experiment, const StudyReportOptions& options) {
    Study study;
    study.experiment = &experiment;
    study.options = options;
    std::set<std::string> warned;
    for (const StudyRun& run : experiment.runs) {
        for (const std::string& warning : run.warnings) {
            const std::string who = "warning of " + variant_name(run) + " on " + run.scene;
            if (warned.insert(who + "\n" + warning).second) study.omissions.push_back({who, warning});
        }
        if (run.failed) {
            study.omissions.push_back({"cell " + run.id, "failed: " + run.failure});
            continue;
        }
        const std::string name = variant_name(run);
        if (std::any_of(study.variants.begin(), study.variants.end(),
                        [&](const MethodVariant& each) { return each.name == name; }))
            continue;
        MethodVariant variant{name, run.method, run.settings, run.settings, true};
        for (const MethodInfo& method : experiment.methods) {
            if (method.name != run.method) continue;
            variant.unbiased = method.unbiased;
            if (!method.command.empty()) variant.all_settings.emplace_back("command", method.command);
            for (const auto& [key, value] : method.settings)
                if (std::none_of(run.settings.begin(), run.settings.end(),
                                 [&, &own = key](const auto& swept) { return swept.first == own; }))
                    variant.all_settings.emplace_back(key, value);
        }
        study.variants.push_back(std::move(variant));
    }
    // In the order of the config's methods, not of the interleaved plan.
    std::stable_sort(study.variants.begin(), study.variants.end(), [&](const MethodVariant& a, const MethodVariant& b) {
        const auto rank = [&](const MethodVariant& variant) {
            return std::find_if(experiment.methods.begin(), experiment.methods.end(),
                                [&](const MethodInfo& method) { return method.name == variant.method; }) -
                   experiment.methods.begin();
        };
        return rank(a) < rank(b);
    });
    for (const std::string& id : experiment.missing) {
        const auto parts = std::count_if(experiment.parts.begin(), experiment.parts.end(),
                                         [&](const StudyRun& each) { return each.part_of == id; });
        study.omissions.push_back(
            {"cell " + id, parts > 0 ? "in parts, of which " + std::to_string(parts) +
                                           " are here; 'raylex experiment merge' makes a cell of them all"
                                     : "not run yet"});
    }
    Status measured = Measurer(experiment, study).measure();
    if (!measured) return std::move(measured).error();
    measure_as_seen(study);
    check_curves(study);
    compare_variants(study);
    measure_spectra(study);
    return study;
}

}  // namespace raylex::experiments
