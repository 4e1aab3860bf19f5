#include "experiments/propose/pilot.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "display/output/metrics/error_metrics.h"
#include "display/services/hash64.h"
#include "experiments/job/passes/pass_classes.h"

namespace raylex::experiments {
namespace {

double average(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double error_of_average(const std::vector<double>& values) {
    double squares = 0;
    for (const double value : values) squares += std::pow(value - average(values), 2);
    const auto count = static_cast<double>(values.size());
    return std::sqrt(squares / (count - 1) / count);
}

std::vector<double> mean_image(const std::vector<std::vector<double>>& images) {
    std::vector<double> mean(images.front().size());
    for (const std::vector<double>& image : images)
        for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += image[i] / static_cast<double>(images.size());
    return mean;
}

}  // namespace

Pilot::Pilot(const Job& job, const transport::BuiltScene& scene, std::array<int, 2> resolution,
             const PilotSettings& settings)
    : job_(job), scene_(scene), resolution_(resolution), settings_(settings) {
    const double scale =
        std::min(1.0, static_cast<double>(settings.longer_side) / std::max(resolution[0], resolution[1]));
    for (int& side : resolution_) side = std::max(1, static_cast<int>(std::lround(side * scale)));
}

PilotNoise Pilot::noise_of(const std::vector<std::vector<double>>& images, double scale) const {
    const std::vector<double> mean = mean_image(images);
    // The mean contains each image, so deviations from it are too small by (seeds - 1) / seeds.
    const auto seeds = static_cast<double>(images.size());
    scale *= seeds / (seeds - 1) / (brightness_ * brightness_);
    std::vector<double> terms, lights;
    for (const std::vector<double>& image : images) {
        lights.push_back(average(image));
        for (std::size_t i = 0; i < mean.size(); ++i)
            terms.push_back(scale * (image[i] - mean[i]) * (image[i] - mean[i]));
    }
    std::vector<double> sorted = terms;
    const auto kept =
        sorted.begin() + std::lround((1 - display::trimmed_share_of_terms) * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), kept, sorted.end());
    std::vector<double> of_seeds;
    for (auto term = terms.begin(); term != terms.end();) {
        double sum = 0;
        for (std::size_t i = 0; i < mean.size(); ++i, ++term) sum += *term <= *kept ? *term : 0;
        of_seeds.push_back(sum / static_cast<double>(mean.size()));
    }
    const double kept_terms = average(of_seeds), all = average(terms);
    return {kept_terms, error_of_average(of_seeds), all > 0 ? std::max(0.0, 1 - kept_terms / all) : 0, average(lights),
            error_of_average(lights)};
}

PilotNoise Pilot::noise_of(const std::vector<const PilotPass*>& passes, const std::vector<double>& samples) const {
    std::vector<std::vector<double>> sums(settings_.seeds, std::vector<double>(passes.front()->images.front().size()));
    for (std::size_t pass = 0; pass < passes.size(); ++pass)
        for (std::size_t seed = 0; seed < sums.size(); ++seed)
            for (std::size_t i = 0; i < sums[seed].size(); ++i)
                sums[seed][i] += passes[pass]->images[seed][i] * std::sqrt(passes[pass]->samples / samples[pass]);
    return noise_of(sums, 1);
}

Result<PilotPass> Pilot::measure(const transport::SceneEntity& method, const std::vector<std::string>& classes,
                                 bool all, double samples) {
    transport::RenderSettings settings;
    settings.machine = job_.settings.machine;
    settings.labels = job_.settings.labels;
    settings.paths = job_.settings.paths;
    settings.paths.integrator = method;
    settings.film = job_.settings.film;
    settings.film.crop.reset();
    settings.film.resolution = resolution_;
    settings.samples.sampler = job_.settings.samples.sampler;
    settings.samples.per_pixel = samples > 0 ? static_cast<std::uint64_t>(samples) : settings_.samples;
    settings.channels.sample_filters = job_.settings.channels.sample_filters;
    if (!all) settings.channels.takes = any_path_of(classes);
    for (const std::string& each : classes) {
        display::ChannelDefinition& channel = settings.channels.list.emplace_back();
        channel.name = "class" + std::to_string(settings.channels.list.size());
        channel.style = display::ChannelStyle::expression;
        channel.expression = each;
    }
    std::vector<std::vector<std::vector<double>>> images(classes.size() + 1);  // [the whole, class][seed]
    std::vector<double> seconds;
    for (unsigned seed = 0; seed < settings_.seeds; ++seed) {
        // Methods must not share random numbers: errors of passes by different methods are independent.
        settings.samples.seed = hash64(method.type, settings_.seed + seed);
        auto output = transport::render(scene_, settings);
        if (!output) return output.error();
        for (std::size_t i = 0; i < images.size(); ++i)
            images[i].push_back(output->frame_buffer.resolve(static_cast<display::ChannelId>(i)));
        const transport::RenderStatistics& statistics = output->statistics;
        seconds.push_back(statistics.render_cpu_seconds / static_cast<double>(statistics.camera_samples));
    }
    if (brightness_ == 0) brightness_ = average(mean_image(images.front()));
    if (!(brightness_ > 0)) return error_at({}, "the pilot has no light");
    PilotPass pass;
    pass.samples = static_cast<double>(*settings.samples.per_pixel);
    pass.whole = noise_of(images.front(), pass.samples);
    for (std::size_t i = 1; i < images.size(); ++i) pass.of_class.push_back(noise_of(images[i], pass.samples));
    pass.images = std::move(images.front());
    std::sort(seconds.begin(), seconds.end());
    pass.cpu_seconds = seconds[seconds.size() / 2];
    return pass;
}

}  // namespace raylex::experiments
