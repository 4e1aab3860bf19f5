// The flags of raylex render for output files and their storage.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/cli/option_group.h"
#include "experiments/job/job.h"

namespace raylex::experiments {

struct OutputOptions {
    std::vector<std::string> sample_filters, display_filters, previews, storage, drivers, viewers, deep_channels;
    std::string display, view, memory_limit, deep, deep_storage, atlas, atlas_budget;
    std::optional<std::string> atlas_by;
    std::optional<int> atlas_length;
    std::optional<int> deep_samples;
    std::optional<double> deep_tolerance, exposure;
    bool deep_tidy = false, texture_rules = false;
};

void add_file_options(const OptionGroup& group, OutputOptions& options);
void add_preview_options(const OptionGroup& group, OutputOptions& options);
void add_filter_options(const OptionGroup& group, OutputOptions& options);
/// Applies the flags to the job. They override its keys; drivers, viewers and previews are added, but the first plain
/// preview replaces the job's.
Status apply_output_options(const OutputOptions& options, Job& job);

}  // namespace raylex::experiments
