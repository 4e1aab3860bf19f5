#include "experiments/stability/suite/scene_measure.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "experiments/program/console.h"
#include "experiments/program/interrupt.h"
#include "experiments/study/analysis/distributions.h"
#include "lpe/shipped.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/render/built_scene.h"

namespace raylex::experiments {
namespace {

constexpr double default_samples = 16, default_seeds = 8;

/// The renders of one scene.
class SceneRenders {
  public:
    /// Prepares the renders. `integrator` is a type; empty: that of the case or the scene.
    static Result<SceneRenders> prepare(const SceneSubject& subject, const std::string& integrator,
                                        const Setting& setting, int threads) {
        SceneRenders renders;
        renders.component_ = subject.component;
        renders.settings_ = subject.settings;
        if (!integrator.empty()) {
            renders.settings_.paths.integrator.emplace();
            renders.settings_.paths.integrator->type = integrator;
        }
        auto samples = value(subject.samples, setting, default_samples),
             seeds = value(subject.seeds, setting, default_seeds), count = value(subject.threads, setting, threads);
        for (const Result<double>* each : {&samples, &seeds, &count}) {
            if (!*each) return each->error();
            if (!(**each >= 1 && **each <= 1e15))
                return error_at(subject.scene.location,
                                "spp, seeds and threads are " + number_text(**each) + "; expected 1 or more");
        }
        renders.settings_.samples.per_pixel = static_cast<std::uint64_t>(*samples);
        renders.settings_.machine.threads = static_cast<int>(*count);
        renders.seeds_ = static_cast<std::uint64_t>(*seeds);
        auto text = fill_in(subject.scene.text, setting, subject.scene.location);
        if (!text) return text.error();
        auto scene = transport::import_pbrt_text(*text, subject.scene.location.file);
        if (!scene) return in_case(scene.error(), subject);
        auto built = transport::BuiltScene::build(*scene, {.threads = renders.settings_.machine.threads});
        if (!built) return in_case(built.error(), subject);
        renders.scene_ = *built;
        if (Status chosen = renders.choose_channel(subject); !chosen) return chosen.error();
        return renders;
    }

    /// Renders and returns the requested channel: [pixel][component].
    Result<std::vector<double>> render(std::uint64_t seed, CaseImage* image = nullptr) {
        settings_.samples.seed = seed;
        settings_.channels.beauty = beauty_ || aov_ || image != nullptr;
        auto output = transport::render(*scene_, settings_, {}, &interrupt_flag());
        if (!output) return output.error();
        if (!output->samples.complete) return error_at({}, "interrupted");
        width_ = output->view.width;
        height_ = output->view.height;
        if (image != nullptr) {
            const std::vector<double> rgb = output->frame_buffer.resolve(output->beauty);
            *image = {width_, height_, {rgb.begin(), rgb.end()}};
        }
        return output->frame_buffer.resolve(beauty_ ? output->beauty : output->beauty + 1);  // invalid_channel is -1
    }

    /// Returns the mean of a pixel over the components that count.
    [[nodiscard]] double pixel(const std::vector<double>& values, std::size_t index) const {
        const std::size_t components = values.size() / pixels();
        const double* at = values.data() + components * index;
        if (component_ >= 0) return static_cast<std::size_t>(component_) < components ? at[component_] : NAN;
        double sum = 0;
        for (std::size_t i = 0; i < components; ++i) sum += at[i];
        return sum / double(components);
    }
    /// Renders with seed 1 and returns the beauty and the layers of the shipped partition.
    Result<std::vector<std::vector<double>>> render_split() {
        settings_.samples.seed = 1;
        settings_.channels.beauty = true;
        settings_.channels.list.clear();
        for (const lpe::NamedExpression& each : lpe::shipped_partition())
            settings_.channels.list.push_back(expression_channel(std::string(each.name), std::string(each.expression)));
        auto output = transport::render(*scene_, settings_, {}, &interrupt_flag());
        if (!output) return output.error();
        std::vector<std::vector<double>> layers;
        for (std::size_t i = 0; i <= settings_.channels.list.size(); ++i)
            layers.push_back(output->frame_buffer.resolve(output->beauty + static_cast<display::ChannelId>(i)));
        return layers;
    }

    [[nodiscard]] std::size_t pixels() const { return std::size_t(width_) * std::size_t(height_); }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] std::uint64_t seeds() const { return seeds_; }

  private:
    static Result<double> value(const CaseText& formula, const Setting& setting, double otherwise) {
        if (formula.empty()) return otherwise;
        return evaluate(formula.text, setting.numbers, formula.location);
    }
    /// Makes line numbers of errors in the scene's text relative to the case's `scene`.
    static Error in_case(Error error, const SceneSubject& subject) {
        if (error.file == subject.scene.location.file) error.line += std::max(0, subject.scene.location.line - 1);
        return error;
    }
    Status choose_channel(const SceneSubject& subject) {
        beauty_ = subject.channel == "beauty";
        if (beauty_) return success();
        auto aov = transport::named_channel(subject.channel, scene_->pattern_channels());
        aov_ = aov.ok();
        settings_.channels.list.push_back(aov_ ? *aov : expression_channel("asked", subject.channel));
        return success();
    }
    static display::ChannelDefinition expression_channel(const std::string& name, const std::string& expression) {
        display::ChannelDefinition channel;
        channel.name = name;
        channel.style = display::ChannelStyle::expression;
        channel.expression = expression;
        return channel;
    }

    std::shared_ptr<const transport::BuiltScene> scene_;
    transport::RenderSettings settings_;
    std::uint64_t seeds_ = 1;
    int width_ = 0, height_ = 0, component_ = -1;
    bool beauty_ = true;
    bool aov_ = false;  ///< rendered besides the beauty, because some AOVs count events of the beauty
};

/// Moments of the results of independent seeds.
struct Moments {
    double mean = 0, variance_of_mean = 0;
};
Moments moments_of(const std::vector<double>& values) {
    const double n = double(values.size());
    Moments moments;
    for (const double each : values) moments.mean += each / n;
    for (const double each : values)
        moments.variance_of_mean += (each - moments.mean) * (each - moments.mean) / (n * std::max(1.0, n - 1));
    return moments;
}

Result<ProbeResult> mean_of(SceneRenders& renders, CaseImage* image) {
    std::vector<double> means;
    for (std::uint64_t seed = 1; seed <= renders.seeds(); ++seed) {
        auto values = renders.render(seed, seed == 1 ? image : nullptr);
        if (!values) return values.error();
        double sum = 0;
        for (std::size_t i = 0; i < renders.pixels(); ++i) sum += renders.pixel(*values, i);
        means.push_back(sum / double(renders.pixels()));
    }
    const Moments moments = moments_of(means);
    ProbeResult result;
    result.measured = moments.mean;
    result.standard_error = std::sqrt(moments.variance_of_mean);
    result.degrees = double(means.size()) - 1;
    return result;
}

Result<ProbeResult> largest_of(SceneRenders& renders, CaseImage* image) {
    ProbeResult result;
    result.measured = -INFINITY;
    for (std::uint64_t seed = 1; seed <= renders.seeds(); ++seed) {
        auto values = renders.render(seed, seed == 1 ? image : nullptr);
        if (!values) return values.error();
        for (std::size_t i = 0; i < renders.pixels(); ++i) {
            const double value = renders.pixel(*values, i);
            if (!(value <= result.measured)) result.measured = value;  // a NaN counts as the largest
        }
    }
    return result;
}

/// Means [block][seed] of at most 8 x 8 blocks.
using BlockMeans = std::vector<std::vector<double>>;
Result<BlockMeans> block_means(SceneRenders& renders, std::uint64_t first_seed, CaseImage* image) {
    constexpr int across = 8;
    BlockMeans blocks;
    for (std::uint64_t i = 0; i < renders.seeds(); ++i) {
        auto values = renders.render(first_seed + i, i == 0 ? image : nullptr);
        if (!values) return values.error();
        const int columns = std::min(across, renders.width()), rows = std::min(across, renders.height());
        blocks.resize(std::size_t(columns) * std::size_t(rows));
        std::vector<double> sums(blocks.size()), counts(blocks.size());
        for (int y = 0; y < renders.height(); ++y)
            for (int x = 0; x < renders.width(); ++x) {
                const auto block = std::size_t(y * rows / renders.height() * columns + x * columns / renders.width());
                sums[block] += renders.pixel(*values, std::size_t(y) * std::size_t(renders.width()) + std::size_t(x));
                counts[block] += 1;
            }
        for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].push_back(sums[b] / counts[b]);
    }
    return blocks;
}

/// Welch's t test of two means: the probability of a difference at least as large by chance.
double welch_p(const Moments& a, const Moments& b, double seeds) {
    const double variance = a.variance_of_mean + b.variance_of_mean, difference = a.mean - b.mean;
    if (!(variance > 0)) return difference == 0 ? 1 : 0;
    const double degrees = variance * variance * (seeds - 1) /
                           (a.variance_of_mean * a.variance_of_mean + b.variance_of_mean * b.variance_of_mean);
    return student_t_two_sided(difference / std::sqrt(variance), degrees);
}

Result<ProbeResult> same_image(SceneRenders& one, SceneRenders& other, CaseImage* image) {
    auto a = block_means(one, 1, image);
    if (!a) return a.error();
    auto b = block_means(other, 1 + one.seeds(), nullptr);
    if (!b) return b.error();
    if (a->size() != b->size()) return error_at({}, "the two images have different sizes");
    double least = 1, mean_a = 0, mean_b = 0, variance = 0;
    for (std::size_t block = 0; block < a->size(); ++block) {
        const Moments in_a = moments_of((*a)[block]), in_b = moments_of((*b)[block]);
        const double p = welch_p(in_a, in_b, double(one.seeds()));
        least = std::min(least, p == p ? p : 0);
        mean_a += in_a.mean;
        mean_b += in_b.mean;
        variance += in_a.variance_of_mean + in_b.variance_of_mean;
    }
    ProbeResult result;
    result.measured = sidak_adjusted(least, double(a->size()));
    result.note = "means differ by " + number_text((mean_a - mean_b) / mean_b) + " +- " +
                  number_text(std::sqrt(variance) / std::abs(mean_b)) + " of themselves; " + std::to_string(a->size()) +
                  " blocks";
    return result;
}

Result<ProbeResult> same_bits(SceneRenders& one, SceneRenders& other, CaseImage* image) {
    auto a = one.render(1, image);
    if (!a) return a.error();
    auto b = other.render(1);
    if (!b) return b.error();
    if (a->size() != b->size()) return error_at({}, "the two images have different sizes");
    ProbeResult result;
    for (std::size_t i = 0; i < a->size(); ++i)
        result.measured += std::bit_cast<std::uint64_t>((*a)[i]) != std::bit_cast<std::uint64_t>((*b)[i]) ? 1 : 0;
    result.note = "of " + std::to_string(a->size()) + " values";
    return result;
}

Result<ProbeResult> split_of(SceneRenders& renders) {
    auto layers = renders.render_split();
    if (!layers) return layers.error();
    ProbeResult result;
    for (std::size_t i = 0; i < layers->front().size(); ++i) {
        const double beauty = layers->front()[i];
        double sum = 0, size = std::abs(beauty);
        for (std::size_t layer = 1; layer < layers->size(); ++layer) {
            sum += (*layers)[layer][i];
            size += std::abs((*layers)[layer][i]);
        }
        if (size > 0) result.measured = std::max(result.measured, std::abs(sum - beauty) / size);
    }
    result.note = "of " + std::to_string(layers->front().size()) + " values";
    return result;
}

Result<ProbeResult> outcome_of(const SceneSubject& subject, const std::string& integrator, const Setting& setting,
                               int threads, CaseImage* image) {
    const auto message = [](const Error& error) {
        ProbeResult result;
        result.note = "message: " + error.message;
        return result;
    };
    auto renders = SceneRenders::prepare(subject, integrator, setting, threads);
    if (!renders) return message(renders.error());
    auto values = renders->render(1, image);
    if (!values) return message(values.error());
    ProbeResult result;
    result.measured = double(std::count_if(values->begin(), values->end(), [](double v) { return !std::isfinite(v); }));
    result.note = "an image";
    return result;
}

}  // namespace

Result<ProbeResult> measure_scene(const SceneSubject& subject, std::size_t integrator, const Setting& setting,
                                  int threads, CaseImage* image) {
    const std::string type = subject.integrators.empty() ? std::string() : subject.integrators[integrator];
    if (subject.measure == SceneMeasure::outcome) return outcome_of(subject, type, setting, threads, image);
    auto renders = SceneRenders::prepare(subject, type, setting, threads);
    if (!renders) return renders.error();
    if (subject.measure == SceneMeasure::mean) return mean_of(*renders, image);
    if (subject.measure == SceneMeasure::largest) return largest_of(*renders, image);
    if (subject.measure == SceneMeasure::split) return split_of(*renders);
    Setting other_setting = setting;
    for (const auto& [name, formula] : subject.against) {
        auto value = evaluate(formula.text, setting.numbers, formula.location);
        if (!value) return value.error();
        other_setting.numbers[name] = *value;
    }
    const std::string& other_type = subject.against_integrator.empty() ? type : subject.against_integrator;
    auto other = SceneRenders::prepare(subject, other_type, other_setting, threads);
    if (!other) return other.error();
    if (subject.measure == SceneMeasure::same_bits) return same_bits(*renders, *other, image);
    return same_image(*renders, *other, image);
}

}  // namespace raylex::experiments
