// The flags of raylex render, by the groups of its --help.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/cli/output_options.h"

namespace raylex::experiments {

struct RenderOptions {
    std::string input, output, statistics, resolution, integrator, sampler, filter, partition, techniques;
    std::string missing, crop, ocio, rendering_space, isa, until_error, time, checkpoint, replay, filter_mode, prune;
    std::optional<std::uint64_t> spp, seed;
    std::optional<int> threads;
    std::optional<std::int64_t> max_depth;
    std::vector<std::string> expressions, channel_files, dialects, aovs, cryptomatte, rules, layers, statistic_layers,
        plugins, effects;
    std::optional<int> cryptomatte_ranks;
    bool no_beauty = false, light_groups = false, resume = false, show_effects = false;
    OutputOptions outputs;
};

void add_render_options(CLI::App& command, RenderOptions& options);

}  // namespace raylex::experiments
