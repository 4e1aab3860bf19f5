// Helpers of the tests of the LPE services.
#pragma once

#include <vector>

#include <catch2/catch.hpp>

#include "display/services/samples/lpe_services.h"
#include "tests/services/helpers.h"

namespace raylex::test {

using display::LobePart;

/// The event classes of a few kinds of events without labels.
struct Classes {
    explicit Classes(const display::LpeSetup& setup) {
        using lpe::EventType;
        using lpe::Scatter;
        const auto scatter = [&](EventType type, Scatter how) { return setup.classify({type, how, 0, {"", ""}}); };
        const auto terminal = [&](EventType type) { return setup.classify({type, Scatter::none, 0, {""}}); };
        diffuse = scatter(EventType::reflection, Scatter::diffuse);
        glossy = scatter(EventType::reflection, Scatter::glossy);
        singular = scatter(EventType::reflection, Scatter::singular);
        diffuse_through = scatter(EventType::transmission, Scatter::diffuse);
        singular_through = scatter(EventType::transmission, Scatter::singular);
        volume = scatter(EventType::volume, Scatter::none);
        light = terminal(EventType::light);
        background = terminal(EventType::background);
        emission = terminal(EventType::emission);
        scattering = {diffuse, glossy, singular, diffuse_through, singular_through, volume};
        terminals = {light, background, emission};
    }
    lpe::EventClass diffuse, glossy, singular, diffuse_through, singular_through, volume, light, background, emission;
    std::vector<lpe::EventClass> scattering, terminals;
};

inline display::LpeSetup build_setup(const std::vector<display::ChannelDefinition>& channels, display::ChannelId beauty,
                                     const lpe::CompileOptions& options = {}) {
    Result<display::LpeSetup> setup = display::LpeSetup::build(channels, beauty, options);
    if (!setup) FAIL(setup.error().to_string());
    return std::move(*setup);
}

/// beauty, then one channel for each number of diffuse reflections below `counted`, then the rest.
///
/// A path splits over as many states as it has bounces, so these channels overflow a tracker.
inline std::vector<display::ChannelDefinition> count_diffuse(int counted) {
    std::vector<display::ChannelDefinition> channels{plain_channel("beauty", display::ChannelType::rgb)};
    for (int i = 0; i < counted; ++i) {
        std::string expression = "C";
        for (int k = 0; k < i; ++k) expression += "[^D]*D";
        channels.push_back(expression_channel(join({"d", std::to_string(i)}), join({expression, "[^D]*"})));
    }
    display::ChannelDefinition rest = expression_channel("rest", "");
    for (int i = 1; i <= counted; ++i) rest.rest_of.push_back(static_cast<std::size_t>(i));
    channels.push_back(rest);
    return channels;
}

}  // namespace raylex::test
