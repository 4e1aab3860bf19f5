// The flags of raylex render, in the groups of its --help.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/cli/command_output.h"
#include "experiments/cli/expression_options.h"
#include "experiments/cli/render/output_options.h"

namespace raylex::experiments {

struct RenderOptions : ExpressionOptions {
    std::string input, output, statistics, resolution, integrator, sampler, filter, techniques;
    std::string missing, crop, ocio, rendering_space, isa, until_error, time, checkpoint, replay, filter_mode, prune,
        shard;
    std::optional<std::uint64_t> spp, seed;
    std::optional<int> threads;
    std::optional<std::int64_t> max_depth;
    std::vector<std::string> aovs, declared, cryptomatte, rules, layers, statistic_layers, plugins, effects;
    std::string memory;
    std::optional<int> cryptomatte_ranks, bucket_rows;
    bool no_beauty = false, resume = false, show_effects = false;
    unsigned shards = 0;
    CommandOutputOptions commands;
    OutputOptions outputs;
};

void add_render_options(CLI::App& command, RenderOptions& options);

}  // namespace raylex::experiments
