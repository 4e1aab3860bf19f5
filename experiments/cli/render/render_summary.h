// The summary that a render prints at its end.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "experiments/cli/render/render_outputs.h"
#include "experiments/job/job.h"
#include "experiments/job/rendering/statistics.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// All data of the summary.
struct RenderSummary {
    const Job& job;
    const transport::RenderOutput& output;
    const display::ExrImage& image;  ///< as read back from the file
    std::span<const display::SplitResult> splits;
    const std::optional<display::DeepCheck>& deep;
    const std::optional<display::AtlasCheck>& atlas;
    const std::vector<std::string>& beauties;  ///< layers that accept every path of the scene
    std::vector<std::string> files;            ///< all files except the image
    const std::map<std::string, PhaseTime>& phases;
};

/// Prints the results of checks, the files, the sampling and the times, one line each.
void print_summary(const RenderSummary& of);

}  // namespace raylex::experiments
