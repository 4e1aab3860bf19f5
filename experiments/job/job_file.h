// Reads a TOML job: all settings of the flags of `raylex render`, and labels and light groups for an unmodified scene.
// experiments/docs/rendering/jobs.md lists every key.
#pragma once

#include <string>

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Reads a job file. Paths in it are relative to the file. An unknown key, a wrong type or a value out of range is an
/// Error with line and column. Loads the job's plugins, so that the job can use their types. Does not check names that
/// depend on the scene (labels, materials).
Result<Job> read_job(const std::string& path);

/// Reads a job file (.toml), or makes the job of a scene file without further settings.
Result<Job> read_scene_or_job(const std::string& path);

/// Parses a job from memory. `path` appears in messages and is the base of relative paths.
Result<Job> parse_job(const std::string& text, const std::string& path);

}  // namespace raylex::experiments
