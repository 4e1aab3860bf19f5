#include "transport/integrators/integrator_parameters.h"

#include <algorithm>
#include <array>

namespace raylex::transport {

std::uint32_t IntegratorParameters::max_depth(std::optional<std::int64_t> forced) {
    std::int64_t depth = take(set().integer_or("maxdepth", 5), std::int64_t{5});
    if (forced) depth = *forced;
    if (depth < 0)
        fail(error_at(entity_.location,
                      "'maxdepth' is " + std::to_string(depth) + "; expected 0 or more scattering events"));
    return static_cast<std::uint32_t>(std::clamp<std::int64_t>(depth, 0, 1'000'000));
}

Real IntegratorParameters::roulette_below() {
    const bool roulette = boolean("roulette", true);
    const double below = take(set().real_or("rrthreshold", double{default_roulette_below}), 1.0);
    if (!(below >= 0 && below <= 1))
        fail(error_at(entity_.location, "'rrthreshold' is " + std::to_string(below) +
                                            "; expected at most 1, and 0 where paths never end at random"));
    return roulette ? static_cast<Real>(below) : Real(0);
}

std::size_t IntegratorParameters::choice(std::string_view name, const std::vector<std::string>& names,
                                         std::size_t fallback) {
    const std::string found = take(set().choice_or(name, names[fallback], names), names[fallback]);
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), found) - names.begin());
}

Real IntegratorParameters::fraction(std::string_view name, Real fallback, const std::string& reason) {
    const double value = take(set().real_or(name, double{fallback}), double{fallback});
    if (!(value > 0 && value <= 1))
        fail(error_at(entity_.location, "'" + std::string(name) + "' is " + std::to_string(value) +
                                            "; expected more than 0 and at most 1" + reason));
    return static_cast<Real>(value);
}

ParameterDescription describe_max_depth() {
    return {"maxdepth", ParameterType::integer, "5",
            "scattering events at most; emission seen after the last still counts"};
}

ParameterDescription describe_roulette(const std::string& who) {
    return {"roulette", ParameterType::boolean, "true", "end weak " + who + " at random from the second bounce"};
}

ParameterDescription describe_roulette_threshold() {
    return {"rrthreshold", ParameterType::real, "0.25",
            "throughput below which roulette is played (pbrt-v4: always 1); 0: never"};
}

DepthParameters read_depth_parameters(IntegratorParameters& read, std::optional<std::int64_t> max_depth) {
    DepthParameters parameters;
    parameters.max_depth = read.max_depth(max_depth);
    parameters.roulette_below = read.roulette_below();
    return parameters;
}

std::vector<ParameterDescription> describe_depth_parameters(const std::string& who) {
    return {describe_max_depth(), describe_roulette(who), describe_roulette_threshold()};
}

GuideRequest read_guide_parameters(IntegratorParameters& read) {
    constexpr std::array<GuideMode, 3> modes{GuideMode::off, GuideMode::automatic, GuideMode::on};
    GuideRequest request;
    request.mode = modes[read.choice("guide", {"off", "auto", "on"}, 0)];
    request.samples = static_cast<std::uint32_t>(read.integer("guidesamples", 0, 0, 4096));
    return request;
}

std::vector<ParameterDescription> describe_guide_parameters() {
    return {{"guide", ParameterType::string, "off",
             "learn before the render where light comes from, and draw directions there: on; off; auto, where a "
             "forecast shows that it pays"},
            {"guidesamples", ParameterType::integer, "0",
             "samples of each pixel from which the guide learns, rounded down to a power of 2, at least 2; 0: at most "
             "a quarter of the samples or of the time limit, and at most 4096"}};
}

}  // namespace raylex::transport
