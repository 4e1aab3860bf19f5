#include "experiments/propose/proposal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "experiments/job/channels/generated_channels.h"
#include "experiments/job/channels/scene_path_strings.h"
#include "experiments/job/passes/pass_classes.h"
#include "experiments/program/columns.h"
#include "experiments/program/console.h"
#include "experiments/study/analysis/distributions.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/wording/event_words.h"
#include "lpe/channels/file_text.h"
#include "transport/integrators/integrator.h"
#include "transport/render/film.h"

namespace raylex::experiments {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// Passes are proposed only if their forecast beats that of the best single method by this factor. The best of several
/// forecasts is too good by chance.
constexpr double least_gain = 1.1;
/// The noise of a class counts as unseen if the worst 0.1 % of its errors have more than this part of all errors.
constexpr double most_worst_share = 0.5;
/// Samples per pixel of the last pilots; errors of more samples are extrapolated.
constexpr double most_forecast_samples = 256;

struct CoarseClass {
    std::string name, expression;  ///< in the dialect renderman
};

/// Returns a partition of all paths by first and last scattering, which decide how methods find them, and of caustics
/// by light group.
std::vector<CoarseClass> coarse_classes(const transport::SceneAlphabet& alphabet) {
    // Scattering with a density, where subpaths can be joined, and without one, as in omitted_paths.cpp.
    const std::string joint = "[<RG><TG>DV]", singular = "<[RT][^DG]>", light = "[<L.>O]";
    std::vector<CoarseClass> classes{
        {"emission", "C" + light},
        {"direct", "C" + joint + light},
        {"indirect", "C" + joint + ".*" + joint + light},
        {"indirect caustics", "C" + joint + ".*" + joint + singular + "+" + light},
        {"emission behind mirrors or glass", "C" + singular + "+" + light},
        {"direct behind mirrors or glass", "C" + singular + "+" + joint + light},
        {"indirect behind mirrors or glass", "C" + singular + "+" + joint + ".*" + joint + light},
        {"caustics behind mirrors or glass", "C" + singular + ".*" + joint + singular + "+" + light}};
    const std::vector<ExpressionRequest> groups = light_group_channels(alphabet);
    if (groups.size() == 1) classes.push_back({"caustics", "C" + joint + singular + "+" + light});
    for (const ExpressionRequest& group : groups)
        if (groups.size() > 1)
            classes.push_back(
                {"caustics of " + group.name, "(C" + joint + singular + "+.)&(" + group.expression + ")"});
    return classes;
}

/// A method with its pilot of all paths.
struct PilotMethod {
    transport::SceneEntity entity;
    PilotPass pilot;
    std::vector<double> noise;  // [class] squared error of a sample; infinite: the class is not offered
    bool is_complete = true;    // samples all paths
};

using Assignment = std::vector<std::size_t>;                       // [class] method
using PassKey = std::pair<std::size_t, std::vector<std::size_t>>;  // method, classes

/// Passes with their numbers of samples per pixel.
struct PassForecast {
    std::vector<PassKey> keys;
    std::vector<double> samples;
    PilotNoise error;  ///< of the sum
    double time = 0;   ///< CPU seconds of one pixel
};

std::string interval_text(double value, double low, double high) {
    return number_text(value) + " [" + number_text(low) + ", " + number_text(high) + "]";
}

std::string class_row(const std::string& name, const std::string& method, const std::string& samples,
                      const std::string& error, const std::string& unseen) {
    return "# " + padded(name, 34) + padded(method, 13) + padded(samples, 9) +
           (unseen.empty() ? error : padded(error, 32) + unseen) + "\n";
}

class Proposer {
  public:
    Proposer(const JobScene& scene, const PilotSettings& settings, Pilot pilot)
        : scene_(scene), settings_(settings), pilot_(std::move(pilot)) {}

    Status measure_methods(Job job, const transport::BuiltScene& built) {
        job.settings.paths.integrator = transport::SceneEntity{};  // all methods have the paths of this one
        job.settings.paths.integrator->type = "path";
        auto words = scene_path_strings(job, scene_.scene, &built);
        if (!words) return words.error();
        for (CoarseClass& each : coarse_classes(words->alphabet)) {
            const auto path = lpe::find_path_string({.name = each.name, .expression = each.expression}, words->words);
            if (!path) return path.error();
            if (*path) classes_.push_back(std::move(each));
        }
        // bdpt is the first: errors are relative to its light, because it samples all that any of the three samples.
        for (const char* type : {"bdpt", "path", "lighttracer"})
            if (Status added = add_method(type, words->words); !added) return added;
        if (methods_.empty())
            return error_at({job.scene_file, 0, 0},
                            "no pilot has light; expected an image that is not black, or more --pilot-samples", notes_);
        offer_classes();
        choose_single();
        if (single_ == none) return error_at({}, "no method samples all paths of this scene", notes_);
        return success();
    }

    /// Measures the best assignment to each set of several methods.
    Status find_passes(double samples) {
        time_ = samples * single().cpu_seconds;
        Assignment alone(classes_.size(), single_);
        measured_[passes_of(alone).front()] = single();
        best_ = forecast_of(passes_of(alone));
        for (unsigned among = 1; among < 1U << methods_.size(); ++among) {
            const std::vector<PassKey> keys = passes_of(descend(among));
            if (keys.size() < 2) continue;
            for (const PassKey& key : keys)
                if (Status done = measure(key); !done) return done;
            PassForecast found = forecast_of(keys);
            const double gain = best_.keys.size() < 2 ? least_gain : 1.02;  // more passes must pay
            if (found.error.squared * found.time * gain < best_.error.squared * best_.time) best_ = std::move(found);
        }
        return success();
    }

    /// Measures the chosen passes and the best single method again, with their own numbers of samples: the error of
    /// Sobol' points falls faster than 1 / samples. Returns to the single method if it is not beaten.
    Status confirm(double samples) {
        const PassKey alone = passes_of(Assignment(classes_.size(), single_)).front();
        if (Status done = measure(alone, samples); !done) return done;
        methods_[single_].pilot = measured_.at(alone);
        for (std::size_t k = 0; k < best_.keys.size() && best_.keys.size() > 1; ++k)
            if (Status done = measure(best_.keys[k], best_.samples[k]); !done) return done;
        time_ = samples * single().cpu_seconds;
        best_ = forecast_of(best_.keys);
        PassForecast other = forecast_of({alone});
        if (best_.error.squared * best_.time * least_gain > other.error.squared * other.time) best_ = std::move(other);
        return success();
    }

    [[nodiscard]] std::string text(double pixels) const {
        const auto largest =
            std::max_element(best_.keys.begin(), best_.keys.end(),
                             [](const PassKey& a, const PassKey& b) { return a.second.size() < b.second.size(); });
        std::string rows = class_row("class", "method", "samples", "squared error", "unseen noise of"), passes, tables;
        const auto add_pass = [&](const std::string& name, double seconds, const PilotNoise& noise, double samples) {
            passes += "# " + name + ": " + number_text(seconds * pixels) + " CPU s, squared error " +
                      error_text(noise, samples) + "\n";
        };
        for (std::size_t k = 0; k < best_.keys.size(); ++k) {
            const PassKey& key = best_.keys[k];
            const PilotPass& pass = measured_.at(key);
            const std::string &method = methods_[key.first].entity.type, count = number_text(best_.samples[k], 10);
            for (std::size_t i = 0; i < key.second.size(); ++i)
                rows += class_row(classes_[key.second[i]].name, method, count,
                                  error_text(pass.of_class[i], best_.samples[k]),
                                  lpe::joined_by(unseen_[key.second[i]], " and "));
            add_pass(method, best_.samples[k] * pass.cpu_seconds, pass.whole, best_.samples[k]);
            tables += "\n[[pass]]\nmethod = " + lpe::quoted(method) +
                      "\ntakes = " + lpe::quoted(key == *largest ? "rest" : any_path_of(expressions_of(key))) +
                      "\nspp = " + count + "\n";
        }
        const std::string alone = methods_[single_].entity.type + " alone";
        if (best_.keys.size() > 1) {
            const PilotNoise &error = best_.error, &other = single().whole;
            const double samples = best_.time / single().cpu_seconds, gain = other.squared / samples / error.squared;
            const double width = std::exp(std::hypot(half_of(error) / error.squared, half_of(other) / other.squared));
            add_pass("all passes", best_.time, error, 1);
            add_pass(alone, best_.time, other, samples);
            passes +=
                "# efficiency relative to " + alone + ": " + interval_text(gain, gain / width, gain * width) + "\n";
        } else {
            passes += "# No passes are forecast to beat " + alone + " by a factor of " + number_text(least_gain) + "\n";
        }
        return "# Forecast from pilots of " + std::to_string(pilot_.resolution()[0]) + " x " +
               std::to_string(pilot_.resolution()[1]) + " pixels and " + std::to_string(settings_.seeds) +
               " seeds. Errors are squared and relative to the squared mean pixel,\n# each without its worst 0.1 %; in "
               "brackets the 95 % interval.\n" +
               rows + passes + lpe::commented(notes_, "# ") + tables;
    }

  private:
    static constexpr std::size_t none = static_cast<std::size_t>(-1);
    static constexpr double most_samples = 2147483647;  // of a pixel, in a job

    [[nodiscard]] const PilotPass& single() const { return methods_[single_].pilot; }

    /// Returns the product of squared error and CPU time.
    static double product_of(const PilotPass& pass) { return pass.whole.squared * pass.cpu_seconds; }

    Status add_method(const std::string& type, const lpe::PathStrings& words) {
        PilotMethod method;
        method.entity.type = type;
        method.entity = transport::integrator_for(method.entity, scene_.scene.integrator);
        PassKey all{0, {}};
        for (std::size_t i = 0; i < classes_.size(); ++i) all.second.push_back(i);
        print_note("pilot of all paths by " + type);
        auto pilot = pilot_.measure(method.entity, expressions_of(all), true);
        if (!pilot) {
            notes_ += type + " is not measured: " + pilot.error().message + "\n";
            return success();
        }
        method.pilot = *std::move(pilot);
        for (std::size_t i = 0; i < classes_.size(); ++i) {
            auto missed = find_missed_path(classes_[i].expression, method.entity, scene_.scene, words);
            if (!missed) return missed.error();
            // A class without noise must not get a pass of its own.
            const double noise = std::max(method.pilot.of_class[i].squared, 1e-4 * method.pilot.whole.squared);
            method.noise.push_back(*missed ? infinite : noise);
            method.is_complete = method.is_complete && !*missed;
        }
        methods_.push_back(std::move(method));
        return success();
    }

    [[nodiscard]] std::vector<std::string> expressions_of(const PassKey& key) const {
        std::vector<std::string> expressions;
        for (const std::size_t each : key.second) expressions.push_back(classes_[each].expression);
        return expressions;
    }

    /// Returns whether the pilot of a method has less light of a class than that of another method.
    [[nodiscard]] bool lacks_light(const PilotMethod& method, std::size_t of_class) const {
        const PilotNoise& noise = method.pilot.of_class[of_class];
        return std::any_of(methods_.begin(), methods_.end(), [&](const PilotMethod& other) {
            const PilotNoise& more = other.pilot.of_class[of_class];
            return noise.light < 0.9 * more.light &&
                   more.light - noise.light > 4 * std::hypot(noise.light_error, more.light_error);
        });
    }

    /// Withdraws classes from methods whose noise the pilots did not see: the method lacks light, or few pixels have
    /// most of the noise. If no method shows the noise of a class, those that lack no light and have the least part of
    /// the noise in few pixels keep the class.
    void offer_classes() {
        for (std::size_t i = 0; i < classes_.size(); ++i) {
            std::vector<PilotMethod*> able, blind, lacking;
            unseen_.emplace_back();
            for (PilotMethod& each : methods_) {
                if (each.noise[i] == infinite) continue;
                const bool lacks = lacks_light(each, i);
                (lacks ? lacking : able).push_back(&each);
                if (!lacks && each.pilot.of_class[i].worst_share > most_worst_share) blind.push_back(&each);
                if (lacks || (!blind.empty() && blind.back() == &each)) unseen_.back().push_back(each.entity.type);
            }
            for (PilotMethod* each : lacking) each->noise[i] = infinite;
            double robust = infinite;  // the least part, plus what equal methods may differ by
            if (blind.size() == able.size())
                for (const PilotMethod* each : able)
                    robust = std::min(robust, each->pilot.of_class[i].worst_share + 0.05);
            for (PilotMethod* each : blind)
                if (robust == infinite || each->pilot.of_class[i].worst_share > robust) each->noise[i] = infinite;
        }
    }

    /// Chooses the best of the methods that sample all paths: one that shows the noise of as many classes as possible.
    void choose_single() {
        const auto worse = [&](const PilotMethod& method) {
            return std::pair(std::count(method.noise.begin(), method.noise.end(), infinite), product_of(method.pilot));
        };
        for (std::size_t i = 0; i < methods_.size(); ++i)
            if (methods_[i].is_complete && (single_ == none || worse(methods_[i]) < worse(methods_[single_])))
                single_ = i;
    }

    /// Returns the product of squared error and CPU time with the best numbers of samples: (sum of sqrt(noise x
    /// cost))^2. Infinite if a class is not offered.
    [[nodiscard]] double product_of(const Assignment& assignment) const {
        std::vector<double> noise(methods_.size());
        for (std::size_t i = 0; i < classes_.size(); ++i) noise[assignment[i]] += methods_[assignment[i]].noise[i];
        double root = 0;
        for (std::size_t j = 0; j < methods_.size(); ++j) root += std::sqrt(noise[j] * methods_[j].pilot.cpu_seconds);
        return root * root;
    }

    /// Returns the assignment to the methods in `among` (a bit for each) that no change of one class improves; empty if
    /// they do not sample all classes.
    [[nodiscard]] Assignment descend(unsigned among) const {
        std::vector<std::size_t> chosen;
        for (std::size_t j = 0; j < methods_.size(); ++j)
            if ((among >> j & 1) != 0) chosen.push_back(j);
        Assignment assignment;
        for (std::size_t i = 0; i < classes_.size(); ++i)
            assignment.push_back(*std::min_element(chosen.begin(), chosen.end(), [&](std::size_t a, std::size_t b) {
                return methods_[a].noise[i] * methods_[a].pilot.cpu_seconds <
                       methods_[b].noise[i] * methods_[b].pilot.cpu_seconds;
            }));
        double least = product_of(assignment);
        if (least == infinite) return {};
        for (bool is_better = true; is_better;) {
            is_better = false;
            for (std::size_t i = 0; i < classes_.size(); ++i)
                for (const std::size_t j : chosen) {
                    Assignment other = assignment;
                    other[i] = j;
                    const double product = product_of(other);
                    if (product >= least * (1 - 1e-9)) continue;  // no cycles by rounding
                    least = product;
                    assignment = std::move(other);
                    is_better = true;
                }
        }
        return assignment;
    }

    [[nodiscard]] std::vector<PassKey> passes_of(const Assignment& assignment) const {
        std::map<std::size_t, std::vector<std::size_t>> classes;
        for (std::size_t i = 0; i < assignment.size(); ++i) classes[assignment[i]].push_back(i);
        return {classes.begin(), classes.end()};
    }

    /// Measures a pass, pruned to its classes; again if the number of samples is given.
    Status measure(const PassKey& key, double samples = 0) {
        if (samples == 0 && measured_.contains(key)) return success();
        const bool all = key.second.size() == classes_.size();
        print_note("pilot of " + counted(key.second.size(), "class", "classes") + " of paths by " +
                   methods_[key.first].entity.type);
        auto pass = pilot_.measure(methods_[key.first].entity, expressions_of(key), all,
                                   std::min(samples, most_forecast_samples));
        if (!pass) return pass.error();
        measured_[key] = *std::move(pass);
        return success();
    }

    /// Returns passes with the best numbers of samples for the CPU time, which are proportional to sqrt(noise / cost).
    [[nodiscard]] PassForecast forecast_of(std::vector<PassKey> keys) const {
        PassForecast result;
        std::vector<const PilotPass*> passes;
        double roots = 0;
        for (const PassKey& key : keys) {
            passes.push_back(&measured_.at(key));
            roots += std::sqrt(product_of(*passes.back()));
        }
        for (const PilotPass* each : passes) {
            const double best = roots > 0 ? time_ / roots * std::sqrt(each->whole.squared / each->cpu_seconds) : 1;
            result.samples.push_back(std::clamp(std::round(best), 1.0, most_samples));
            result.time += result.samples.back() * each->cpu_seconds;
        }
        result.error = pilot_.noise_of(passes, result.samples);
        result.keys = std::move(keys);
        return result;
    }

    /// Half of the 95 % interval of a squared error.
    [[nodiscard]] double half_of(const PilotNoise& noise) const {
        return student_t_quantile(0.975, settings_.seeds - 1) * noise.standard_error;
    }

    [[nodiscard]] std::string error_text(const PilotNoise& noise, double samples) const {
        return interval_text(noise.squared / samples, std::max(0.0, noise.squared - half_of(noise)) / samples,
                             (noise.squared + half_of(noise)) / samples);
    }

    const JobScene& scene_;
    const PilotSettings& settings_;
    Pilot pilot_;
    std::vector<CoarseClass> classes_;
    std::vector<PilotMethod> methods_;
    std::size_t single_ = none;                     // the best of the methods that sample all paths
    std::vector<std::vector<std::string>> unseen_;  // [class] methods whose noise the pilots did not see
    std::map<PassKey, PilotPass> measured_;
    double time_ = 0;  // CPU seconds of one pixel
    PassForecast best_;
    std::string notes_;  // methods that were not measured, a line each
};

}  // namespace

Result<std::string> propose_passes(const Job& job, const JobScene& scene, const transport::BuiltScene& built,
                                   std::uint64_t samples, const PilotSettings& settings) {
    std::vector<Error> ignored;
    const auto film = transport::read_film(scene.scene.film, job.settings.film.resolution, ignored);
    if (!film) return film.error();
    Proposer proposer(scene, settings, Pilot(job, built, {film->width, film->height}, settings));
    if (Status measured = proposer.measure_methods(job, built); !measured) return measured.error();
    if (Status found = proposer.find_passes(static_cast<double>(samples)); !found) return found.error();
    if (Status confirmed = proposer.confirm(static_cast<double>(samples)); !confirmed) return confirmed.error();
    const display::PixelRegion whole{0, 0, film->width, film->height},
        region = job.settings.film.crop.value_or(film->crop.value_or(whole));
    return proposer.text(static_cast<double>(region.width()) * static_cast<double>(region.height()));
}

}  // namespace raylex::experiments
