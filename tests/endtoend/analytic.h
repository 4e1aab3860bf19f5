// Scenes with closed-form results, and the measured means and standard errors to compare with them.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/render/render.h"

namespace raylex::test {

inline transport::SceneDescription import_text(const std::string& text) {
    auto scene = transport::import_pbrt_text(text, "analytic.pbrt");
    INFO((scene ? std::string() : scene.error().to_string()));
    REQUIRE(scene.ok());
    return std::move(*scene);
}

inline display::ChannelDefinition lpe_channel(const std::string& name, const std::string& expression) {
    display::ChannelDefinition channel;
    channel.name = name;
    channel.style = display::ChannelStyle::expression;
    channel.expression = expression;
    channel.statistics = true;
    return channel;
}

inline transport::RenderOutput render_or_fail(const transport::SceneDescription& scene,
                                              const transport::RenderSettings& settings) {
    auto output = transport::render(scene, settings);
    INFO((output ? std::string() : output.error().to_string()));
    REQUIRE(output.ok());
    return std::move(*output);
}

/// Returns the mean of a channel's first component over the image, and its standard error from the variances of the
/// pixels. Pixels are independent; with a stratified sampler the standard error is an overestimate.
struct Estimate {
    double mean = 0, standard_error = 0;
};

inline Estimate image_mean(const transport::RenderOutput& output, display::ChannelId id) {
    const std::vector<double> values = output.frame_buffer.resolve(id);
    const std::vector<double> variances = output.frame_buffer.resolve_variance_of_mean(id);
    const std::size_t pixels = values.size() / 3;
    Estimate result;
    double variance = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        result.mean += values[3 * i];
        variance += variances[3 * i];
    }
    result.mean /= double(pixels);
    result.standard_error = std::sqrt(variance) / double(pixels);
    return result;
}

/// Returns the id of the i-th requested channel. Requested channels follow the beauty if there is one.
inline display::ChannelId requested(const transport::RenderOutput& output, std::size_t index) {
    return static_cast<display::ChannelId>(index) + (output.beauty >= 0 ? output.beauty + 1 : 0);
}

/// Returns all words C x1 ... xk T with letters from `letters`, k <= longest - 2.
inline std::vector<std::string> words(const std::string& letters, std::size_t longest, const std::string& terminal) {
    std::vector<std::string> middles{""}, result;
    for (std::size_t begin = 0, k = 0; k + 2 <= longest; ++k) {
        const std::size_t end = middles.size();
        for (std::size_t i = begin; i < end; ++i) {
            result.push_back("C" + middles[i] + terminal);
            for (const char letter : letters) middles.push_back(middles[i] + letter);
        }
        begin = end;
    }
    return result;
}

}  // namespace raylex::test
